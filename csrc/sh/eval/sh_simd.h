/*
** sh_simd.h - vectors of the unit's element type for *.isa.c files.
**
** Lanes are points. Points come as rows [n][3], results go out as rows [n][m]:
** sh_load_points takes rows apart, sh_store_columns puts columns back into rows,
** transposing W x W blocks in registers. Private to csrc/sh.
*/
#ifndef YLM_SH_SIMD_H
#define YLM_SH_SIMD_H

#include "sh_eval.h"
#include "ylm_real.h"

#define W LANES
typedef vmask sh_mask;

YLM_INLINE vreal sh_set(real x) { return (vreal){0} + x; }
YLM_INLINE vreal sh_read(const real *p) {
  vreal v;
  memcpy(&v, p, sizeof v);
  return v;
}
YLM_INLINE void sh_write(real *p, vreal v) { memcpy(p, &v, sizeof v); }

/* F(0,a), F(1,a), ... F(W-1,a): one constant for each lane. */
#define SH_L2(F, a) F(0, a), F(1, a)
#define SH_L4(F, a) SH_L2(F, a), F(2, a), F(3, a)
#define SH_L8(F, a) SH_L4(F, a), F(4, a), F(5, a), F(6, a), F(7, a)
#define SH_L16(F, a)                                                                               \
  SH_L8(F, a), F(8, a), F(9, a), F(10, a), F(11, a), F(12, a), F(13, a), F(14, a), F(15, a)
#define SH_LANES_(w, F, a) SH_L##w(F, a)
#define SH_LANES__(w, F, a) SH_LANES_(w, F, a)
#if YLM_VECTOR_BYTES == 16
#define SH_W_FLOAT 4
#define SH_W_DOUBLE 2
#elif YLM_VECTOR_BYTES == 32
#define SH_W_FLOAT 8
#define SH_W_DOUBLE 4
#else
#define SH_W_FLOAT 16
#define SH_W_DOUBLE 8
#endif
#ifdef YLM_REAL_IS_FLOAT
#define SH_LANES(F, a) SH_LANES__(SH_W_FLOAT, F, a)
#else
#define SH_LANES(F, a) SH_LANES__(SH_W_DOUBLE, F, a)
#endif

/* -- rows of three ------------------------------------------------------------- */

/* Lane j of coordinate c is element 3j+c of three vectors: first what the first two hold. */
#define SH_FIRST(j, c) (3 * j + c < 2 * W ? 3 * j + c : 0)
#define SH_SECOND(j, c) (3 * j + c < 2 * W ? j : W + (3 * j + c - 2 * W))
#define SH_COORDINATE(c)                                                                           \
  __builtin_shufflevector(__builtin_shufflevector(a, b, SH_LANES(SH_FIRST, c)), d,                 \
                          SH_LANES(SH_SECOND, c))

/* The coordinates of W points. */
YLM_INLINE void sh_split(const real *p, vreal v[3]) {
  vreal a = sh_read(p), b = sh_read(p + W), d = sh_read(p + 2 * W);
  v[0] = SH_COORDINATE(0);
  v[1] = SH_COORDINATE(1);
  v[2] = SH_COORDINATE(2);
}

/* The coordinates of `rows` <= W points; lanes beyond repeat the last. */
YLM_INLINE void sh_load_points(const real *p, size_t rows, vreal v[3]) {
  if (rows == W) {
    sh_split(p, v);
    return;
  }
  real copy[3 * W];
  for (size_t j = 0; j < W; j++)
    memcpy(copy + 3 * j, p + 3 * (j < rows ? j : rows - 1), 3 * sizeof *p);
  sh_split(copy, v);
}

/* -- transposing ---------------------------------------------------------------- */

#define SH_LOW(j, b) ((j & b) ? W + j - b : j)
#define SH_HIGH(j, b) ((j & b) ? W + j : j + b)
#define SH_SWAP(b)                                                                                 \
  for (size_t i = 0; i < W; i++)                                                                   \
    if (!(i & b)) {                                                                                \
      vreal low = __builtin_shufflevector(v[i], v[i + b], SH_LANES(SH_LOW, b));                    \
      v[i + b] = __builtin_shufflevector(v[i], v[i + b], SH_LANES(SH_HIGH, b));                    \
      v[i] = low;                                                                                  \
    }

/* v[i] lane j <-> v[j] lane i. */
YLM_INLINE void sh_transpose(vreal v[W]) {
#pragma GCC unroll 16
  SH_SWAP(1)
#if !defined(YLM_REAL_IS_FLOAT) && YLM_VECTOR_BYTES == 16
#else
#pragma GCC unroll 16
  SH_SWAP(2)
#endif
#if (defined(YLM_REAL_IS_FLOAT) && YLM_VECTOR_BYTES > 16) || YLM_VECTOR_BYTES > 32
#pragma GCC unroll 16
  SH_SWAP(4)
#endif
#if defined(YLM_REAL_IS_FLOAT) && YLM_VECTOR_BYTES > 32
#pragma GCC unroll 16
  SH_SWAP(8)
#endif
}

/* Columns column[0..n-1], n < W, to out[row][0..n-1] for all W rows. */
YLM_INLINE void sh_store_narrow(const vreal *column, size_t n, real *out, size_t stride) {
  vreal v[W];
#pragma GCC unroll 16
  for (size_t i = 0; i < W; i++) v[i] = i < n ? column[i] : sh_set(0);
  sh_transpose(v);
#pragma GCC unroll 16
  for (size_t i = 0; i < W; i++) memcpy(out + i * stride, &v[i], (n < W ? n : W) * sizeof *out);
}

/* Columns column[0..n-1] to out[row][0..n-1] for fewer than W rows, which are `stride` apart. */
static __attribute__((noinline, unused)) void sh_store_few(const vreal *column, size_t n, real *out,
                                                           size_t stride, size_t rows) {
  for (size_t j = 0; j < rows; j++)
    for (size_t i = 0; i < n; i++) out[j * stride + i] = column[i][j];
}

/* Columns column[0..W-1] to out[row][0..W-1] for all W rows. */
YLM_INLINE void sh_store_block(const vreal *column, real *out, size_t stride) {
  vreal v[W];
#pragma GCC unroll 16
  for (size_t i = 0; i < W; i++) v[i] = column[i];
  sh_transpose(v);
#pragma GCC unroll 16
  for (size_t i = 0; i < W; i++) sh_write(out + i * stride, v[i]);
}

/* Columns column[0..n-1] to out[row][0..n-1]: whole blocks, the last one overlapping if need be. */
YLM_INLINE void sh_store_columns(const vreal *column, size_t n, real *out, size_t stride,
                                 size_t rows) {
  if (rows < W || (n < W && !__builtin_constant_p(n))) {
    sh_store_few(column, n, out, stride, rows);
    return;
  }
  if (n < W) {
    sh_store_narrow(column, n, out, stride);
    return;
  }
  size_t i = 0;
  for (; i + W <= n; i += W) sh_store_block(column + i, out + i, stride);
  if (n - i > 2)
    sh_store_block(column + n - W, out + n - W, stride);
  else /* an odd (lmax+1)^2 leaves one */
    for (; i < n; i++)
      for (size_t j = 0; j < W; j++) out[j * stride + i] = column[i][j];
}

/* -- normalising ------------------------------------------------------------------ */

/* 1 / sqrt(v) for ordinary v, to an ulp or two. */
YLM_INLINE vreal sh_inverse_root(vreal v) {
#if defined(__AVX512F__) && !defined(YLM_REAL_IS_FLOAT)
  vreal r = (vreal)_mm512_rsqrt14_pd((__m512d)v); /* 2^-14; Newton doubles the digits */
  r += r * (sh_set(0.5) - sh_set(0.5) * v * r * r);
  return r + r * (sh_set(0.5) - sh_set(0.5) * v * r * r);
#else
  vreal r = v;
#ifdef YLM_REAL_IS_FLOAT
  for (size_t i = 0; i < W; i++) r[i] = __builtin_sqrtf(v[i]);
#else
  for (size_t i = 0; i < W; i++) r[i] = __builtin_sqrt(v[i]);
#endif
  r = 1 / r;
  return r + r * (sh_set((real)0.5) - sh_set((real)0.5) * v * r * r); /* mends two roundings */
#endif
}

/* v to unit length, one lane at a time: any length, also 0. */
static __attribute__((noinline)) void sh_unit_slow(vreal v[3], vreal *inverse) {
  for (size_t j = 0; j < W; j++) {
    double p[3] = {v[0][j], v[1][j], v[2][j]}, w[3], d;
    ylm__sh_unit(p, w, &d);
    for (size_t c = 0; c < 3; c++) v[c][j] = (real)w[c];
    (*inverse)[j] = (real)(1 / d);
  }
}

/* v to unit length, and 1/|v|; `tame` as in ylm__sh_job. */
YLM_INLINE void sh_unit(vreal v[3], vreal *inverse, bool tame) {
  if (!tame) {
    sh_unit_slow(v, inverse);
    return;
  }
  vreal d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  *inverse = sh_inverse_root(d2);
  for (size_t c = 0; c < 3; c++) v[c] *= *inverse;
}

#include "../gen/recurrence.h"

/* The sign of z (as -1 or 1) and 1 - |z| of unit vectors, exact also near the poles. */
YLM_INLINE void sh_pole(const vreal w[3], vreal *sign, vreal *one_minus) {
  sh_mask south = w[2] < 0; /* -1 there */
  *sign = 1 + 2 * __builtin_convertvector(south, vreal);
  *one_minus = sh_one_minus(*sign, w[0], w[1], w[2]);
}

#endif
