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
#define ODD(k, a) (fine && (k) % 2 ? turn(a, below[i]) : (a))

/* Lights that are prepared together, since the recurrences of one wait for themselves. */
#define BESIDE (LMAX < 3 ? 1 : 2)

/* Geometry and weights of BESIDE lights for LANES points, at g[i] and w[i]: times `emission`, and the third kind's
   times `bent` too. */
YLM_INLINE void prepare_some(const int lmax, const int kinds, const constants *con,
                             const real_lamp *const *lamp, const real *emission, const real *bent,
                             const vreal *at, vreal *const *g, vreal *const *w, vmask *inside) {
  const int K = ylm__degree_of(lmax, kinds);
  const bool fine = FINE(lmax) > 0; /* then w is turned to where z >= 0 */
  (void)con;
  vreal x[BESIDE], y[BESIDE], c[BESIDE], s[BESIDE], e[BESIDE], far[BESIDE], u[BESIDE][LMAX + 4];
  vmask below[BESIDE]; /* sign bits of z */
  light l[BESIDE];
  UNROLL_ALL
  for (int i = 0; i < BESIDE; i++) {
    x[i] = lamp[i]->at[0] - at[0], y[i] = lamp[i]->at[1] - at[1];
    vreal z = lamp[i]->at[2] - at[2], r = vreal_set(lamp[i]->radius);
    vreal d2 = x[i] * x[i] + y[i] * y[i] + z * z;
    l[i] = seen(d2, SQUARES(d2, r, lamp[i]->radius), r, vreal_set(emission[i]));
    *inside |= ~l[i].outside;
    x[i] *= l[i].invd, y[i] *= l[i].invd, z *= l[i].invd;
    below[i] = fine ? (vmask)z & (vmask) - (vreal){0} : (vmask){0};
    if (fine) {
      x[i] = turn(x[i], below[i]), y[i] = turn(y[i], below[i]), z = turn(z, below[i]);
      g[i][ylm__below_pole(lmax)] = GROW * (x[i] * x[i] + y[i] * y[i]) * reciprocal(1 + z);
    }
    g[i][0] = GROW * z;
    far[i] = bent[i] * l[i].far, e[i] = (vreal){0}, c[i] = x[i], s[i] = y[i];
    u[i][0] = l[i].es;
  }
  /* two recurrences, one beside the other because each waits for itself */
  UNROLL
  for (int n = 0; n < K; n++) {
    UNROLL_ALL
    for (int i = 0; i < BESIDE; i++) {
      TOGETHER(c[i], e[i]);
      g[i][2 * n + 1] = c[i], g[i][2 * n + 2] = s[i];
      weight_step(CONSTANT(slows, SLOWS, n), CONSTANT(step, STEP, n), l[i].delta, e[i], u[i][n],
                  &e[i], &u[i][n + 1]);
      next_power(x[i], y[i], c[i], s[i], &c[i], &s[i]);
    }
  }
  UNROLL_ALL
  for (int i = 0; i < BESIDE; i++) {
    if (kinds & YLM__M0) {
      w[i][0] = l[i].first;
      UNROLL
      for (int k = 1; k <= lmax; k++) w[i][k] = ODD(k, u[i][k - 1]);
    }
    if (kinds & YLM__M1) {
      w[i][ylm__weight_at(lmax, 1, 0)] = vreal_set(0);
      UNROLL
      for (int k = 1; k <= lmax + 1; k++)
        w[i][ylm__weight_at(lmax, 1, k)] = ODD(k, u[i][k - 1] * l[i].invh);
    }
    if (kinds & YLM__M2) {
      w[i][ylm__weight_at(lmax, 2, 0)] = l[i].es * far[i];
      w[i][ylm__weight_at(lmax, 2, 1)] = vreal_set(0);
      UNROLL
      for (int k = 2; k <= lmax + 2; k++)
        w[i][ylm__weight_at(lmax, 2, k)] =
            ODD(k, bent_weight(CONSTANT(rho, RHO, k), u[i][k], u[i][k - 2], far[i]));
    }
  }
}

#undef ODD

/* The lights of a tile; a last one alone is prepared twice. */
YLM_INLINE void prepare_all(const int lmax, const int kinds, int n, const real_lamp *lamps,
                            int bright, const vreal *at, vreal *g, vreal *w, vmask *inside) {
  const int G = ylm__geometry_slots(lmax), W = ylm__weight_slots(lmax);
  constants con;
  find_constants(&con, ylm__degree_of(lmax, kinds));
  for (int j = 0; j < n; j += BESIDE) {
    const real_lamp *lamp[BESIDE];
    real emission[BESIDE], bent[BESIDE];
    vreal *gs[BESIDE], *ws[BESIDE];
    UNROLL_ALL
    for (int i = 0; i < BESIDE; i++) {
      int one = j + i < n ? j + i : j;
      lamp[i] = lamps + one, gs[i] = g + one * G, ws[i] = w + one * W;
      emission[i] = bright & YLM__M0 ? lamp[i]->luminance : (real)1;
      bent[i] = bright == YLM__M2 ? lamp[i]->luminance : (real)1;
    }
    prepare_some(lmax, kinds, &con, lamp, emission, bent, at, gs, ws, inside);
  }
}

static void prepare(int lmax, int kinds, int n, const void *lamps, int bright, const void *xyz,
                    void *geometry, void *weights, void *inside) {
  (void)lmax;
#define X(set)                                                                                     \
  if (kinds == set) prepare_all(FIXED(lmax), set, n, lamps, bright, xyz, geometry, weights, inside);
  YLM__KIND_SETS(X)
#undef X
}

/* The unit's kernel, once `prepare`, `sum` and `sum_rgb` are there. */
#define YLM__MOMENT_KERNEL                                                                         \
  extern const ylm__moment_kernel KERNEL_NAME;                                                     \
  const ylm__moment_kernel KERNEL_NAME = {LANES, GROW, prepare, sum, sum_rgb};

#endif
