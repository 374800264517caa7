/*
** Points that only continuity needs: the interpolants of cells at places of their half-edge lattices, csrc/grid/
** bake/continuity.c. Cells of one level, whose corners are there. Eight invocations
** make a point.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "grid.glsl"
#define WRITES_ROWS

layout(constant_id = 1) const uint INTERPOLATION = 0; /* Hermite */

PUSH {
  uint first;
  uint n, begin, stride, part_rows;
  float unit[3];
};

#include "grid_rows.glsl"

layout(set = 0, binding = 4) readonly buffer Cells { Cell cell[]; };
layout(set = 0, binding = 5) readonly buffer Births { uint birth[]; }; /* [..][3]: cell, place 0 .. 26, row */

const uint EACH = 8, POINTS = 8; /* invocations of a point, points of a group */

shared float weight[POINTS * 4 * 33];

#include "grid_weights.glsl"

void main() {
  uint lane = gl_LocalInvocationID.x, own = lane / EACH, group = ylm_group(first) * POINTS, to = group + lane / 4;
  if (to < n && lane < 4 * POINTS) {
    uint place = birth[3 * (begin + to) + 1];
    weights(lane * 33, lane % 4, birth[3 * (begin + to)], 0.5 * vec3(place % 3, place / 3 % 3, place / 9));
  }
  barrier();
  if (group + own >= n) return;
  uint i = 3 * (begin + group + own), k = birth[i];
  for (uint j = lane % EACH; j < stride; j += EACH) {
    vec4 sum = vec4(0.0);
    for (uint r = 0; r < 32; r++) {
      uint at = 4 * own * 33 + r;
      vec4 w = vec4(weight[at], weight[at + 33], weight[at + 66], weight[at + 99]);
      if (w != vec4(0.0)) sum += w * grid_data(cell[k].corner[r & 7], r >> 3, j); /* at halves most are 0 */
    }
    for (uint set = 0; set < 4; set++) put_data(birth[i + 2], set, j, sum[set]);
  }
}
