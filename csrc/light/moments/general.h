/*
** general.h - sums of the moment kernel whose lmax is known at run time only. Private to csrc/light.
**
** A column, which is all degrees of one (m, real or imaginary), is cut into chunks whose sums fit into
** registers. Code is made for each length of a chunk. The degrees lmax+1 and lmax+2 at the end of the last chunk have fewer
** sums than those before, and code of their own.
**
** In one channel the columns of either side of an order are summed together: its polynomials are found without the
** factors Re, Im (x+iy)^m, and a polynomial times a weight is added to both. Half of the loads are saved so.
** In three channels the sums of both sides do not fit into registers beside each other.
*/
#ifndef YLM_LIGHT_MOMENTS_GENERAL_H
#define YLM_LIGHT_MOMENTS_GENERAL_H

#include "ylm_light.h"

#define ANY_LMAX
#define LMAX YLM_LIGHT_LMAX
#define KERNEL_NAME YLM_REAL_KERNEL(ylm__moments_any)
#include "kernel.h"

/* A tile of n lights at one chunk of a column. */
typedef struct chunk {
  int n, G, W, low;        /* lights, places of one in g and in w[], place of 1 - z */
  const vreal *g, *w[3];   /* the first light's geometry, and weights at the first degree */
  const vreal *first;      /* polynomials at the first degree, of each light G apart; NULL: 1 */
  bool resumed;            /* whether `state` has those and the ones before it */
  const real *beta, *keep; /* from the first degree on; beta are SLOW where keep are KEEP */
  const vreal *emission;   /* three channels: [n][3] */
  const vreal *factor;     /* two sides: Re and Im (x+iy)^m, of each light G apart */
  int stride;              /* sums of a channel or a side are this far from those of the next */
  vreal *state;            /* polynomials behind the last degree: [n][2] */
} chunk;

/* The numbers of sums of `full` degrees, at which all kinds of a set exist, and of the `tail`
   degrees above. full -1 is the column of order lmax+2, which has one. Each is kept in `rows`: channels or sides. */
#define WIDTH(kinds) (((kinds)&1) + ((kinds) >> 1 & 1) + ((kinds) >> 2 & 1))
#define SUMS(kinds, full, tail)                                                                    \
  ((full) < 0                                                                                      \
       ? 1                                                                                         \
       : WIDTH(kinds) * (full) + ((tail) < 0 ? 0 : ((kinds) >> 1 & 1) + 2 * ((kinds) >> 2 & 1)))
#define TAIL(kinds) ((kinds)&YLM__M2 ? 2 : (kinds)&YLM__M1 ? 1 : 0)
#define MOST(kinds, rows) (YLM__SUMS / (rows) / WIDTH(kinds))
#define LAST(kinds, rows) ((YLM__SUMS / (rows)-SUMS(kinds, 0, TAIL(kinds))) / WIDTH(kinds))

/* Adds a chunk of `full` degrees <= lmax to a, and `tail` degrees above if it is the last of a
   column; tail -1: another follows. s has room for the sums of all rows. */
YLM_INLINE void add_chunk(const int kinds, const int rows, const int full, const int tail,
                          const bool fine, const chunk *of, vreal *a, vreal *s) {
  const int each = SUMS(kinds, full, tail), count = rows * each,
            degrees = tail < 0 ? full : full + tail;
  const chunk c = *of;
  UNROLL_ALL
  for (int i = 0; i < count; i++) s[i] = a[i / each * c.stride + i % each];
  for (int j = 0; j < c.n; j++) {
    const vreal *g = c.g + j * c.G, *e = rows == 3 ? c.emission + 3 * j : c.factor + j * c.G;
    vreal z = g[fine ? c.low : 0], q = (vreal){0} + 1, before = {0};
    if (c.resumed)
      q = c.state[2 * j], before = c.state[2 * j + 1];
    else if (rows != 2 && c.first)
      q = c.first[j * c.G];
    int i = 0;
    UNROLL_ALL
    for (int d = 0; d < degrees; d++) {
      UNROLL_ALL
      for (int kind = 0; kind < 3; kind++)
        if (kinds & (1 << kind) && (tail < 0 || d < full + kind)) {
          const vreal *w = c.w[kind] + j * c.W + d;
          if (rows == 1) {
            s[i++] += q * *w;
            continue;
          }
          vreal term = q * *w;
          UNROLL_ALL
          for (int row = 0; row < rows; row++) s[row * each + i] += e[row] * term;
          i++;
        }
      if (tail >= 0 && d == degrees - 1) break;
      if (fine) {
        before *= c.beta[d];
        TOGETHER(before, q); /* q waits for two operations, not for three */
        before -= z * q;
        q = c.keep[d] * q + before;
        continue;
      }
      vreal next = rise(c.beta[d], z, q, before);
      before = q, q = next;
    }
    if (tail < 0) c.state[2 * j] = q, c.state[2 * j + 1] = before;
  }
  UNROLL_ALL
  for (int i = 0; i < count; i++) a[i / each * c.stride + i % each] = s[i];
}

/* The columns of a set of kinds, for all lights of a tile: `full` degrees <= lmax; returns where a
   goes on. */
#define CASE(set, rows, fine, f)                                                                   \
  case f:                                                                                          \
    if ((f) >= -(TAIL(set) / 2) && (f) <= LAST(set, rows)) {                                       \
      vreal s[SUMS(set, f, 0) > 0 ? (rows)*SUMS(set, f, TAIL(set)) : 1];                           \
      add_chunk(set, rows, f, TAIL(set), fine, c, a, s);                                           \
    }                                                                                              \
    break;
#define FIVE(set, rows, fine, f)                                                                   \
  CASE(set, rows, fine, f)                                                                         \
  CASE(set, rows, fine, f + 1)                                                                     \
  CASE(set, rows, fine, f + 2)                                                                     \
  CASE(set, rows, fine, f + 3)                                                                     \
  CASE(set, rows, fine, f + 4)
#define COLUMN(name, set, rows, fine)                                                              \
  static vreal *name##set(int full, chunk *c, vreal *a) {                                          \
    enum { most = MOST(set, rows) };                                                               \
    while (full > LAST(set, rows)) {                                                               \
      vreal s[(rows)*SUMS(set, most, -1)];                                                         \
      add_chunk(set, rows, most, -1, fine, c, a, s);                                               \
      a += SUMS(set, most, -1), full -= most;                                                      \
      for (int kind = 0; kind < 3; kind++) c->w[kind] += most;                                     \
      c->beta += most, c->keep += most;                                                            \
      c->resumed = true;                                                                           \
    }                                                                                              \
    switch (full) {                                                                                \
      CASE(set, rows, fine, -1)                                                                    \
      FIVE(set, rows, fine, 0)                                                                     \
      FIVE(set, rows, fine, 5)                                                                     \
      FIVE(set, rows, fine, 10)                                                                    \
      FIVE(set, rows, fine, 15)                                                                    \
      FIVE(set, rows, fine, 20)                                                                    \
    }                                                                                              \
    return a + SUMS(set, full, TAIL(set));                                                         \
  }
#define COLUMNS(set)                                                                               \
  COLUMN(plain_, set, 1, false)                                                                    \
  COLUMN(plain_both_, set, 2, false)                                                               \
  COLUMN(plain_rgb_, set, 3, false)
YLM__KIND_SETS(COLUMNS)

/* Columns of low order, which double has as all others. */
#ifdef YLM_REAL_IS_FLOAT
#define FINE_COLUMNS(set)                                                                          \
  COLUMN(fine_, set, 1, true)                                                                      \
  COLUMN(fine_both_, set, 2, true)                                                                 \
  COLUMN(fine_rgb_, set, 3, true)
YLM__KIND_SETS(FINE_COLUMNS)
#define FINE_OF(name) fine_##name
#else
#define FINE_OF(name) plain_##name
#endif

typedef vreal *column(int full, chunk *c, vreal *a);

/* The columns of a set of kinds: of one side, of both if they are summed together; those of low order by `fine`. */
typedef struct columns {
  column *plain, *fine, *plain_both, *fine_both;
} columns;

/* All columns of a tile. */
static void add_columns(int lmax, int kinds, const columns *by, chunk *c, const vreal *g,
                        const vreal *w, vreal *a) {
  const int K = ylm__degree_of(lmax, kinds);
  double odd[LMAX + 3], inverse[LMAX + 3];
  real beta[LMAX + 3], keep[LMAX + 3];
  c->G = ylm__geometry_slots(lmax), c->W = ylm__weight_slots(lmax), c->low = ylm__below_pole(lmax);
  c->g = g;
  for (int k = 0; k <= K; k++) {
    odd[k] = GROW / (2.0 * k + 1);
    inverse[k] = GROW * GROW / YLM__BELOW(k);
  }
  for (int m = 0; m <= K; m++) {
    const bool slow = m < FINE(lmax), both = m && by->plain_both;
    for (int k = m; slow && k <= K; k++) {
      beta[k] = (real)((k - m) * odd[k]);
      keep[k] = (real)((k + m + 1) * odd[k]);
    }
    for (int k = m; !slow && k <= K; k++) beta[k] = (real)(YLM__ABOVE(k, m) * inverse[k]);
    for (int side = 0; side < (m && !both ? 2 : 1); side++) {
      const vreal *factor = g + 2 * m - 1 + side;
      c->first = m && !both ? factor : NULL, c->resumed = false;
      c->beta = beta + m, c->keep = keep + m;
      for (int kind = 0; kind < 3; kind++) c->w[kind] = w + ylm__weight_at(lmax, kind, m);
      if (!both) {
        a = (slow ? by->fine : by->plain)(lmax + 1 - m, c, a);
        continue;
      }
      c->factor = factor, c->stride = ylm__column_sums(lmax, kinds, m);
      a = (slow ? by->fine_both : by->plain_both)(lmax + 1 - m, c, a) + c->stride;
    }
  }
}

static void sum(int lmax, int kinds, int n, const void *geometry, const void *weights, void *state,
                void *sums) {
  chunk c = {.n = n, .state = state};
#define X(set)                                                                                     \
  if (kinds == set) {                                                                              \
    const columns by = {plain_##set, FINE_OF(set), plain_both_##set, FINE_OF(both_##set)};         \
    add_columns(lmax, set, &by, &c, geometry, weights, sums);                                      \
  }
  YLM__KIND_SETS(X)
#undef X
}

static void sum_rgb(int lmax, int kinds, int n, const void *geometry, const void *weights,
                    const void *emission, void *state, void *sums, int stride) {
  chunk c = {.n = n, .state = state, .emission = emission, .stride = stride};
#define X(set)                                                                                     \
  if (kinds == set) {                                                                              \
    const columns by = {plain_rgb_##set, FINE_OF(rgb_##set), NULL, NULL};                          \
    add_columns(lmax, set, &by, &c, geometry, weights, sums);                                      \
  }
  YLM__KIND_SETS(X)
#undef X
}

YLM__MOMENT_KERNEL

#endif
