/* rows.c - sums of rows with weights: the plain form, which judges the others, and their choice. */
#include "gather.h"

static void plain(size_t n, size_t rows, const float *w, size_t width, size_t stride,
                  const float *y, double *out) {
  for (size_t r = 0; r < rows; r++)
    for (size_t i = 0; i < n; i++)
      for (size_t k = 0; k < width; k++)
        out[r * width + k] += (double)w[r * GATHER_BATCH + i] * (double)y[i * stride + k];
}

#if defined(__x86_64__)
gather_rows_fn ylm_k_gather_rows_sse2, ylm_k_gather_rows_avx2, ylm_k_gather_rows_avx512;
#elif defined(__aarch64__)
gather_rows_fn ylm_k_gather_rows_neon;
#endif

gather_rows_fn *ylm__gather_rows(void) {
  switch (ylm_isa_current()) {
#if defined(__x86_64__)
  case YLM_ISA_sse2: return ylm_k_gather_rows_sse2;
  case YLM_ISA_avx2: return ylm_k_gather_rows_avx2;
  case YLM_ISA_avx512: return ylm_k_gather_rows_avx512;
#elif defined(__aarch64__)
  case YLM_ISA_neon: return ylm_k_gather_rows_neon;
#endif
  default: return plain;
  }
}
