/*
** Interpolates a grid at places: csrc/grid/sample_kernel.h says what the 32 weights of a cell's corners are.
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

struct Axis {
  float l[2], s[2], k[2];
};

Axis values(float t, float edge) {
  float u = 1.0 - t, s = INTERPOLATION == 0 ? t * u * (u - t) : 0.0;
  float k = INTERPOLATION == 0 ? edge * t * u * u : INTERPOLATION == 1 ? edge * t * u : 0.0;
  return Axis(float[](u, t), float[](s, -s), float[](k, INTERPOLATION == 0 ? -edge * t * t * u : -k));
}

Axis slopes(float t, float edge) {
  float u = 1.0 - t, rate = 1.0 / edge, s = INTERPOLATION == 0 ? rate * (1.0 - 6.0 * t * u) : 0.0;
  float k = INTERPOLATION == 0 ? u * (u - 2.0 * t) : INTERPOLATION == 1 ? u - t : 0.0;
  return Axis(float[](-rate, rate), float[](s, -s), float[](k, INTERPOLATION == 0 ? t * (t - 2.0 * u) : -k));
}

/* Weights of a point's value (set 0) or derivative along axis set - 1. */
void weights(uint p, uint set, uint k, vec3 t) {
  Axis f[3];
  for (int a = 0; a < 3; a++) {
    float edge = float(cell[k].edge) * unit[a];
    f[a] = set == a + 1 ? slopes(t[a], edge) : values(t[a], edge);
  }
  uint at = (p * SETS + set) * 32;
  for (uint c = 0; c < 8; c++) {
    uint i = c & 1, j = c >> 1 & 1, m = c >> 2;
    float ll = f[1].l[j] * f[2].l[m], xl = f[0].l[i] * f[2].l[m], xy = f[0].l[i] * f[1].l[j];
    weight[at + c] = (f[0].l[i] + f[0].s[i]) * ll + (f[1].s[j] * xl + f[2].s[m] * xy);
    weight[at + 8 + c] = f[0].k[i] * ll;
    weight[at + 16 + c] = f[1].k[j] * xl;
    weight[at + 24 + c] = f[2].k[m] * xy;
  }
}

void main() {
  uint begin = ylm_group(first) * POINTS, points = min(POINTS, n - begin);
  for (uint q = gl_LocalInvocationID.x; q < points * SETS; q += gl_WorkGroupSize.x) {
    uint p = q / SETS, set = q % SETS;
    uvec4 x = place[begin + p];
    uint k = x.x;
    if (set == 0) from[p] = k;
    if (k != NONE) weights(p, set, k & ~AWAY, uintBitsToFloat(x.yzw));
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
