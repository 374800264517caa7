/* transfer_kernel.h - matrices times rows, for the unit's element type. */
#ifndef YLM_SH_TRANSFER_KERNEL_H
#define YLM_SH_TRANSFER_KERNEL_H

#include "../calibration.h"
#include "ylm_real.h"

/* R rows by two vectors of columns: out = the sum over k of m[k] in[k]. */
YLM_INLINE void transfer_block(const int R, size_t n, size_t padded, const real *m,
                               const real *const *in, real *const *out) {
  vreal sum[TRANSFER_ROWS][2];
  for (int r = 0; r < R; r++) sum[r][0] = sum[r][1] = vreal_set(0);
  for (size_t k = 0; k < n; k++, m += padded) {
    vreal m0 = vreal_load(m), m1 = vreal_load(m + LANES);
    for (int r = 0; r < R; r++) {
      vreal x = vreal_set(in[r][k]);
      sum[r][0] += m0 * x;
      sum[r][1] += m1 * x;
    }
  }
  for (int r = 0; r < R; r++) {
    vreal_store(out[r], sum[r][0]);
    vreal_store(out[r] + LANES, sum[r][1]);
  }
}

/* rows rows of n numbers; m: [n][padded], symmetric, padded a multiple of 2 LANES. */
static void transfer(size_t n, size_t padded, const real *m, size_t rows, const real *in,
                     real *out) {
  real wide[TRANSFER_ROWS][2 * LANES] __attribute__((aligned(64)));
  real *to[TRANSFER_ROWS];
  const real *from[TRANSFER_ROWS];
  for (int i = 0; i < TRANSFER_ROWS; i++) to[i] = wide[i];
  while (rows > 0) {
    int R = rows < TRANSFER_ROWS ? 1 : TRANSFER_ROWS;
    for (int i = 0; i < R; i++) from[i] = in + (size_t)i * n;
    for (size_t column = 0; column < n; column += 2 * LANES) {
      if (R == 1)
        transfer_block(1, n, padded, m + column, from, to);
      else
        transfer_block(TRANSFER_ROWS, n, padded, m + column, from, to);
      size_t width = n - column < 2 * LANES ? n - column : 2 * LANES;
      for (int i = 0; i < R; i++)
        memcpy(out + (size_t)i * n + column, wide[i], width * sizeof(real));
    }
    rows -= (size_t)R;
    in += (size_t)R * n;
    out += (size_t)R * n;
  }
}

#endif
