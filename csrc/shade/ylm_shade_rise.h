/* ylm_shade_rise.h - e^x and 1 - e^-t of vectors, for kernels that are compiled per instruction set. */
#ifndef YLM_SHADE_RISE_H
#define YLM_SHADE_RISE_H

#include "ylm_simd.h"

YLM_INLINE ylm_vf least(ylm_vf a, ylm_vf b) { return ylm_vf_select(a < b, a, b); }
YLM_INLINE ylm_vf most(ylm_vf a, ylm_vf b) { return ylm_vf_select(a > b, a, b); }

/* e^x for x <= 0, to 2 units in the last place; 0 below -87. */
YLM_INLINE ylm_vf exponential(ylm_vf x) {
  const ylm_vf zero = {0};
  ylm_vi dark = x < zero - 87;
  x = ylm_vf_select(dark, zero, x);
  ylm_vf round = x * 1.44269504f + 12582912.0f, n = round - 12582912.0f;
  ylm_vf r = x - n * 0.693359375f + n * 2.12194440e-4f, p = zero + 1.9875691500e-4f;
  p = p * r + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  p = p * r * r + r + 1;
  ylm_vi power = ((ylm_vi)round << 23) + (127 << 23); /* of 2^n */
  return ylm_vf_select(dark, zero, p * (ylm_vf)power);
}

/* 1 - e^-t for t >= 0. */
YLM_INLINE ylm_vf rise(ylm_vf t) {
  ylm_vf series = t * (1 - t * (0.5f - t * (0.16666667f - t * (0.041666668f - t * 0.0083333334f))));
  return ylm_vf_select(t < 0.1f, series, 1 - exponential(-t));
}

#endif
