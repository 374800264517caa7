/*
** body.h - the moment kernel of one lmax (LMAX) and one element type; see moments.h.
**
** Included by kernel.h with REAL, V (vector), VI (integer vector), LANES, LAMP, NAME(x),
** and rsqrt and reciprocal defined. The plan of passes (which columns share the registers) is
** generated: gen/moments_*.isa.c.
*/

YLM_INLINE V NAME(set)(REAL x) { return (V){0} + x; }
YLM_INLINE V NAME(choose)(VI mask, V a, V b) { return (V)(((VI)a & mask) | ((VI)b & ~mask)); }
/* a with the sign changed in the lanes where `sign` has its bit. */
YLM_INLINE V NAME(turn)(V a, VI sign) { return (V)((VI)a ^ sign); }

#include "gen/light.h"

/* Constants of the recurrences, where lmax is not known to the compiler. */
typedef struct NAME(constants) {
#ifdef ANY_LMAX
  REAL slows[LMAX + 3], step[LMAX + 3], rho[LMAX + 3];
#else
  char none;
#endif
} NAME(constants);

static inline void NAME(find_constants)(NAME(constants) * c, int degree) {
#ifdef ANY_LMAX
  for (int n = 0; n <= degree; n++) {
    c->slows[n] = SLOWS(n);
    c->step[n] = STEP(n);
    c->rho[n] = RHO(n);
  }
#else
  c->none = 0, (void)degree;
#endif
}

/* Weight a of degree k, where directions below the horizon are turned. */
#define ODD(k, a) (fine && (k) % 2 ? NAME(turn)(a, below) : (a))

/* One light's geometry and weights for LANES points: times `emission`, and the third kind's times
   `bent` too. */
YLM_INLINE void NAME(prepare_one)(const int lmax, const int kinds, const NAME(constants) * con,
                                  const LAMP *lamp, REAL emission, REAL bent, V x, V y, V z, V *g,
                                  V *w, VI *inside) {
  const int K = ylm__degree_of(lmax, kinds);
  (void)con;
  x = lamp->at[0] - x, y = lamp->at[1] - y, z = lamp->at[2] - z;
  V r = NAME(set)(lamp->radius), d2 = x * x + y * y + z * z, u[LMAX + 4];
  const NAME(light) l = NAME(seen)(d2, SQUARES(d2, r, lamp->radius), r, NAME(set)(emission));
  *inside |= ~l.outside;
  x *= l.invd, y *= l.invd, z *= l.invd;
  const bool fine = FINE(lmax) > 0;                        /* then w is turned to where z >= 0 */
  const VI below = fine ? (VI)z & (VI) - (V){0} : (VI){0}; /* sign bits of z */
  if (fine) {
    x = NAME(turn)(x, below), y = NAME(turn)(y, below), z = NAME(turn)(z, below);
    g[ylm__below_pole(lmax)] = GROW * (x * x + y * y) * NAME(reciprocal)(1 + z);
  }
  g[0] = GROW * z;
  V far = bent * l.far, e = {0}, c = x, s = y;
  u[0] = l.es;
  /* two recurrences, one beside the other because each waits for itself */
  UNROLL
  for (int n = 0; n < K; n++) {
    TOGETHER(c, e);
    g[2 * n + 1] = c, g[2 * n + 2] = s;
    NAME(weight_step)
    (CONSTANT(slows, SLOWS, n), CONSTANT(step, STEP, n), l.delta, e, u[n], &e, &u[n + 1]);
    NAME(next_power)(x, y, c, s, &c, &s);
  }
  if (kinds & YLM__M0) {
    w[0] = l.first;
    UNROLL
    for (int k = 1; k <= lmax; k++) w[k] = ODD(k, u[k - 1]);
  }
  if (kinds & YLM__M1) {
    w[ylm__weight_at(lmax, 1, 0)] = NAME(set)(0);
    UNROLL
    for (int k = 1; k <= lmax + 1; k++) w[ylm__weight_at(lmax, 1, k)] = ODD(k, u[k - 1] * l.invh);
  }
  if (kinds & YLM__M2) {
    w[ylm__weight_at(lmax, 2, 0)] = l.es * far;
    w[ylm__weight_at(lmax, 2, 1)] = NAME(set)(0);
    UNROLL
    for (int k = 2; k <= lmax + 2; k++)
      w[ylm__weight_at(lmax, 2, k)] =
          ODD(k, NAME(bent_weight)(CONSTANT(rho, RHO, k), u[k], u[k - 2], far));
  }
}

#undef ODD

static void NAME(prepare)(int lmax, int kinds, int n, const void *lamps, int bright,
                          const void *xyz, void *geometry, void *weights, void *inside) {
  const LAMP *lamp = lamps;
  const V *at = xyz;
  V *g = geometry, *w = weights;
  const int G = ylm__geometry_slots(FIXED(lmax)), W = ylm__weight_slots(FIXED(lmax));
  NAME(constants) con;
  NAME(find_constants)(&con, ylm__degree_of(lmax, kinds));
#define X(set)                                                                                     \
  if (kinds == set)                                                                                \
    for (int j = 0; j < n; j++) NAME(prepare_one)                                                  \
  (FIXED(lmax), set, &con, &lamp[j], bright & YLM__M0 ? lamp[j].luminance : (REAL)1,               \
   bright == YLM__M2 ? lamp[j].luminance : (REAL)1, at[0], at[1], at[2], g + j * G, w + j * W,     \
   inside);
  YLM__KIND_SETS(X)
#undef X
}

/*
** Adds the products of one light for degrees k0 .. k1-1 of the column (m, side), side 0 the real
** and 1 the imaginary part, to the sums at a: one for each kind, or with `rgb` three, weighted with
** the emission e. A column that ends early is resumed from `state`.
*/
YLM_INLINE void NAME(segment)(const int lmax, const int kinds, const bool rgb, const int m,
                              const int side, const int k0, const int k1, const V *g, const V *w,
                              const V *e, V *state, V *a) {
  const int K = ylm__degree_of(lmax, kinds);
  V z = g[0], low = g[ylm__below_pole(lmax)], q, before = {0};
  if (k0 > m)
    q = state[0], before = state[1];
  else
    q = m == 0 ? NAME(set)(1) : g[2 * m - 1 + side];
  UNROLL
  for (int k = k0; k < k1; k++) {
    UNROLL
    for (int kind = 0; kind < 3; kind++)
      if (ylm__has(lmax, kinds, kind, k)) {
        V weight = w[ylm__weight_at(lmax, kind, k)];
        if (!rgb) {
          *a = k == 0 ? *a + weight : *a + q * weight;
          a++;
          continue;
        }
        V term = k == 0 ? weight : q * weight;
        for (int c = 0; c < 3; c++) *a += e[c] * term, a++;
      }
    if (k == K) break;
    if (m < FINE(lmax)) {
      before *= SLOW(k, m);
      TOGETHER(before, q);
      before -= low * q;
      q = KEEP(k, m) * q + before;
      continue;
    }
    V next = k == 0 ? z : k == m ? z * q : NAME(rise)(BETA(k, m), z, q, before);
    before = q, q = next;
  }
  if (k1 <= K) state[0] = q, state[1] = before;
}

#ifndef ANY_LMAX

/* A pass over a tile: sums first .. first+count-1 of all channels are in a, channel by channel in
   memory and together in a. */
#define PASS(first, count)                                                                         \
  {                                                                                                \
    V *total = sums + (first), a[CHANNELS * (count)];                                              \
    UNROLL                                                                                         \
    for (int i = 0; i < CHANNELS * (count); i++)                                                   \
      a[i] = total[i % CHANNELS * stride + i / CHANNELS];                                          \
    for (int j = 0; j < n; j++) {                                                                  \
      const V *g = geometry + j * ylm__geometry_slots(LMAX);                                       \
      const V *w = weights + j * ylm__weight_slots(LMAX);                                          \
      const V *e = emission + 3 * j;                                                               \
      V *saved = state + 2 * j;                                                                    \
      (void)saved, (void)e;
#define SEGMENT(m, side, k0, k1, offset)                                                           \
  NAME(segment)                                                                                    \
  (LMAX, KINDS, CHANNELS == 3, m, side, k0, k1, g, w, e, saved, a + CHANNELS * (offset));
#define END(count)                                                                                 \
  }                                                                                                \
  UNROLL                                                                                           \
  for (int i = 0; i < CHANNELS * (count); i++) total[i % CHANNELS * stride + i / CHANNELS] = a[i]; \
  }

#define SUM(set)                                                                                   \
  static void NAME(sum_##set)(int n, const V *geometry, const V *weights, V *state, V *sums) {     \
    enum { KINDS = set, CHANNELS = 1, stride = 0 };                                                \
    const V *emission = NULL;                                                                      \
    PLAN_##set                                                                                     \
  }                                                                                                \
  static void NAME(sum_rgb_##set)(int n, const V *geometry, const V *weights, const V *emission,   \
                                  V *state, V *sums, int stride) {                                 \
    enum { KINDS = set, CHANNELS = 3 };                                                            \
    PLAN_RGB_##set                                                                                 \
  }
YLM__KIND_SETS(SUM)
#undef SUM
#undef PASS
#undef SEGMENT
#undef END

static void NAME(sum)(int lmax, int kinds, int n, const void *geometry, const void *weights,
                      void *state, void *sums) {
  (void)lmax;
#define X(set)                                                                                     \
  if (kinds == set) NAME(sum_##set)(n, geometry, weights, state, sums);
  YLM__KIND_SETS(X)
#undef X
}

static void NAME(sum_rgb)(int lmax, int kinds, int n, const void *geometry, const void *weights,
                          const void *emission, void *state, void *sums, int stride) {
  (void)lmax;
#define X(set)                                                                                     \
  if (kinds == set) NAME(sum_rgb_##set)(n, geometry, weights, emission, state, sums, stride);
  YLM__KIND_SETS(X)
#undef X
}

#else

#include "general.h"

#endif
