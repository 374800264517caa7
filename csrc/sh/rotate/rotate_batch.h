/*
** rotate_batch.h - kernels of rotate.isa.c for batches, one element type; included twice.
**
** Low degrees: the rotation's blocks times four rows at a time. Higher degrees, where a block has
** four times the numbers of a quarter turn: TILE rows at once, lanes are rows, Z(a) J Z(b) J Z(c)
** degree by degree.
*/

#include "../eval/transpose.h"

/* -- degrees by their blocks ------------------------------------------------------------------ */

/* R vectors of degree l, a constant, of K whole 64 byte vectors: out[r] = block in[r]. */
YLM_INLINE void FN(block)(const int R, const int l, const int K, const T *b, const T *const *in,
                          T *const *out) {
  enum { W = FULL / LANES };
  V acc[4][2 * W];
  const int at = l * l, w = 2 * l + 1;
  for (int r = 0; r < R; r++)
    for (int k = 0; k < K * W; k++) acc[r][k] = LOAD(b + k * LANES) * SET(in[r][at]);
  for (int i = 1; i < w; i++)
    for (int r = 0; r < R; r++) {
      V xi = SET(in[r][at + i]);
      for (int k = 0; k < K * W; k++) acc[r][k] += LOAD(b + i * K * FULL + k * LANES) * xi;
    }
  for (int r = 0; r < R; r++) memcpy(out[r] + at, acc[r], (size_t)w * sizeof(T));
}

/* R vectors of one degree wider than that; out may end right behind its 2l+1 numbers. */
YLM_INLINE void FN(block_wide)(const int R, int l, int padded, const T *b, const T *const *in,
                               T *const *out, int at) {
  int w = 2 * l + 1;
  for (int k = 0; k + LANES < padded; k += 2 * LANES) {
    V first[4], second[4];
    for (int r = 0; r < R; r++) first[r] = second[r] = SET(0);
    for (int i = 0; i < w; i++) {
      V b0 = LOAD(b + i * padded + k), b1 = LOAD(b + i * padded + k + LANES);
      for (int r = 0; r < R; r++) {
        V xi = SET(in[r][at + i]);
        first[r] += b0 * xi;
        second[r] += b1 * xi;
      }
    }
    for (int r = 0; r < R; r++) {
      STORE(out[r] + k, first[r]);
      STORE(out[r] + k + LANES, second[r]);
    }
  }
  if ((padded / LANES) & 1) {
    int k = padded - LANES;
    V only[4];
    for (int r = 0; r < R; r++) only[r] = SET(0);
    for (int i = 0; i < w; i++) {
      V b0 = LOAD(b + i * padded + k);
      for (int r = 0; r < R; r++) only[r] += b0 * SET(in[r][at + i]);
    }
    for (int r = 0; r < R; r++) STORE(out[r] + k, only[r]);
  }
}

/* Degrees whose blocks are unrolled. */
#define UNROLLED(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7)

YLM_INLINE void FN(apply_rows)(const int R, int lmax, const T *b, const T *const *in,
                               T *const *out) {
  for (int l = 0; l <= lmax; l++) {
    int padded = rotate_padded(l, FULL);
    switch (l) {
#define X(l)                                                                                       \
  case l: FN(block)(R, l, (2 * l + FULL) / FULL, b, in, out); break;
      UNROLLED(X)
#undef X
    default: {
      T wide[4][2 * YLM_SH_ROTATE_LMAX + 1 + FULL] __attribute__((aligned(64)));
      T *const to[4] = {wide[0], wide[1], wide[2], wide[3]};
      FN(block_wide)(R, l, padded, b, in, to, l * l);
      for (int r = 0; r < R; r++) memcpy(out[r] + l * l, wide[r], (size_t)(2 * l + 1) * sizeof(T));
    }
    }
    b += (2 * l + 1) * padded;
  }
}

/* -- degrees by quarter turns, TILE rows at once
 * --------------------------------------------------- */

#define TILE (2 * LANES)

/* R rows of one class of J times the tile's rows, of which every second belongs to a class. */
YLM_INLINE void FN(panel)(const int R, int columns, const T *j, const T *x, int x_step, T *y,
                          int y_step) {
  V sum[ROTATE_PANEL][2];
  for (int r = 0; r < R; r++) sum[r][0] = sum[r][1] = SET(0);
  for (int i = 0; i < columns; i++, x += x_step, j += R) {
    V x0 = LOAD(x), x1 = LOAD(x + LANES);
    for (int r = 0; r < R; r++) {
      V a = SET(j[r]);
      sum[r][0] += a * x0;
      sum[r][1] += a * x1;
    }
  }
  for (int r = 0; r < R; r++, y += y_step) {
    STORE(y, sum[r][0]);
    STORE(y + LANES, sum[r][1]);
  }
}

/* y = J x for degree l; x and y [2l+1][TILE], j the degree's panels. */
static void FN(quarter_tile)(int l, const T *j, const T *x, T *y) {
  for (int c = 0; c < 4; c++) {
    int columns = class_size(l, c), to = class_partner(l, c), left = class_size(l, to);
    int x_step = c & 1 ? -2 * TILE : 2 * TILE, y_step = to & 1 ? -2 * TILE : 2 * TILE;
    const T *from = x + (l + class_first(c)) * TILE;
    T *at = y + (l + class_first(to)) * TILE;
    while (left > 0) {
      int rows = left < ROTATE_PANEL ? left : ROTATE_PANEL;
      switch (rows) {
#define X(n)                                                                                       \
  case n: FN(panel)(n, columns, j, from, x_step, at, y_step); break;
        X(1)
        X(2)
        X(3)
        X(4)
#if ROTATE_PANEL > 4
        X(5) X(6) X(7) X(8)
#endif
#undef X
      }
      j += rows * columns;
      at += rows * y_step;
      left -= rows;
    }
  }
}

/* x = Z x for degree l; c, s: cosine and sine of m times the angle. */
static void FN(turn_tile)(int l, const T *c, const T *s, T *x) {
  for (int m = 1; m <= l; m++) {
    T *a = x + (l + m) * TILE, *b = x + (l - m) * TILE;
    V cm = SET(c[m]), sm = SET(s[m]);
    for (int k = 0; k < TILE; k += LANES) {
      V ak = LOAD(a + k), bk = LOAD(b + k);
      STORE(a + k, cm * ak - sm * bk);
      STORE(b + k, sm * ak + cm * bk);
    }
  }
}

/* x = H x for degree l. */
static void FN(half_tile)(int l, T *x) {
  for (int m = -l; m <= l; m++)
    if (half_turn_sign(l, m) < 0)
      for (int k = 0; k < TILE; k += LANES)
        STORE(x + (l + m) * TILE + k, -LOAD(x + (l + m) * TILE + k));
}

/* Degrees first .. lmax of TILE rows, which may be their own results. */
static void FN(tile)(const ylm__rotate_batch *b, int first, int lmax, const T *const *in,
                     T *const *out) {
  T x[(2 * YLM_SH_ROTATE_LMAX + 1) * TILE] __attribute__((aligned(64)));
  T y[(2 * YLM_SH_ROTATE_LMAX + 1) * TILE] __attribute__((aligned(64)));
  const T *table = b->turns;
  int row = b->lmax + 1;
  for (int l = first; l <= lmax; l++) {
    int n = 2 * l + 1;
    size_t at = (size_t)l * (size_t)l;
    const T *j = (const T *)b->plan->PANELS + b->plan->panel_at[l];
    T *result = x;
    for (int k = 0; k < TILE; k += LANES) FN(to_tile)(in + k, at, n, x + k, TILE);
    FN(turn_tile)(l, table + 4 * row, table + 5 * row, x);
    switch (b->turn) {
    case TURN_FLAT: break;
    case TURN_HALF: FN(half_tile)(l, x); break;
    case TURN_QUARTER:
      FN(quarter_tile)(l, j, x, y);
      result = y;
      break;
    default:
      FN(quarter_tile)(l, j, x, y);
      FN(turn_tile)(l, table + 2 * row, table + 3 * row, y);
      FN(quarter_tile)(l, j, y, x);
    }
    if (b->turn != TURN_FLAT) FN(turn_tile)(l, table, table + row, result);
    for (int k = 0; k < TILE; k += LANES) FN(from_tile)(result + k, TILE, n, at, out + k);
  }
}

/* R rows, each by itself: blocks as far as there are some. */
YLM_INLINE void FN(few)(const int R, const ylm__rotate_batch *b, int lmax, const T *const *in,
                        T *const *out) {
  FN(apply_rows)(R, lmax < b->blocked ? lmax : b->blocked, b->blocks, in, out);
  if (lmax > b->blocked)
    for (int r = 0; r < R; r++)
      FN(degrees)(b->plan, b->blocked + 1, lmax, &b->angles, in[r], out[r]);
}

static void FN(apply)(const ylm__rotate_batch *b, int lmax, size_t rows, const T *in, T *out) {
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1), r = 0;
  const T *from[TILE];
  T *to[TILE];
  while (r < rows) {
    size_t left = rows - r, n = left < TILE ? left : TILE;
    for (size_t i = 0; i < TILE; i++) { /* what is missing repeats the last row */
      size_t k = r + (i < n ? i : n - 1);
      from[i] = in + k * count;
      to[i] = out + k * count;
    }
    bool tiled = lmax >= ROTATE_TILED && n >= TILE / 4;
    int low = tiled ? ROTATE_TILED - 1 : lmax;
    size_t i = 0;
    for (; i + 4 <= n; i += 4) FN(few)(4, b, low, from + i, to + i);
    for (; i < n; i++) FN(few)(1, b, low, from + i, to + i);
    if (tiled) FN(tile)(b, ROTATE_TILED, lmax, from, to);
    r += n;
  }
}
#undef UNROLLED
#undef TILE
