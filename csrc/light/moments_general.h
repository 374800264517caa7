/*
** moments_general.h - sums of the moment kernel whose lmax is known at run time only.
**
** Included by moments_body.h. A column, which is all degrees of one (m, real or imaginary), is cut
** into chunks whose sums fit into registers. Code is made for each length of a chunk, and for the
** degrees lmax+1 and lmax+2 at the end of the last, which have fewer sums than those before.
*/

/* Sums that fit into registers beside the rest. */
#if defined(__AVX512F__) || defined(__aarch64__)
#define ROOM 24
#else
#define ROOM 12
#endif

/* A tile of n lights at one chunk of a column. */
typedef struct NAME(chunk) {
  int n, G, W, rest;       /* lights, places of one in g and in w[], place of the rest of z */
  const V *g, *w[3];       /* the first light's geometry, and weights at the first degree */
  const V *q, *before;     /* polynomials at the first degree and before it, */
  int q_step, before_step; /* of each light this far apart */
  const REAL *beta;        /* from the first degree on */
  V *state;                /* polynomials behind the last degree: [n][2] */
} NAME(chunk);

/* Sums of `full` degrees at which all kinds of a set exist, and of the `tail` degrees above (full
   -1 is the column of order lmax+2, which has one). */
#define WIDTH(kinds) (((kinds)&1) + ((kinds) >> 1 & 1) + ((kinds) >> 2 & 1))
#define SUMS(kinds, full, tail)                                                                    \
  ((full) < 0                                                                                      \
       ? 1                                                                                         \
       : WIDTH(kinds) * (full) + ((tail) < 0 ? 0 : ((kinds) >> 1 & 1) + 2 * ((kinds) >> 2 & 1)))
#define TAIL(kinds) ((kinds)&YLM__M2 ? 2 : (kinds)&YLM__M1 ? 1 : 0)
#define MOST(kinds) (ROOM / WIDTH(kinds))
#define LAST(kinds) ((ROOM - SUMS(kinds, 0, TAIL(kinds))) / WIDTH(kinds))

/* Adds a chunk of `full` degrees <= lmax to a, and `tail` degrees above if it is the last of a
   column; tail -1: another follows. s has room for the sums. */
YLM_INLINE void NAME(add_chunk)(const int kinds, const int full, const int tail, const bool fine,
                                const NAME(chunk) * chunk, V *a, V *s) {
  const int count = SUMS(kinds, full, tail), degrees = tail < 0 ? full : full + tail;
  const NAME(chunk) c = *chunk;
  UNROLL_ALL
  for (int i = 0; i < count; i++) s[i] = a[i];
  for (int j = 0; j < c.n; j++) {
    const V *g = c.g + j * c.G;
    V z = g[0], rest = g[c.rest], q = c.q[j * c.q_step], before = c.before[j * c.before_step];
    int i = 0;
    UNROLL_ALL
    for (int d = 0; d < degrees; d++) {
      UNROLL_ALL
      for (int kind = 0; kind < 3; kind++)
        if (kinds & (1 << kind) && (tail < 0 || d < full + kind))
          s[i] += q * c.w[kind][j * c.W + d], i++;
      if (tail >= 0 && d == degrees - 1) break;
      V next = fine ? z * q + (rest * q - c.beta[d] * before) : z * q - c.beta[d] * before;
      before = q, q = next;
    }
    if (tail < 0) c.state[2 * j] = q, c.state[2 * j + 1] = before;
  }
  UNROLL_ALL
  for (int i = 0; i < count; i++) a[i] = s[i];
}

/* The columns of a set of kinds, for all lights of a tile: `full` degrees <= lmax; returns where a
   goes on. */
#define CASE(set, fine, f)                                                                         \
  case f:                                                                                          \
    if ((f) >= -(TAIL(set) / 2) && (f) <= LAST(set)) {                                             \
      V s[SUMS(set, f, 0) > 0 ? SUMS(set, f, 0) : 1];                                              \
      NAME(add_chunk)(set, f, TAIL(set), fine, c, a, s);                                           \
    }                                                                                              \
    break;
#define COLUMN(name, set, fine)                                                                    \
  static V *NAME(name##set)(int full, NAME(chunk) * c, V * a) {                                    \
    while (full > LAST(set)) {                                                                     \
      V s[SUMS(set, MOST(set), -1)];                                                               \
      NAME(add_chunk)(set, MOST(set), -1, fine, c, a, s);                                          \
      a += SUMS(set, MOST(set), -1), full -= MOST(set);                                            \
      for (int kind = 0; kind < 3; kind++) c->w[kind] += MOST(set);                                \
      c->beta += MOST(set);                                                                        \
      c->q = c->state, c->before = c->state + 1, c->q_step = c->before_step = 2;                   \
    }                                                                                              \
    switch (full) {                                                                                \
      CASE(set, fine, -1)                                                                          \
      CASE(set, fine, 0)                                                                           \
      CASE(set, fine, 1)                                                                           \
      CASE(set, fine, 2) CASE(set, fine, 3) CASE(set, fine, 4) CASE(set, fine, 5)                  \
          CASE(set, fine, 6) CASE(set, fine, 7) CASE(set, fine, 8) CASE(set, fine, 9)              \
              CASE(set, fine, 10) CASE(set, fine, 11) CASE(set, fine, 12) CASE(set, fine, 13)      \
                  CASE(set, fine, 14) CASE(set, fine, 15) CASE(set, fine, 16) CASE(set, fine, 17)  \
                      CASE(set, fine, 18) CASE(set, fine, 19) CASE(set, fine, 20)                  \
                          CASE(set, fine, 21) CASE(set, fine, 22) CASE(set, fine, 23)              \
                              CASE(set, fine, 24)                                                  \
    }                                                                                              \
    return a + SUMS(set, full, TAIL(set));                                                         \
  }

#define COLUMNS(set) COLUMN(plain_, set, false) COLUMN(fine_, set, FINE(LMAX) > 0)
YLM__KIND_SETS(COLUMNS)

static void NAME(sum)(int lmax, int kinds, int n, const void *geometry, const void *weights,
                      void *state, void *sums) {
  typedef V *column(int full, NAME(chunk) * c, V * a);
  static column *const plain[8] = {[1] = NAME(plain_1),
                                   [3] = NAME(plain_3),
                                   [4] = NAME(plain_4),
                                   [5] = NAME(plain_5),
                                   [7] = NAME(plain_7)};
  static column *const fine[8] = {[1] = NAME(fine_1),
                                  [3] = NAME(fine_3),
                                  [4] = NAME(fine_4),
                                  [5] = NAME(fine_5),
                                  [7] = NAME(fine_7)};
  const V *g = geometry, *w = weights, zero = {0}, one = zero + 1;
  const int K = ylm__degree_of(lmax, kinds);
  double inverse[LMAX + 3];
  REAL beta[LMAX + 3];
  V *a = sums;
  for (int k = 0; k <= K; k++) inverse[k] = GROW * GROW / (4.0 * k * k - 1);
  for (int m = 0; m <= K; m++) {
    for (int k = m; k <= K; k++) beta[k] = (REAL)((double)(k * k - m * m) * inverse[k]);
    for (int side = 0; side < (m ? 2 : 1); side++) {
      NAME(chunk)
      c = {.n = n,
           .G = ylm__geometry_slots(lmax),
           .W = ylm__weight_slots(lmax),
           .rest = ylm__rest_of_z(lmax),
           .g = g,
           .q = m ? g + 2 * m - 1 + side : &one,
           .before = &zero,
           .beta = beta + m,
           .state = state};
      c.q_step = m ? c.G : 0;
      for (int kind = 0; kind < 3; kind++) c.w[kind] = w + ylm__weight_at(lmax, kind, m);
      a = (m < FINE(lmax) ? fine : plain)[kinds](lmax + 1 - m, &c, a);
    }
  }
}

#undef ROOM
#undef WIDTH
#undef SUMS
#undef TAIL
#undef MOST
#undef LAST
#undef CASE
#undef COLUMN
#undef COLUMNS
