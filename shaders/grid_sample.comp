/*
** Interpolates a grid at places: shaders/gen/interpolation.glsl has the 32 weights of a cell's corners.
** A group has POINTS points: first their weights, then every coefficient of all of them.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "grid.glsl"

layout(constant_id = 1) const uint INTERPOLATION = 0; /* hermite, taylor, linear */
layout(constant_id = 2) const bool GRADIENT = false;
const uint POINTS = 8, SETS = GRADIENT ? 4 : 1, ROWS = INTERPOLATION == 2 && !GRADIENT ? 8 : 32;

layout(set = 0, binding = 0) readonly buffer Cells { Cell cell[]; };
layout(set = 0, binding = 1) readonly buffer Data { float data[]; }; /* [points][4][stride] */
layout(set = 0, binding = 2) readonly buffer Places { uvec4 place[]; };
layout(set = 0, binding = 3) writeonly buffer Values { float value[]; };       /* [n][width] */
layout(set = 0, binding = 4) writeonly buffer Gradients { float gradient[]; }; /* [n][width][3] */
PUSH {
  uint first;
  uint n, width, stride, nan_outside;
  float unit[3]; /* a lattice cell in scene units */
};

shared float weight[POINTS * SETS * 32];
shared uint from[POINTS];

#include "grid_weights.glsl"

void main() {
  uint begin = ylm_group(first) * POINTS, points = min(POINTS, n - begin);
  for (uint q = gl_LocalInvocationID.x; q < points * SETS; q += gl_WorkGroupSize.x) {
    uint p = q / SETS, set = q % SETS;
    uvec4 x = place[begin + p];
    uint k = x.x;
    if (set == 0) from[p] = k;
    if (k != NONE) weights(q * 32, set, k & ~AWAY, uintBitsToFloat(x.yzw));
  }
  barrier();
  for (uint q = gl_LocalInvocationID.x; q < points * width; q += gl_WorkGroupSize.x) {
    uint p = q / width, j = q % width, k = from[p];
    if (k == NONE) continue;
    bool none = (k & AWAY) != 0 && nan_outside != 0;
    k &= ~AWAY;
    vec4 sum = vec4(0.0);
    for (uint r = 0; r < ROWS; r++) {
      float x = data[(cell[k].corner[r & 7] * 4 + (r >> 3)) * stride + j];
      for (uint set = 0; set < SETS; set++) sum[set] += weight[(p * SETS + set) * 32 + r] * x;
    }
    if (none) sum = vec4(uintBitsToFloat(0x7fc00000));
    uint at = (begin + p) * width + j;
    value[at] = sum.x;
    if (GRADIENT)
      for (uint a = 0; a < 3; a++) gradient[3 * at + a] = sum[a + 1];
  }
}
