/* kernels.c - the plain form of the inner loops, which judges the others, and their choice. */
#include <math.h>

#include "view.h"

static void dot(size_t count, size_t n, int channels, const uint32_t *index, size_t t_row,
                const float *T, size_t l_row, size_t l_point, const float *L, float *out) {
  for (size_t i = 0; i < n; i++)
    for (int c = 0; c < 3; c++) {
      size_t p = index ? index[i] : i;
      const float *light = L + i * l_point + (c < channels ? (size_t)c * l_row : 0);
      double s = 0;
      for (size_t k = 0; k < count; k++) s += (double)T[p * t_row + k] * (double)light[k];
      out[3 * p + (size_t)c] = (float)s;
    }
}

static void sums(size_t count, size_t n, const float *Y, const uint8_t *visible, float *seen,
                 float *all) {
  for (size_t i = 0; i < n; i++)
    for (size_t k = 0; k < count; k++) {
      all[k] += Y[i * count + k];
      if (visible[i]) seen[k] += Y[i * count + k];
    }
}

/* Bound of the unshadowed irradiance, over pi, of a lamp of radiance 1 at v with radius r. */
static double weight(const double v[3], double r, const float n[3]) {
  double d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  if (d2 <= r * r) return r > 0;
  double cosine = (v[0] * n[0] + v[1] * n[1] + v[2] * n[2]) / sqrt(d2), s = r * r / d2;
  if (cosine >= sqrt(s)) return s * cosine;
  if (cosine <= -sqrt(s)) return 0;
  return s * fmax(0, cosine * sqrt(1 - s) + sqrt((1 - cosine * cosine) * s));
}

static void weights(size_t chunks, float *const lamp[4], const float *luminance, const float x[3],
                    const float n[3], float *w, float *sum) {
  for (size_t b = 0; b < chunks; b++) {
    sum[b] = 0;
    for (size_t j = b * YLM_LAMP_CHUNK; j < (b + 1) * YLM_LAMP_CHUNK; j++) {
      double v[3] = {(double)lamp[0][j] - x[0], (double)lamp[1][j] - x[1],
                     (double)lamp[2][j] - x[2]};
      w[j] = (float)weight(v, lamp[3][j], n) * luminance[j];
      sum[b] += w[j];
    }
  }
}

#define DECLARE(isa)                                                                               \
  ylm_shade_dot_fn ylm_k_shade_dot_##isa;                                                          \
  ylm_shade_sums_fn ylm_k_shade_sums_##isa;                                                        \
  ylm_shade_weights_fn ylm_k_shade_weights_##isa;
#define CASE(isa)                                                                                  \
  case YLM_ISA_##isa:                                                                              \
    return (shade_kernels){ylm_k_shade_dot_##isa, ylm_k_shade_sums_##isa,                          \
                           ylm_k_shade_weights_##isa};

#if defined(__x86_64__)
DECLARE(sse2)
DECLARE(avx2)
DECLARE(avx512)
#elif defined(__aarch64__)
DECLARE(neon)
#endif

shade_kernels ylm__shade_kernels(void) {
  switch (ylm_isa_current()) {
#if defined(__x86_64__)
    CASE(sse2)
    CASE(avx2)
    CASE(avx512)
#elif defined(__aarch64__)
    CASE(neon)
#endif
  default: return (shade_kernels){dot, sums, weights};
  }
}
