/* rows.c - sums of rows with weights: the plain form, which judges the others, and their choice. */
#include "gather.h"
#include "ylm_sets.h"

static void plain(size_t n, size_t rows, const float *w, size_t width, size_t stride,
                  const float *y, double *out) {
  for (size_t r = 0; r < rows; r++)
    for (size_t i = 0; i < n; i++)
      for (size_t k = 0; k < width; k++)
        out[r * width + k] += (double)w[r * GATHER_BATCH + i] * (double)y[i * stride + k];
}

YLM_KERNEL_CHOICE(gather_rows_fn, ylm__gather_rows, ylm_k_gather_rows, plain);
