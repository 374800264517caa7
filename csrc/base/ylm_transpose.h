/*
** ylm_transpose.h - rows to lanes and back, for the unit's element type.
**
** Kernels whose lanes are the rows of a batch read and write through tiles: element k of row r is
** tile[k * pitch + r].
*/
#ifndef YLM_TRANSPOSE_H
#define YLM_TRANSPOSE_H

#include "ylm_real.h"

/* F(0,b), F(1,b) .. for 2, 4, 8 and 16 lanes. */
#define TRANSPOSE_2(F, b) F(0, b), F(1, b)
#define TRANSPOSE_4(F, b) TRANSPOSE_2(F, b), F(2, b), F(3, b)
#define TRANSPOSE_8(F, b) TRANSPOSE_4(F, b), F(4, b), F(5, b), F(6, b), F(7, b)
#define TRANSPOSE_16(F, b)                                                                         \
  TRANSPOSE_8(F, b), F(8, b), F(9, b), F(10, b), F(11, b), F(12, b), F(13, b), F(14, b), F(15, b)
#define TRANSPOSE_LOW(j, b) (((j) & (b)) ? LANES + (j) - (b) : (j))
#define TRANSPOSE_HIGH(j, b) (((j) & (b)) ? LANES + (j) : (j) + (b))
/* Exchanges the off-diagonal blocks of b x b. */
#define TRANSPOSE_SWAP(LANES_OF, b)                                                                \
  _Pragma("GCC unroll 16") for (int i = 0; i < LANES; i++) if (!(i & (b))) {                       \
    vreal low = __builtin_shufflevector(v[i], v[i + (b)], LANES_OF(TRANSPOSE_LOW, b));             \
    v[i + (b)] = __builtin_shufflevector(v[i], v[i + (b)], LANES_OF(TRANSPOSE_HIGH, b));           \
    v[i] = low;                                                                                    \
  }

/* v[i] lane j <-> v[j] lane i. */
YLM_INLINE void transpose(vreal v[LANES]) {
#if LANES == 2
  TRANSPOSE_SWAP(TRANSPOSE_2, 1)
#elif LANES == 4
  TRANSPOSE_SWAP(TRANSPOSE_4, 1)
  TRANSPOSE_SWAP(TRANSPOSE_4, 2)
#elif LANES == 8
  TRANSPOSE_SWAP(TRANSPOSE_8, 1)
  TRANSPOSE_SWAP(TRANSPOSE_8, 2)
  TRANSPOSE_SWAP(TRANSPOSE_8, 4)
#else
  TRANSPOSE_SWAP(TRANSPOSE_16, 1)
  TRANSPOSE_SWAP(TRANSPOSE_16, 2)
  TRANSPOSE_SWAP(TRANSPOSE_16, 4)
  TRANSPOSE_SWAP(TRANSPOSE_16, 8)
#endif
}

/* Elements first .. first+n-1 of LANES rows into tile[0 .. n-1]. */
static __attribute__((unused)) void to_tile(const real *const *row, size_t first, int n, real *tile,
                                            int pitch) {
  if (n < LANES) {
    for (int k = 0; k < n; k++)
      for (int r = 0; r < LANES; r++) tile[k * pitch + r] = row[r][first + (size_t)k];
    return;
  }
  for (int k = 0;; k += LANES) {
    if (k > n - LANES) k = n - LANES; /* the last block overlaps the one before */
    vreal v[LANES];
#pragma GCC unroll 16
    for (int r = 0; r < LANES; r++) {
      v[r] = vreal_load(row[r] + first + k);
      __builtin_prefetch(row[r] + first + k + n); /* what is read next */
    }
    transpose(v);
#pragma GCC unroll 16
    for (int r = 0; r < LANES; r++) vreal_store(tile + (k + r) * pitch, v[r]);
    if (k == n - LANES) return;
  }
}

/* tile[0 .. n-1] to elements first .. first+n-1 of LANES rows. */
static __attribute__((unused)) void from_tile(const real *tile, int pitch, int n, size_t first,
                                              real *const *row) {
  if (n < LANES) {
    for (int k = 0; k < n; k++)
      for (int r = 0; r < LANES; r++) row[r][first + (size_t)k] = tile[k * pitch + r];
    return;
  }
  for (int k = 0;; k += LANES) {
    if (k > n - LANES) k = n - LANES;
    vreal v[LANES];
#pragma GCC unroll 16
    for (int r = 0; r < LANES; r++) v[r] = vreal_load(tile + (k + r) * pitch);
    transpose(v);
#pragma GCC unroll 16
    for (int r = 0; r < LANES; r++) {
      vreal_store(row[r] + first + k, v[r]);
      __builtin_prefetch(row[r] + first + k + n, 1);
    }
    if (k == n - LANES) return;
  }
}

#endif
