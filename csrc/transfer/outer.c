/* outer.c - sums of outer products: the plain form, which judges the others, and their choice. */
#include "transfer.h"

static void plain(size_t n, size_t rows, size_t width, const float *left, const float *right,
                  float *m) {
  for (size_t o = 0; o < rows; o++)
    for (size_t k = 0; k < width; k++) {
      double s = 0;
      for (size_t i = 0; i < n; i++) s += (double)left[i * rows + o] * (double)right[i * width + k];
      m[o * width + k] += (float)s;
    }
}

#if defined(__x86_64__)
ylm_transfer_outer_fn ylm_k_transfer_outer_sse2, ylm_k_transfer_outer_avx2,
    ylm_k_transfer_outer_avx512;
#elif defined(__aarch64__)
ylm_transfer_outer_fn ylm_k_transfer_outer_neon;
#endif

ylm_transfer_outer_fn *ylm__transfer_outer(void) {
  switch (ylm_isa_current()) {
#if defined(__x86_64__)
  case YLM_ISA_sse2: return ylm_k_transfer_outer_sse2;
  case YLM_ISA_avx2: return ylm_k_transfer_outer_avx2;
  case YLM_ISA_avx512: return ylm_k_transfer_outer_avx512;
#elif defined(__aarch64__)
  case YLM_ISA_neon: return ylm_k_transfer_outer_neon;
#endif
  default: return plain;
  }
}
