/*
** kernel.h - geometry and weights of lights for the moment kernels of one lmax, for the unit's element type;
** see moments.h. Private to csrc/light.
**
** LMAX is defined before: gen/moments_L.h does so, and general.h, where ANY_LMAX says that lmax is known at
** run time only and that LMAX is its limit. Sums are in special.h and general.h.
*/
#ifndef YLM_LIGHT_MOMENTS_KERNEL_H
#define YLM_LIGHT_MOMENTS_KERNEL_H

#include "gen/recurrences.h"
#include "moments.h"
#include "ylm_real.h"

#define UNROLL_ALL _Pragma("GCC unroll 32")
#ifdef ANY_LMAX
#define FIXED(lmax) (lmax)
#define UNROLL
#define GROW 2
#define CONSTANT(name, FORMULA, n) (con->name[n])
#else
#define FIXED(lmax) LMAX
#define UNROLL UNROLL_ALL
#define GROW 1
#define CONSTANT(name, FORMULA, n) FORMULA(n)
#endif

/* Keeps the compiler from splitting a loop into one for a and one for b. */
#if defined(__aarch64__)
#define TOGETHER(a, b) __asm__("" : "+w"(a), "+w"(b))
#elif defined(__AVX512F__)
#define TOGETHER(a, b) __asm__("" : "+v"(a), "+v"(b))
#else
#define TOGETHER(a, b) __asm__("" : "+x"(a), "+x"(b))
#endif

/* Columns of orders below this are found by differences from the pole. */
#ifdef YLM_REAL_IS_FLOAT
#define FINE(lmax) YLM__FINE(lmax)
typedef ylm__lamp_f real_lamp;
#else
#define FINE(lmax) 0
typedef ylm__lamp_d real_lamp;
#endif

/* Constants of the recurrences, of the element type; z is times GROW. */
#define SLOWS(n) ((real)YLM__SLOWS(n))
#define STEP(n) ((real)YLM__STEP(n))
#define RHO(k) ((real)YLM__RHO(k))
#define BETA(k, m) ((real)(GROW * GROW * YLM__BETA(k, m)))

/* Constants by differences from the pole, with o = 1 - z, from e_m = 0:
   e_(k+1) = SLOW e_k - o q_k, q_(k+1) = KEEP q_k + e_(k+1). */
#define KEEP(k, m) ((real)(GROW * ((double)(k) + (m) + 1) / (2.0 * (k) + 1)))
#define SLOW(k, m) ((real)(GROW * ((double)(k) - (m)) / (2.0 * (k) + 1)))

/* h^2 = d^2 - r^2 with one rounding of r^2 or, without fma, with what that loses in float. */
#if defined(__FMA__) || defined(__aarch64__)
#define SQUARES(d2, r, radius) ((d2) - (r) * (r))
#else
#define SQUARES(d2, r, radius) (((d2)-SQUARE(radius)) - LOST(radius))
#define SQUARE(r) ((real)((double)(r) * (r)))
#define LOST(r) ((real)((double)(r) * (r)-SQUARE(r)))
#endif

/* ylm__geometry_slots and ylm__weight_slots of LMAX as constants. */
#define GEOMETRY_SLOTS (2 + 2 * (LMAX + 2))
#define WEIGHT_SLOTS (3 * LMAX + 6)

/* 1/sqrt(x): an estimate and Newton steps. */
YLM_INLINE vreal rsqrt(vreal x) {
#if defined(__AVX512F__) && defined(YLM_REAL_IS_FLOAT)
  vreal y = (vreal)_mm512_rsqrt14_ps((__m512)x);
  return y + y * (1 - x * y * y) * 0.5f;
#elif defined(__AVX2__) && defined(YLM_REAL_IS_FLOAT)
  vreal y = (vreal)_mm256_rsqrt_ps((__m256)x);
  y = y + y * (1 - x * y * y) * 0.5f;
  return y + y * (1 - x * y * y) * 0.5f;
#elif defined(__AVX512F__)
  vreal y = (vreal)_mm512_rsqrt14_pd((__m512d)x);
  y = y + y * (1 - x * y * y) * 0.5;
  return y + y * (1 - x * y * y) * 0.5;
#else
  return 1 / vreal_sqrt(x);
#endif
}

YLM_INLINE vreal reciprocal(vreal x) {
#if defined(__AVX512F__) && defined(YLM_REAL_IS_FLOAT)
  vreal y = (vreal)_mm512_rcp14_ps((__m512)x);
  return y + y * (1 - x * y);
#elif defined(__AVX512F__)
  vreal y = (vreal)_mm512_rcp14_pd((__m512d)x);
  y = y + y * (1 - x * y);
  return y + y * (1 - x * y);
#else
  return 1 / x;
#endif
}

YLM_INLINE vreal choose(vmask mask, vreal a, vreal b) {
  return (vreal)(((vmask)a & mask) | ((vmask)b & ~mask));
}
/* a with the sign changed in the lanes where `sign` has its bit. */
YLM_INLINE vreal turn(vreal a, vmask sign) { return (vreal)((vmask)a ^ sign); }

#include "gen/light.h"

/* Constants of the recurrences, where lmax is not known to the compiler. */
typedef struct constants {
#ifdef ANY_LMAX
  real slows[LMAX + 3], step[LMAX + 3], rho[LMAX + 3];
#else
  char none;
#endif
} constants;

static inline void find_constants(constants *c, int degree) {
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
#define ODD(k, a) (fine && (k) % 2 ? turn(a, below) : (a))

/* One light's geometry and weights for LANES points: times `emission`, and the third kind's times
   `bent` too. */
YLM_INLINE void prepare_one(const int lmax, const int kinds, const constants *con,
                            const real_lamp *lamp, real emission, real bent, vreal x, vreal y,
                            vreal z, vreal *g, vreal *w, vmask *inside) {
  const int K = ylm__degree_of(lmax, kinds);
  (void)con;
  x = lamp->at[0] - x, y = lamp->at[1] - y, z = lamp->at[2] - z;
  vreal r = vreal_set(lamp->radius), d2 = x * x + y * y + z * z, u[LMAX + 4];
  const light l = seen(d2, SQUARES(d2, r, lamp->radius), r, vreal_set(emission));
  *inside |= ~l.outside;
  x *= l.invd, y *= l.invd, z *= l.invd;
  const bool fine = FINE(lmax) > 0; /* then w is turned to where z >= 0 */
  const vmask below = fine ? (vmask)z & (vmask) - (vreal){0} : (vmask){0}; /* sign bits of z */
  if (fine) {
    x = turn(x, below), y = turn(y, below), z = turn(z, below);
    g[ylm__below_pole(lmax)] = GROW * (x * x + y * y) * reciprocal(1 + z);
  }
  g[0] = GROW * z;
  vreal far = bent * l.far, e = {0}, c = x, s = y;
  u[0] = l.es;
  /* two recurrences, one beside the other because each waits for itself */
  UNROLL
  for (int n = 0; n < K; n++) {
    TOGETHER(c, e);
    g[2 * n + 1] = c, g[2 * n + 2] = s;
    weight_step(CONSTANT(slows, SLOWS, n), CONSTANT(step, STEP, n), l.delta, e, u[n], &e,
                &u[n + 1]);
    next_power(x, y, c, s, &c, &s);
  }
  if (kinds & YLM__M0) {
    w[0] = l.first;
    UNROLL
    for (int k = 1; k <= lmax; k++) w[k] = ODD(k, u[k - 1]);
  }
  if (kinds & YLM__M1) {
    w[ylm__weight_at(lmax, 1, 0)] = vreal_set(0);
    UNROLL
    for (int k = 1; k <= lmax + 1; k++) w[ylm__weight_at(lmax, 1, k)] = ODD(k, u[k - 1] * l.invh);
  }
  if (kinds & YLM__M2) {
    w[ylm__weight_at(lmax, 2, 0)] = l.es * far;
    w[ylm__weight_at(lmax, 2, 1)] = vreal_set(0);
    UNROLL
    for (int k = 2; k <= lmax + 2; k++)
      w[ylm__weight_at(lmax, 2, k)] =
          ODD(k, bent_weight(CONSTANT(rho, RHO, k), u[k], u[k - 2], far));
  }
}

#undef ODD

static void prepare(int lmax, int kinds, int n, const void *lamps, int bright, const void *xyz,
                    void *geometry, void *weights, void *inside) {
  const real_lamp *lamp = lamps;
  const vreal *at = xyz;
  vreal *g = geometry, *w = weights;
  const int G = ylm__geometry_slots(FIXED(lmax)), W = ylm__weight_slots(FIXED(lmax));
  constants con;
  find_constants(&con, ylm__degree_of(lmax, kinds));
#define X(set)                                                                                     \
  if (kinds == set)                                                                                \
    for (int j = 0; j < n; j++)                                                                    \
      prepare_one(FIXED(lmax), set, &con, &lamp[j], bright &YLM__M0 ? lamp[j].luminance : (real)1, \
                  bright == YLM__M2 ? lamp[j].luminance : (real)1, at[0], at[1], at[2], g + j * G, \
                  w + j * W, inside);
  YLM__KIND_SETS(X)
#undef X
}

/* The unit's kernel, once `prepare`, `sum` and `sum_rgb` are there. */
#define YLM__MOMENT_KERNEL                                                                         \
  extern const ylm__moment_kernel KERNEL_NAME;                                                     \
  const ylm__moment_kernel KERNEL_NAME = {LANES, GROW, prepare, sum, sum_rgb};

#endif
