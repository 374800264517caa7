/*
** lanes.h - rows of three numbers as lanes, and elementary functions of lanes. For *.isa.c of
** csrc/material.
**
** Sources  polynomials: Moshier, Cephes Mathematical Library, single precision (netlib.org/cephes)
*/
#ifndef YLM_MATERIAL_LANES_H
#define YLM_MATERIAL_LANES_H

#include "ylm_math.h"
#include "ylm_simd.h"

#define W YLM_VF

typedef ylm_vf lane;
typedef ylm_vi mask;

#define LANES_2(F, a) F(0, a), F(1, a)
#define LANES_4(F, a) LANES_2(F, a), F(2, a), F(3, a)
#define LANES_8(F, a) LANES_4(F, a), F(4, a), F(5, a), F(6, a), F(7, a)
#define LANES_16(F, a)                                                                             \
  LANES_8(F, a), F(8, a), F(9, a), F(10, a), F(11, a), F(12, a), F(13, a), F(14, a), F(15, a)
#if YLM_VECTOR_BYTES == 16
#define LANES LANES_4
#elif YLM_VECTOR_BYTES == 32
#define LANES LANES_8
#else
#define LANES LANES_16
#endif

/* -- rows of three --------------------------------------------------------------- */

/* Lane j of coordinate c is element 3j+c of three vectors: first of the first two of them. */
#define LANES_FIRST(j, c) (3 * (j) + (c) < 2 * W ? 3 * (j) + (c) : 0)
#define LANES_LAST(j, c) (3 * (j) + (c) < 2 * W ? (j) : 3 * (j) + (c)-W)
#define LANES_COORDINATE(c)                                                                        \
  __builtin_shufflevector(__builtin_shufflevector(a, b, LANES(LANES_FIRST, c)), d,                 \
                          LANES(LANES_LAST, c))

/* Element e = W q + j of the rows is coordinate e % 3 of row e / 3. */
#define LANES_XY(j, q) ((W * (q) + (j)) % 3 * W % (2 * W) + (W * (q) + (j)) / 3)
#define LANES_Z(j, q) ((W * (q) + (j)) % 3 == 2 ? W + (W * (q) + (j)) / 3 : (j))
#define LANES_ROWS(q)                                                                              \
  __builtin_shufflevector(__builtin_shufflevector(v[0], v[1], LANES(LANES_XY, q)), v[2],           \
                          LANES(LANES_Z, q))

YLM_INLINE void lanes_split(const float *p, lane v[3]) {
  lane a = ylm_vf_load(p), b = ylm_vf_load(p + W), d = ylm_vf_load(p + 2 * W);
  v[0] = LANES_COORDINATE(0);
  v[1] = LANES_COORDINATE(1);
  v[2] = LANES_COORDINATE(2);
}

YLM_INLINE void lanes_join(const lane v[3], float *p) {
  ylm_vf_store(p, LANES_ROWS(0));
  ylm_vf_store(p + W, LANES_ROWS(1));
  ylm_vf_store(p + 2 * W, LANES_ROWS(2));
}

/* The coordinates of rows 0 .. rows-1 <= W-1; lanes beyond repeat the first row. */
YLM_INLINE void lanes_load3(const float (*p)[3], size_t rows, lane v[3]) {
  float copy[3 * W];
  if (rows < W) {
    for (size_t j = 0; j < W; j++) memcpy(copy + 3 * j, p[j < rows ? j : 0], sizeof *p);
    lanes_split(copy, v);
  } else
    lanes_split(p[0], v);
}

YLM_INLINE void lanes_store3(const lane v[3], size_t rows, float (*p)[3]) {
  float copy[3 * W];
  if (rows < W) {
    lanes_join(v, copy);
    memcpy(p, copy, rows * sizeof *p);
  } else
    lanes_join(v, p[0]);
}

YLM_INLINE void lanes_store(lane v, size_t rows, float *p) {
  float copy[W];
  if (rows < W) {
    ylm_vf_store(copy, v);
    memcpy(p, copy, rows * sizeof *p);
  } else
    ylm_vf_store(p, v);
}

/* Vectors of rows: i their first, rows their number. */
#define LANES_EACH(i, rows, n)                                                                     \
  for (size_t i = 0, rows; i < n && (rows = n - i < W ? n - i : W) > 0; i += W)

/* -- elementary functions ------------------------------------------------------- */

YLM_INLINE lane lane_of(float x) { return ylm_vf_set(x); }
YLM_INLINE lane lane_max(lane a, lane b) { return ylm_vf_select(a > b, a, b); }
YLM_INLINE lane lane_min(lane a, lane b) { return ylm_vf_select(a < b, a, b); }
YLM_INLINE lane lane_float(mask i) { return __builtin_convertvector(i, lane); }
YLM_INLINE mask lane_int(lane x) { return __builtin_convertvector(x, mask); }
/* x where the mask is set, else 0. */
YLM_INLINE lane lane_if(mask m, lane x) { return (lane)((mask)x & m); }

/* log(x) of normal x > 0. */
YLM_INLINE lane lane_log(lane x) {
  mask bits = (mask)x, e = (bits - 0x3f3504f3) >> 23;
  lane f = (lane)(bits - (e << 23)) - 1, k = lane_float(e), z = f * f;
  lane y = f * 7.0376836292e-2f - 1.1514610310e-1f;
  y = y * f + 1.1676998740e-1f;
  y = y * f - 1.2420140846e-1f;
  y = y * f + 1.4249322787e-1f;
  y = y * f - 1.6668057665e-1f;
  y = y * f + 2.0000714765e-1f;
  y = y * f - 2.4999993993e-1f;
  y = y * f + 3.3333331174e-1f;
  y = y * f * z + k * -2.12194440e-4f - 0.5f * z;
  return f + y + k * 0.693359375f;
}

/* log(1 - t), 0 <= t < 1: relative to itself as exact as lane_log (Kahan). */
YLM_INLINE lane lane_log1m(lane t) {
  lane u = 1 - t, d = 1 - u;
  return ylm_vf_select(d == 0, -t, lane_log(lane_max(u, lane_of(1e-30f))) * t / d);
}

/* exp(x) - 1 over x^2, less 1/x, for |x| < 0.35. */
YLM_INLINE lane lane_exp_rest(lane x) {
  lane y = x * 1.9875691500e-4f + 1.3981999507e-3f;
  y = y * x + 8.3334519073e-3f;
  y = y * x + 4.1665795894e-2f;
  y = y * x + 1.6666665459e-1f;
  return y * x + 5.0000001201e-1f;
}

/* exp(x) for x <= 80; 0 below -87. */
YLM_INLINE lane lane_exp(lane x) {
  lane at = lane_max(x, lane_of(-87));
  lane shifted = at * 1.44269504088896341f + 128.5f; /* positive: truncation is the floor */
  mask k = lane_int(shifted) - 128;
  lane n = lane_float(k), r = at - n * 0.693359375f + n * 2.12194440e-4f;
  lane y = (lane_exp_rest(r) * r * r + r + 1) * (lane)((k + 127) << 23);
  return lane_if(x > -87, y);
}

/* 1 - exp(x) for x <= 0. */
YLM_INLINE lane lane_1mexp(lane x) {
  lane small = -(lane_exp_rest(x) * x * x + x);
  return ylm_vf_select(x > -0.34f, small, 1 - lane_exp(x));
}

/* Sine and cosine of u turns, 0 <= u <= 1. */
YLM_INLINE void lane_turn(lane u, lane *sine, lane *cosine) {
  mask q = lane_int(u * 4 + 0.5f);
  lane r = (u - lane_float(q) * 0.25f) * (float)(2 * YLM_PI), z = r * r;
  lane s = ((z * -1.9515295891e-4f + 8.3321608736e-3f) * z - 1.6666654611e-1f) * z * r + r;
  lane c =
      ((z * 2.443315711809948e-5f - 1.388731625493765e-3f) * z + 4.166664568298827e-2f) * z * z -
      0.5f * z + 1;
  mask odd = (q & 1) != 0, down = (q & 2) != 0, left = ((q + 1) & 2) != 0;
  lane a = ylm_vf_select(odd, c, s), b = ylm_vf_select(odd, s, c);
  *sine = ylm_vf_select(down, -a, a);
  *cosine = ylm_vf_select(left, -b, b);
}

/* A direction as the cosine about z for two numbers: a place on the unit disk, raised. */
YLM_INLINE void lane_cosine(lane u0, lane u1, lane wi[3]) {
  lane s, c, r = ylm_vf_sqrt(u0);
  lane_turn(u1, &s, &c);
  wi[0] = r * c;
  wi[1] = r * s;
  wi[2] = ylm_vf_sqrt(1 - u0);
}

#endif
