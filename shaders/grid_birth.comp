/*
** Points that only continuity needs: the interpolants of cells at places of their half-edge lattices, csrc/grid/
** continuity.c. Cells of one level, whose corners are there. A group makes one point.
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

shared float weight[4 * 33];

#include "grid_weights.glsl"

void main() {
  uint i = begin + ylm_group(first), lane = gl_LocalInvocationID.x, k = birth[3 * i], place = birth[3 * i + 1];
  if (ylm_group(first) >= n) return;
  vec3 t = 0.5 * vec3(place % 3, place / 3 % 3, place / 9);
  if (lane < 4) weights(lane * 33, lane, k, t);
  barrier();
  for (uint j = lane; j < stride; j += gl_WorkGroupSize.x) {
    vec4 sum = vec4(0.0);
    for (uint r = 0; r < 32; r++) {
      float x = grid_data(cell[k].corner[r & 7], r >> 3, j);
      for (uint set = 0; set < 4; set++) sum[set] += weight[set * 33 + r] * x;
    }
    for (uint set = 0; set < 4; set++) put_data(birth[3 * i + 2], set, j, sum[set]);
  }
}
