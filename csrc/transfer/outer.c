/* outer.c - sums of outer products: the plain form, which judges the others, and their choice. */
#include "transfer.h"
#include "ylm_sets.h"

static void plain(size_t n, size_t rows, size_t width, const float *left, const float *right,
                  float *m) {
  for (size_t o = 0; o < rows; o++)
    for (size_t k = 0; k < width; k++) {
      double s = 0;
      for (size_t i = 0; i < n; i++) s += (double)left[i * rows + o] * (double)right[i * width + k];
      m[o * width + k] += (float)s;
    }
}

YLM_KERNEL_CHOICE(ylm_transfer_outer_fn, ylm__transfer_outer, ylm_k_transfer_outer, plain);
