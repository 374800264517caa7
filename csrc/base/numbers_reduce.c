/* numbers_reduce.c - sums, means, least and largest numbers along an axis. */
#include "ylm_numbers.h"

#include <math.h>

enum { LANES = 16, TILE = 256 };

/* Adds x to s; c gathers what is lost (Knuth's sum of two). */
#define TWO_SUM(s, c, x)                                                                           \
  do {                                                                                             \
    double sum_ = (s) + (x), part_ = sum_ - (s);                                                   \
    (c) += ((s) - (sum_ - part_)) + ((x)-part_);                                                   \
    (s) = sum_;                                                                                    \
  } while (0)

/* A sum of infinite numbers has no loss that is a number. */
static double whole(double s, double c) { return isfinite(s) ? s + c : s; }

/* Rows of numbers: n of them, `stride` apart, each `width` wide; of floats and doubles. */
#define ROWS(T)                                                                                    \
  static double sum_row_##T(size_t n, const T *x) {                                                \
    double s[LANES] = {0}, c[LANES] = {0}, total = 0, lost = 0;                                    \
    size_t i = 0;                                                                                  \
    for (; i + LANES <= n; i += LANES)                                                             \
      for (size_t k = 0; k < LANES; k++) TWO_SUM(s[k], c[k], (double)x[i + k]);                    \
    for (; i < n; i++) TWO_SUM(s[0], c[0], (double)x[i]);                                          \
    for (size_t k = 0; k < LANES; k++) {                                                           \
      TWO_SUM(total, lost, s[k]);                                                                  \
      lost += c[k];                                                                                \
    }                                                                                              \
    return whole(total, lost);                                                                     \
  }                                                                                                \
  static void sum_rows_##T(size_t n, size_t stride, size_t width, const T *x, double *out) {       \
    double s[TILE] = {0}, c[TILE] = {0};                                                           \
    for (size_t i = 0; i < n; i++)                                                                 \
      for (size_t k = 0; k < width; k++) TWO_SUM(s[k], c[k], (double)x[i * stride + k]);           \
    for (size_t k = 0; k < width; k++) out[k] = whole(s[k], c[k]);                                 \
  }                                                                                                \
  static double extreme_row_##T(size_t n, const T *x, T sign) {                                    \
    T best[LANES];                                                                                 \
    for (size_t k = 0; k < LANES; k++) best[k] = sign * x[0];                                      \
    bool nan = false;                                                                              \
    for (size_t i = 0; i < n; i++) nan |= x[i] != x[i];                                            \
    if (nan) return NAN;                                                                           \
    size_t i = 0;                                                                                  \
    for (; i + LANES <= n; i += LANES)                                                             \
      for (size_t k = 0; k < LANES; k++)                                                           \
        best[k] = sign * x[i + k] > best[k] ? sign * x[i + k] : best[k];                           \
    for (; i < n; i++) best[0] = sign * x[i] > best[0] ? sign * x[i] : best[0];                    \
    for (size_t k = 1; k < LANES; k++) best[0] = best[k] > best[0] ? best[k] : best[0];            \
    return (double)(sign * best[0]);                                                               \
  }                                                                                                \
  static void extreme_rows_##T(size_t n, size_t stride, size_t width, const T *x, T sign,          \
                               double *out) {                                                      \
    T best[TILE];                                                                                  \
    for (size_t k = 0; k < width; k++) best[k] = x[k];                                             \
    for (size_t i = 1; i < n; i++)                                                                 \
      for (size_t k = 0; k < width; k++) {                                                         \
        T y = x[i * stride + k];                                                                   \
        best[k] = y != y || sign * y > sign * best[k] ? y : best[k];                               \
      }                                                                                            \
    for (size_t k = 0; k < width; k++) out[k] = (double)best[k];                                   \
  }                                                                                                \
  static void reduce_##T(ylm_numbers_reduce_op op, size_t outer, size_t n, size_t inner,           \
                         const T *in, double *out) {                                               \
    bool adds = op == YLM_REDUCE_sum || op == YLM_REDUCE_mean;                                     \
    T sign = op == YLM_REDUCE_min ? -1 : 1;                                                        \
    for (size_t o = 0; o < outer; o++, in += n * inner, out += inner) {                            \
      if (inner == 1) out[0] = adds ? sum_row_##T(n, in) : extreme_row_##T(n, in, sign);           \
      for (size_t k = 0; inner > 1 && k < inner; k += TILE) {                                      \
        size_t width = inner - k < TILE ? inner - k : TILE;                                        \
        if (adds)                                                                                  \
          sum_rows_##T(n, inner, width, in + k, out + k);                                          \
        else                                                                                       \
          extreme_rows_##T(n, inner, width, in + k, sign, out + k);                                \
      }                                                                                            \
      for (size_t k = 0; op == YLM_REDUCE_mean && k < inner; k++) out[k] /= (double)n;             \
    }                                                                                              \
  }
ROWS(float)
ROWS(double)

ylm_status ylm_numbers_reduce(ylm_numbers_reduce_op op, ylm_dtype t, size_t outer, size_t n,
                              size_t inner, const void *in, double *out) {
  if (n == 0 && op != YLM_REDUCE_sum && outer * inner > 0) return YLM_EDOMAIN;
  if (t == YLM_DOUBLE)
    reduce_double(op, outer, n, inner, in, out);
  else if (t == YLM_FLOAT)
    reduce_float(op, outer, n, inner, in, out);
  else {
    size_t count = outer * n * inner;
    void *wide = ylm_alloc(count, ylm_numbers_size(ylm_numbers_wide(t)));
    if (!wide) return YLM_ENOMEM;
    ylm_numbers_convert(t, ylm_numbers_wide(t), count, in, wide, NULL);
    ylm_numbers_reduce(op, ylm_numbers_wide(t), outer, n, inner, wide, out);
    ylm_free(wide);
  }
  return YLM_OK;
}
