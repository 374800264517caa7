/* transfer_kernel.h - matrices times rows for one element type; included twice by product.isa.c. */

#if YLM_VECTOR_BYTES == 64
#define TRANSFER_ROWS 8
#else
#define TRANSFER_ROWS 4
#endif

/* R rows by two vectors of columns: out = the sum over k of m[k] in[k]. */
YLM_INLINE void FN(transfer_block)(const int R, size_t n, size_t padded, const T *m,
                                   const T *const *in, T *const *out) {
  V sum[TRANSFER_ROWS][2];
  for (int r = 0; r < R; r++) sum[r][0] = sum[r][1] = SET(0);
  for (size_t k = 0; k < n; k++, m += padded) {
    V m0 = LOAD(m), m1 = LOAD(m + LANES);
    for (int r = 0; r < R; r++) {
      V x = SET(in[r][k]);
      sum[r][0] += m0 * x;
      sum[r][1] += m1 * x;
    }
  }
  for (int r = 0; r < R; r++) {
    STORE(out[r], sum[r][0]);
    STORE(out[r] + LANES, sum[r][1]);
  }
}

/* rows rows of n numbers; m: [n][padded], symmetric, padded a multiple of 2 LANES. */
static void FN(transfer)(size_t n, size_t padded, const T *m, size_t rows, const T *in, T *out) {
  T wide[TRANSFER_ROWS][2 * LANES] __attribute__((aligned(64)));
  T *to[TRANSFER_ROWS];
  const T *from[TRANSFER_ROWS];
  for (int i = 0; i < TRANSFER_ROWS; i++) to[i] = wide[i];
  while (rows > 0) {
    int R = rows < TRANSFER_ROWS ? 1 : TRANSFER_ROWS;
    for (int i = 0; i < R; i++) from[i] = in + (size_t)i * n;
    for (size_t column = 0; column < n; column += 2 * LANES) {
      if (R == 1)
        FN(transfer_block)(1, n, padded, m + column, from, to);
      else
        FN(transfer_block)(TRANSFER_ROWS, n, padded, m + column, from, to);
      size_t width = n - column < 2 * LANES ? n - column : 2 * LANES;
      for (int i = 0; i < R; i++) memcpy(out + (size_t)i * n + column, wide[i], width * sizeof(T));
    }
    rows -= (size_t)R;
    in += (size_t)R * n;
    out += (size_t)R * n;
  }
}
#undef TRANSFER_ROWS
