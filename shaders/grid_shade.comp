/*
** Radiance of shading points under a grid: its interpolant, dotted with transfer vectors. A group has POINTS points
** and as many lanes for each; shaders/gen/interpolation.glsl has the 32 weights of a cell's corners.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "grid.glsl"

layout(constant_id = 1) const uint INTERPOLATION = 0; /* hermite, taylor, linear */
layout(constant_id = 2) const uint CHANNELS = 3;
const uint POINTS = 8, LANES = 8, ROWS = INTERPOLATION == 2 ? 8 : 32;

layout(set = 0, binding = 0) readonly buffer Cells { Cell cell[]; };
layout(set = 0, binding = 1) readonly buffer Data { float data[]; }; /* [points][4][stride] */
layout(set = 0, binding = 2) readonly buffer Places { uvec4 place[]; };
layout(set = 0, binding = 3) readonly buffer Transfer { float transfer[]; }; /* [n][row] */
layout(set = 0, binding = 4) writeonly buffer Radiance { float radiance[]; }; /* [n][3] */
PUSH {
  uint first;
  uint n, stride, given, row, count; /* coefficients of a channel, of a transfer vector, of both */
  float unit[3];                     /* a lattice cell in scene units */
};

shared float weight[POINTS * 32];
shared vec3 part[POINTS * LANES];

#include "grid_weights.glsl"

void main() {
  uint lane = gl_LocalInvocationID.x, p = lane / LANES, i = ylm_group(first) * POINTS + p;
  uvec4 x = i < n ? place[i] : uvec4(NONE, 0, 0, 0);
  bool here = x.x != NONE;
  uint k = x.x & ~AWAY;
  if (here && lane % LANES == 0) weights(p * 32, 0, k, uintBitsToFloat(x.yzw));
  barrier();
  vec3 sum = vec3(0.0);
  for (uint j = lane % LANES; here && j < count; j += LANES) {
    vec3 L = vec3(0.0);
    for (uint r = 0; r < ROWS; r++) {
      uint at = (cell[k].corner[r & 7] * 4 + (r >> 3)) * stride + j;
      for (uint c = 0; c < CHANNELS; c++) L[c] += weight[p * 32 + r] * data[at + c * given];
    }
    sum += transfer[i * row + j] * L;
  }
  part[lane] = sum;
  barrier();
  if (!here || lane % LANES != 0) return;
  for (uint q = 1; q < LANES; q++) sum += part[lane + q];
  for (uint c = 0; c < 3; c++) radiance[3 * i + c] = sum[CHANNELS == 1 ? 0 : c];
}
