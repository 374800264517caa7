/*
** kernel.isa.c - sampling a voxel at a batch of points: a small matrix product.
**
** out[p][j] = sum over rows r of w[r][p] row[r][j]. The weights are computed with points as
** lanes; the product runs over blocks of 4 points x a few vectors of coefficients, so that a row's
** load is shared by the points. A column is summed in the same order whatever block it is in.
*/
#include "../grid.h"
#include "calibration.h"
#include "ylm_simd.h"

#define F ylm_vf
#include "../gen/interpolation.h"

#if YLM_VECTOR_BYTES == 64
#define COLUMNS 5
#else
#define COLUMNS 2
#endif

/* Stores the first n floats of v. */
YLM_INLINE void store_some(float *out, ylm_vf v, int n) {
  if (n >= YLM_VF)
    ylm_vf_store(out, v);
  else
#if defined(__AVX512F__)
    _mm512_mask_storeu_ps(out, (__mmask16)((1u << n) - 1), (__m512)v);
#else
    memcpy(out, &v, (size_t)n * sizeof *out);
#endif
}

/* A vector of a row of which n floats are left. Records are multiples of 8 floats: more are the next point's, which another
   thread may be writing. */
YLM_INLINE ylm_vf load_some(const float *row, int n) {
#if YLM_VECTOR_BYTES > 32
  ylm_vf v = {0};
  if (n <= 8) {
    memcpy(&v, row, 32);
    return v;
  }
#endif
  (void)n;
  return ylm_vf_load(row);
}

/* `points` points from w[r * BATCH], `columns` vectors from column j on. */
YLM_INLINE void block(const sample_batch *b, int rows, const float *w, int j, const int columns,
                      float *const *out, const int points) {
  ylm_vf sum[SAMPLE_POINTS][COLUMNS] = {{{0}}};
  for (int r = 0; r < rows; r++) {
    const float *row = b->row[r] + j;
    ylm_vf v[COLUMNS];
    for (int c = 0; c < columns; c++) v[c] = ylm_vf_load(row + c * YLM_VF);
    for (int p = 0; p < points; p++) {
      float x = w[r * BATCH + p];
      for (int c = 0; c < columns; c++) sum[p][c] += x * v[c];
    }
  }
  for (int p = 0; p < points; p++)
    for (int c = 0; c < columns; c++)
      store_some(out[p] + j + c * YLM_VF, sum[p][c], b->width - j - c * YLM_VF);
}

/* All columns of a few points. Where a block has five vectors, seven are taken as four and three. */
YLM_INLINE void columns_of(const sample_batch *b, int rows, const float *w, float *const *out,
                           const int points) {
  int vectors = (b->width + YLM_VF - 1) / YLM_VF, j = 0;
  for (; vectors >= COLUMNS && (COLUMNS == 2 || vectors != COLUMNS + 2);
       vectors -= COLUMNS, j += COLUMNS * YLM_VF)
    block(b, rows, w, j, COLUMNS, out, points);
#if COLUMNS > 2
  if (vectors == COLUMNS + 2) {
    block(b, rows, w, j, 4, out, points);
    vectors = 3, j += 4 * YLM_VF;
  }
  if (vectors == 4) block(b, rows, w, j, 4, out, points);
  if (vectors == 3) block(b, rows, w, j, 3, out, points);
  if (vectors == 2) block(b, rows, w, j, 2, out, points);
#endif
  if (vectors == 1) block(b, rows, w, j, 1, out, points);
}

/* The product for all points of the batch. */
static void mix(const sample_batch *b, const float *w, float *const *out) {
  int rows = b->interpolation == YLM_GRID_LINEAR ? 8 : ROWS, p = 0;
  for (; p + SAMPLE_POINTS <= b->points; p += SAMPLE_POINTS)
    columns_of(b, rows, w + p, out + p, SAMPLE_POINTS);
  if (b->points - p == 3) columns_of(b, rows, w + p, out + p, 3);
  if (b->points - p == 2) columns_of(b, rows, w + p, out + p, 2);
  if (b->points - p == 1) columns_of(b, rows, w + p, out + p, 1);
}

/* The product for points most of whose weights are 0, as at the middles of edges and faces: rows of
   weight 0 are left out. */
static void mix_few(const sample_batch *b, const float *w, float *const *out) {
  for (int p = 0; p < b->points; p++) {
    const float *row[ROWS];
    float x[ROWS];
    int n = 0;
    for (int r = 0; r < ROWS; r++) {
      row[n] = b->row[r];
      x[n] = w[r * BATCH + p];
      n += x[n] != 0;
    }
    for (int j = 0; j < b->width; j += COLUMNS * YLM_VF) {
      ylm_vf sum[COLUMNS] = {{0}};
      int columns = (b->width - j + YLM_VF - 1) / YLM_VF;
      for (int r = 0; r < n && columns >= COLUMNS; r++)
        for (int c = 0; c < COLUMNS; c++)
          sum[c] += x[r] * load_some(row[r] + j + c * YLM_VF, b->width - j - c * YLM_VF);
      for (int c = 0; c < columns && columns < COLUMNS; c++)
        for (int r = 0; r < n; r++)
          sum[c] += x[r] * load_some(row[r] + j + c * YLM_VF, b->width - j - c * YLM_VF);
      for (int c = 0; c < COLUMNS && c < columns; c++)
        store_some(out[p] + j + c * YLM_VF, sum[c], b->width - j - c * YLM_VF);
    }
  }
}

void YLM_KERNEL(ylm_k_grid_sample)(const sample_batch *b) {
  float w[ROWS * BATCH] __attribute__((aligned(64)));
  ylm_vf some[ROWS];
  for (int d = 0; d <= (b->derivatives ? 3 : 0); d++) {
    for (int p = 0; p < b->points; p += YLM_VF) {
      axis_functions f[3];
      for (int a = 0; a < 3; a++) {
        ylm_vf t = ylm_vf_load(b->t[a] + p);
        if (d == a + 1)
          axis_slopes(&f[a], t, b->edge[a], b->interpolation);
        else
          axis_values(&f[a], t, b->edge[a], b->interpolation);
      }
      weights(&f[0], &f[1], &f[2], some, 1);
      for (int r = 0; r < ROWS; r++) ylm_vf_store(w + r * BATCH + p, some[r]);
    }
    (b->sparse ? mix_few : mix)(b, w, d ? b->gradient[d - 1] : b->value);
  }
}
