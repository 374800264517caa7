/*
** Distances of cells' interpolants from the values at some places: relative distances of rows of values, as
** refiner_distance has them in csrc/grid/promise/residual.c. Eight invocations make one.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(constant_id = 1) const uint INTERPOLATION = 0; /* Hermite */
layout(constant_id = 2) const uint HELD = 0;          /* compared with rows of `held`, else with the grid's points */

PUSH {
  uint first;
  uint n, stride, part_rows, width;
  float unit[3];
};

#include "grid_rows.glsl"

/* ylm_grid_probe; grid_weights.glsl asks for a cell's edge */
struct Probe {
  uint corner[8], edge, point;
  float t[3];
};

layout(set = 0, binding = 4) readonly buffer Probes { Probe cell[]; };
layout(set = 0, binding = 5) readonly buffer Held { float held[]; }; /* [n][width] */
layout(set = 0, binding = 6) writeonly buffer Distances { float distance_of[]; };

const uint EACH = 8, PROBES = 8; /* invocations of a probe, probes of a group */

shared float weight[PROBES * 33];
shared vec3 part[PROBES * EACH]; /* a scale, and sums of squares over its square: numbers may be of any size */

#include "grid_weights.glsl"
#include "gen/cells.glsl"

vec3 add(vec3 a, vec3 b) {
  vec3 large = a.x >= b.x ? a : b, small = a.x >= b.x ? b : a;
  float ratio = small.x > 0.0 ? small.x / large.x : 0.0;
  return vec3(large.x, large.yz + small.yz * (ratio * ratio));
}

void main() {
  uint lane = gl_LocalInvocationID.x, own = lane / EACH, begin = ylm_group(first) * PROBES, i = begin + own;
  if (lane < PROBES && begin + lane < n) {
    uint k = begin + lane;
    weights(lane * 33, 0, k, vec3(cell[k].t[0], cell[k].t[1], cell[k].t[2]));
  }
  barrier();
  vec3 sum = vec3(0.0);
  for (uint j = lane % EACH; i < n && j < width; j += EACH) {
    float x = 0.0, exact = HELD != 0 ? held[cell[i].point * width + j] : grid_data(cell[i].point, 0, j);
    for (uint r = 0; r < 32; r++) x += weight[own * 33 + r] * grid_data(cell[i].corner[r & 7], r >> 3, j);
    float d = x - exact, scale = max(abs(d), abs(exact));
    if (scale > 0.0) sum = add(sum, vec3(scale, (d / scale) * (d / scale), (exact / scale) * (exact / scale)));
  }
  part[lane] = sum;
  barrier();
  if (i >= n || lane % EACH != 0) return;
  for (uint k = 1; k < EACH; k++) sum = add(sum, part[lane + k]);
  distance_of[i] = relative_distance(sum.y, sum.z);
}
