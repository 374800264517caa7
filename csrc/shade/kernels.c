/* kernels.c - the plain form of the inner loops, which judges the others, and their choice. */
#include "view.h"
#include "ylm_sets.h"

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

static void mix(size_t count, size_t n, int functions, int channels, size_t t_row, const float *T,
                size_t l_row, const float *L, const float (*by)[3], float *out) {
  for (size_t i = 0; i < n; i++) {
    for (int c = 0; c < 3; c++) {
      const float *light = L + (i * (size_t)channels + (c < channels ? (size_t)c : 0)) * l_row;
      double s = 0;
      for (int f = 0; f < functions; f++) {
        const float *row = T + (i * (size_t)functions + (size_t)f) * t_row;
        for (size_t k = 0; k < count; k++)
          s += (double)by[c][f] * (double)row[k] * (double)light[k];
      }
      out[3 * i + (size_t)c] = (float)s;
    }
  }
}

static YLM_KERNEL_CHOICE(ylm_shade_dot_fn, dot_now, ylm_k_shade_dot, dot);
static YLM_KERNEL_CHOICE(ylm_shade_sums_fn, sums_now, ylm_k_shade_sums, sums);
static YLM_KERNEL_CHOICE(ylm_shade_mix_fn, mix_now, ylm_k_shade_mix, mix);

shade_kernels ylm__shade_kernels(void) { return (shade_kernels){dot_now(), sums_now(), mix_now()}; }
