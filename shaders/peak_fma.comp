/* Sixteen independent chains of fused multiplications and additions: how fast the device computes at best. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(set = 0, binding = 0) writeonly buffer Out { float result[]; };
PUSH {
  uint first;
  uint n, steps; /* of 16 multiplications and additions each; 16 at a turn, or else the loop is what is measured */
  float a, b;
};

#define STEP x = fma(x, p, q); y = fma(y, p, q); z = fma(z, p, q); w = fma(w, p, q);
#define FOUR STEP STEP STEP STEP

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  vec4 x = vec4(i), y = x + 1.0, z = x + 2.0, w = x + 3.0, p = vec4(a), q = vec4(b);
  for (uint k = 0; k < steps; k += 16) {
    FOUR FOUR FOUR FOUR
  }
  result[i] = dot(x + y, z + w);
}
