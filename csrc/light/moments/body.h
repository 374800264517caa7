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

#ifndef ANY_LMAX

/*
** The parts of plans; all is written out, since the compiler takes far longer to unroll loops.
** A pass over a tile keeps `count` sums of each channel in a, from `first` on: channel by channel
** in memory, together in a. COLUMN begins the column (m, side), side 0 the real and 1 the imaginary
** part, and RESUME goes on with what CUT left in `state`. ADD_s adds the products of degree k for
** the kinds of s to the sums from i on; UP takes the polynomial q from degree k to k+1.
*/
#define PASS(first, count)                                                                         \
  {                                                                                                \
    V *total = sums + (first), a[CHANNELS * (count)], q, before;                                   \
    EACH_##count(TAKE);                                                                            \
    for (int j = 0; j < n; j++) {                                                                  \
      const V *g = geometry + j * GEOMETRY_SLOTS, z = g[0], low = g[GEOMETRY_SLOTS - 1];           \
      const V *w = weights + j * WEIGHT_SLOTS, *e = emission + 3 * j;                              \
      V *saved = state + 2 * j;                                                                    \
      (void)saved, (void)e, (void)z, (void)low;
#define COLUMN(m, side) q = (m) == 0 ? (V){0} + 1 : g[2 * (m)-1 + (side)], before = (V){0};
#define RESUME q = saved[0], before = saved[1];
#define CUT saved[0] = q, saved[1] = before;
#define UP(k, m)                                                                                   \
  if ((m) < FINE(LMAX)) {                                                                          \
    before *= SLOW(k, m);                                                                          \
    TOGETHER(before, q);                                                                           \
    before -= low * q;                                                                             \
    q = KEEP(k, m) * q + before;                                                                   \
  } else {                                                                                         \
    V next = (k) == 0 ? z : (k) == (m) ? z * q : NAME(rise)(BETA(k, m), z, q, before);             \
    before = q, q = next;                                                                          \
  }
#define ADD_1(i, k) ADD(i, w[k])
#define ADD_2(i, k) ADD(i, w[LMAX + 1 + (k)])
#define ADD_3(i, k) ADD_1(i, k) ADD_2(i + 1, k)
#define ADD_4(i, k) ADD(i, w[2 * LMAX + 3 + (k)])
#define ADD_5(i, k) ADD_1(i, k) ADD_4(i + 1, k)
#define ADD_6(i, k) ADD_2(i, k) ADD_4(i + 1, k)
#define ADD_7(i, k) ADD_1(i, k) ADD_2(i + 1, k) ADD_4(i + 2, k)
#define END(count)                                                                                 \
  (void)before;                                                                                    \
  }                                                                                                \
  EACH_##count(GIVE);                                                                              \
  }

#define CHANNELS 1
#define TAKE(i) a[i] = total[i];
#define GIVE(i) total[i] = a[i];
#define ADD(i, weight) a[i] += q * weight;
#define SUM(set)                                                                                   \
  static void NAME(sum_##set)(int n, const V *geometry, const V *weights, V *state, V *sums) {     \
    const V *emission = NULL;                                                                      \
    PLAN_##set                                                                                     \
  }
YLM__KIND_SETS(SUM)
#undef CHANNELS
#undef TAKE
#undef GIVE
#undef ADD
#undef SUM

#define CHANNELS 3
#define TAKE(i)                                                                                    \
  a[3 * i] = total[i], a[3 * i + 1] = total[stride + i], a[3 * i + 2] = total[2 * stride + i];
#define GIVE(i)                                                                                    \
  total[i] = a[3 * i], total[stride + i] = a[3 * i + 1], total[2 * stride + i] = a[3 * i + 2];
#define ADD(i, weight)                                                                             \
  {                                                                                                \
    V term = q * weight;                                                                           \
    a[3 * (i)] += e[0] * term, a[3 * (i) + 1] += e[1] * term, a[3 * (i) + 2] += e[2] * term;       \
  }
#define SUM(set)                                                                                   \
  static void NAME(sum_rgb_##set)(int n, const V *geometry, const V *weights, const V *emission,   \
                                  V *state, V *sums, int stride) {                                 \
    PLAN_RGB_##set                                                                                 \
  }
YLM__KIND_SETS(SUM)
#undef CHANNELS
#undef TAKE
#undef GIVE
#undef ADD
#undef SUM
#undef PASS
#undef COLUMN
#undef RESUME
#undef CUT
#undef UP
#undef ADD_1
#undef ADD_2
#undef ADD_3
#undef ADD_4
#undef ADD_5
#undef ADD_6
#undef ADD_7
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
