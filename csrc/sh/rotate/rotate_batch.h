/*
** rotate_batch.h - rotation of batches, for the unit's element type.
**
** Low degrees: the rotation's blocks times four rows at a time. Higher degrees, where a block has
** four times the numbers of a quarter turn: TILE rows at once, lanes are rows, Z(a) J Z(b) J Z(c)
** degree by degree.
*/
#ifndef YLM_SH_ROTATE_BATCH_H
#define YLM_SH_ROTATE_BATCH_H

#include "rotate_angles.h"
#include "rotate_one.h"
#include "ylm_transpose.h"

/* -- degrees by their blocks ------------------------------------------------------------------ */

/* R vectors of degree l, a constant, of K whole 64 byte vectors: out[r] = block in[r]. */
YLM_INLINE void block(const int R, const int l, const int K, const real *b, const real *const *in,
                      real *const *out) {
  enum { W = FULL / LANES };
  vreal acc[4][2 * W];
  const int at = l * l, w = 2 * l + 1;
  for (int r = 0; r < R; r++)
    for (int k = 0; k < K * W; k++) acc[r][k] = vreal_load(b + k * LANES) * vreal_set(in[r][at]);
  for (int i = 1; i < w; i++)
    for (int r = 0; r < R; r++) {
      vreal xi = vreal_set(in[r][at + i]);
      for (int k = 0; k < K * W; k++) acc[r][k] += vreal_load(b + i * K * FULL + k * LANES) * xi;
    }
  for (int r = 0; r < R; r++) memcpy(out[r] + at, acc[r], (size_t)w * sizeof(real));
}

/* R vectors of one degree wider than that; out may end right behind its 2l+1 numbers. */
YLM_INLINE void block_wide(const int R, int l, int padded, const real *b, const real *const *in,
                           real *const *out, int at) {
  int w = 2 * l + 1;
  for (int k = 0; k + LANES < padded; k += 2 * LANES) {
    vreal first[4], second[4];
    for (int r = 0; r < R; r++) first[r] = second[r] = vreal_set(0);
    for (int i = 0; i < w; i++) {
      vreal b0 = vreal_load(b + i * padded + k), b1 = vreal_load(b + i * padded + k + LANES);
      for (int r = 0; r < R; r++) {
        vreal xi = vreal_set(in[r][at + i]);
        first[r] += b0 * xi;
        second[r] += b1 * xi;
      }
    }
    for (int r = 0; r < R; r++) {
      vreal_store(out[r] + k, first[r]);
      vreal_store(out[r] + k + LANES, second[r]);
    }
  }
  if ((padded / LANES) & 1) {
    int k = padded - LANES;
    vreal only[4];
    for (int r = 0; r < R; r++) only[r] = vreal_set(0);
    for (int i = 0; i < w; i++) {
      vreal b0 = vreal_load(b + i * padded + k);
      for (int r = 0; r < R; r++) only[r] += b0 * vreal_set(in[r][at + i]);
    }
    for (int r = 0; r < R; r++) vreal_store(out[r] + k, only[r]);
  }
}

/* Degrees whose blocks are unrolled. */
#define UNROLLED(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7)

YLM_INLINE void apply_rows(const int R, int lmax, const real *b, const real *const *in,
                           real *const *out) {
  for (int l = 0; l <= lmax; l++) {
    int padded = rotate_padded(l, FULL);
    switch (l) {
#define X(l)                                                                                       \
  case l: block(R, l, (2 * l + FULL) / FULL, b, in, out); break;
      UNROLLED(X)
#undef X
    default: {
      real wide[4][2 * YLM_SH_ROTATE_LMAX + 1 + FULL] __attribute__((aligned(64)));
      real *const to[4] = {wide[0], wide[1], wide[2], wide[3]};
      block_wide(R, l, padded, b, in, to, l * l);
      for (int r = 0; r < R; r++)
        memcpy(out[r] + l * l, wide[r], (size_t)(2 * l + 1) * sizeof(real));
    }
    }
    b += (2 * l + 1) * padded;
  }
}

/* -- degrees by quarter turns, TILE rows at once
 * --------------------------------------------------- */

/* R rows of one class of J times the tile's rows, of which every second belongs to a class. */
YLM_INLINE void panel(const int R, int columns, const real *j, const real *x, int x_step, real *y,
                      int y_step) {
  vreal sum[ROTATE_PANEL][2];
  for (int r = 0; r < R; r++) sum[r][0] = sum[r][1] = vreal_set(0);
  for (int i = 0; i < columns; i++, x += x_step, j += R) {
    vreal x0 = vreal_load(x), x1 = vreal_load(x + LANES);
    for (int r = 0; r < R; r++) {
      vreal a = vreal_set(j[r]);
      sum[r][0] += a * x0;
      sum[r][1] += a * x1;
    }
  }
  for (int r = 0; r < R; r++, y += y_step) {
    vreal_store(y, sum[r][0]);
    vreal_store(y + LANES, sum[r][1]);
  }
}

/* y = J x for degree l; x and y [2l+1][TILE], j the degree's panels. */
static void quarter_tile(int l, const real *j, const real *x, real *y) {
  for (int c = 0; c < 4; c++) {
    int columns = class_size(l, c), to = class_partner(l, c), left = class_size(l, to);
    int x_step = c & 1 ? -2 * TILE : 2 * TILE, y_step = to & 1 ? -2 * TILE : 2 * TILE;
    const real *from = x + (l + class_first(c)) * TILE;
    real *at = y + (l + class_first(to)) * TILE;
    while (left > 0) {
      int rows = left < ROTATE_PANEL ? left : ROTATE_PANEL;
      switch (rows) {
#define X(n)                                                                                       \
  case n: panel(n, columns, j, from, x_step, at, y_step); break;
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
static void turn_tile(int l, const real *c, const real *s, real *x) {
  for (int m = 1; m <= l; m++) {
    real *a = x + (l + m) * TILE, *b = x + (l - m) * TILE;
    vreal cm = vreal_set(c[m]), sm = vreal_set(s[m]);
    for (int k = 0; k < TILE; k += LANES) {
      vreal ak = vreal_load(a + k), bk = vreal_load(b + k);
      vreal_store(a + k, cm * ak - sm * bk);
      vreal_store(b + k, sm * ak + cm * bk);
    }
  }
}

/* x = H x for degree l. */
static void half_tile(int l, real *x) {
  for (int m = -l; m <= l; m++)
    if (half_turn_sign(l, m) < 0)
      for (int k = 0; k < TILE; k += LANES)
        vreal_store(x + (l + m) * TILE + k, -vreal_load(x + (l + m) * TILE + k));
}

/* Degrees first .. lmax of TILE rows, which may be their own results. */
static void tile(const ylm__rotate_batch *b, int first, int lmax, const real *const *in,
                 real *const *out) {
  real x[(2 * YLM_SH_ROTATE_LMAX + 1) * TILE] __attribute__((aligned(64)));
  real y[(2 * YLM_SH_ROTATE_LMAX + 1) * TILE] __attribute__((aligned(64)));
  const real *table = b->turns;
  int row = b->lmax + 1;
  for (int l = first; l <= lmax; l++) {
    int n = 2 * l + 1;
    size_t at = (size_t)l * (size_t)l;
    const real *j = (const real *)b->plan->PANELS + b->plan->panel_at[l];
    real *result = x;
    for (int k = 0; k < TILE; k += LANES) to_tile(in + k, at, n, x + k, TILE);
    turn_tile(l, table + 4 * row, table + 5 * row, x);
    switch (b->turn) {
    case TURN_FLAT: break;
    case TURN_HALF: half_tile(l, x); break;
    case TURN_QUARTER:
      quarter_tile(l, j, x, y);
      result = y;
      break;
    default:
      quarter_tile(l, j, x, y);
      turn_tile(l, table + 2 * row, table + 3 * row, y);
      quarter_tile(l, j, y, x);
    }
    if (b->turn != TURN_FLAT) turn_tile(l, table, table + row, result);
    for (int k = 0; k < TILE; k += LANES) from_tile(result + k, TILE, n, at, out + k);
  }
}

/* R rows, each by itself: blocks as far as there are some. */
YLM_INLINE void few(const int R, const ylm__rotate_batch *b, int lmax, const real *const *in,
                    real *const *out) {
  apply_rows(R, lmax < b->blocked ? lmax : b->blocked, b->blocks, in, out);
  if (lmax > b->blocked)
    for (int r = 0; r < R; r++) degrees(b->plan, b->blocked + 1, lmax, &b->angles, in[r], out[r]);
}

static void apply(const ylm__rotate_batch *b, int lmax, size_t rows, const real *in, real *out) {
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1), r = 0;
  const real *from[TILE];
  real *to[TILE];
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
    for (; i + 4 <= n; i += 4) few(4, b, low, from + i, to + i);
    for (; i < n; i++) few(1, b, low, from + i, to + i);
    if (tiled) tile(b, ROTATE_TILED, lmax, from, to);
    r += n;
  }
}

#endif
