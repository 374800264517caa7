/* sampling.c - frames and low-discrepancy numbers. */
#include <math.h>

#include "scene.h"

void ylm_scene_basis(const float n[3], float a[3], float b[3]) {
  float s = copysignf(1, n[2]), p = -1 / (s + n[2]), q = n[0] * n[1] * p;
  a[0] = 1 + s * n[0] * n[0] * p;
  a[1] = s * q;
  a[2] = -s * n[0];
  b[0] = q;
  b[1] = s + n[1] * n[1] * p;
  b[2] = -n[1];
}

double ylm_scene_radical(uint32_t i) {
  i = i << 16 | i >> 16;
  i = (i & 0x00ff00ffu) << 8 | (i & 0xff00ff00u) >> 8;
  i = (i & 0x0f0f0f0fu) << 4 | (i & 0xf0f0f0f0u) >> 4;
  i = (i & 0x33333333u) << 2 | (i & 0xccccccccu) >> 2;
  i = (i & 0x55555555u) << 1 | (i & 0xaaaaaaaau) >> 1;
  return i * 0x1p-32;
}
