/* rows.isa.c - sums of rows with weights, once per instruction set. rows.c has the plain form. */
#include "ylm_simd.h"

#include "gather.h"

gather_rows_fn YLM_KERNEL(ylm_k_gather_rows);

/* `tall` rows of weights over `wide` vectors of the numbers from y on; `left` of them count. */
YLM_INLINE void tile(int tall, int wide, size_t n, const float *w, size_t stride, const float *y,
                     size_t width, size_t left, double *out) {
  ylm_vf sum[6][4];
  float lane[YLM_VF];
  for (int r = 0; r < tall; r++)
    for (int v = 0; v < wide; v++) sum[r][v] = (ylm_vf){0};
  for (size_t i = 0; i < n; i++) {
    ylm_vf x[4];
    for (int v = 0; v < wide; v++) x[v] = ylm_vf_load(y + i * stride + v * YLM_VF);
    for (int r = 0; r < tall; r++)
      for (int v = 0; v < wide; v++) sum[r][v] += w[r * GATHER_BATCH + (int)i] * x[v];
  }
  for (int r = 0; r < tall; r++)
    for (int v = 0; v < wide; v++) {
      ylm_vf_store(lane, sum[r][v]);
      for (size_t k = 0; k < YLM_VF && (size_t)v * YLM_VF + k < left; k++)
        out[(size_t)r * width + (size_t)v * YLM_VF + k] += (double)lane[k];
    }
}

void YLM_KERNEL(ylm_k_gather_rows)(size_t n, size_t rows, const float *w, size_t width,
                                   size_t stride, const float *y, double *out) {
  for (size_t k = 0; k < width;) {
    size_t left = width - k, vectors = (left + YLM_VF - 1) / YLM_VF, r = 0;
    int wide = vectors >= 4 ? 4 : (int)vectors;
    for (; wide <= 2 && r + 6 <= rows; r += 6) {
      const float *from = w + r * GATHER_BATCH;
      double *to = out + r * width + k;
      if (wide == 2)
        tile(6, 2, n, from, stride, y + k, width, left, to);
      else
        tile(6, 1, n, from, stride, y + k, width, left, to);
    }
    for (; r < rows; r += 3) {
      const float *from = w + r * GATHER_BATCH;
      double *to = out + r * width + k;
      if (wide == 4)
        tile(3, 4, n, from, stride, y + k, width, left, to);
      else if (wide == 3)
        tile(3, 3, n, from, stride, y + k, width, left, to);
      else if (wide == 2)
        tile(3, 2, n, from, stride, y + k, width, left, to);
      else
        tile(3, 1, n, from, stride, y + k, width, left, to);
    }
    k += (size_t)wide * YLM_VF;
  }
}
