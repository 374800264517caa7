/* distance.h - how virtual lights fall off, lane by lane, for the unit's element type. Private to the folder.

   The weights of degree l are B0 = G, B1 = d G', B2 = d (d G')', as reference.c has them. */
#ifndef YLM_LIGHT_VIRTUAL_DISTANCE_H
#define YLM_LIGHT_VIRTUAL_DISTANCE_H

#include "../moments/lanes.h"
#include "plan.h"

/* Arguments of e^-x beyond this make nothing; bits of a number's mantissa; degree of the polynomial. */
#ifdef YLM_REAL_IS_FLOAT
#define NOTHING 87.0f
#define MANTISSA 23
#define ONE_BITS 0x3f800000
#define MAGIC 12582912.0f /* 1.5 2^23 */
#define LN2_HIGH 0.693145751953125f
#define LN2_LOW 1.4286068203094172e-6f
#define EXP_DEGREE 7
#define SMALL 0.25f
#define SERIES 8
#define NEAREST 1e-6f /* (1e-3)^2 */
#define RISEN 27.0f   /* e^-x beyond this changes neither g nor its derivatives */
#else
#define NOTHING 700.0
#define MANTISSA 52
#define ONE_BITS 0x3ff0000000000000
#define MAGIC 6755399441055744.0 /* 1.5 2^52 */
#define LN2_HIGH 0.693147180369123816490
#define LN2_LOW 1.90821492927058770002e-10
#define EXP_DEGREE 13
#define SMALL 0.1
#define SERIES 13
#define NEAREST 1e-16
#define RISEN 48.0
#endif

/* sg^2 of a light. */
YLM_INLINE real width2_of(const real *lamp) {
  return lamp[YLM__VIRTUAL_RADIUS] * lamp[YLM__VIRTUAL_RADIUS] *
         (real)(YLM__GAUSS_WIDTH * YLM__GAUSS_WIDTH);
}

/* e^-x of x >= 0; 0 from NOTHING on. */
YLM_INLINE vreal decay(vreal x) {
  static const real c[] = {1.0 / 6227020800,
                           1.0 / 479001600,
                           1.0 / 39916800,
                           1.0 / 3628800,
                           1.0 / 362880,
                           1.0 / 40320,
                           1.0 / 5040,
                           1.0 / 720,
                           1.0 / 120,
                           1.0 / 24,
                           1.0 / 6,
                           0.5,
                           1,
                           1}; /* 1/13!, 1/12!, .. */
  const vmask something = x < NOTHING;
  x = keep_lanes(something, x);
  vreal k = x * (real)1.4426950408889634 + MAGIC, n = k - MAGIC;
  vreal r = n * LN2_LOW - (x - n * LN2_HIGH), p = vreal_set(c[13 - EXP_DEGREE]);
#pragma GCC unroll 16
  for (int i = 14 - EXP_DEGREE; i < 14; i++) p = p * r + c[i];
  return keep_lanes(something, (vreal)((vmask)p - ((vmask)k << MANTISSA)));
}

/* Whether a mask has a lane: elsewhere halves are joined until 16 bytes are left. */
YLM_INLINE bool any(vmask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi64_mask((__m512i)m, (__m512i)m) != 0;
#elif defined(__AVX2__)
  return !_mm256_testz_si256((__m256i)m, (__m256i)m);
#else
  typedef int64_t pair __attribute__((vector_size(16)));
  pair part[sizeof m / sizeof(pair)];
  memcpy(part, &m, sizeof m);
  for (size_t i = 1; i < sizeof m / sizeof(pair); i++) part[0] |= part[i];
  return (part[0][0] | part[0][1]) != 0;
#endif
}

/* 1/sqrt(x), x > 0. */
YLM_INLINE vreal inverse_root(vreal x) {
#if defined(YLM_REAL_IS_FLOAT) && defined(__AVX512F__)
  vreal y = (vreal)_mm512_rsqrt14_ps((__m512)x);
  return y + y * (1 - x * y * y) * 0.5f;
#elif defined(YLM_REAL_IS_FLOAT) && defined(__AVX2__)
  vreal y = (vreal)_mm256_rsqrt_ps((__m256)x);
  y = y + y * (1 - x * y * y) * 0.5f;
  return y + y * (1 - x * y * y) * 0.5f;
#else
  return 1 / vreal_sqrt(x);
#endif
}

/* 1/x, x > 0 and normal. */
YLM_INLINE vreal inverse(vreal x) {
#if defined(YLM_REAL_IS_FLOAT) && defined(__AVX512F__)
  vreal y = (vreal)_mm512_rcp14_ps((__m512)x);
  return y + y * (1 - x * y);
#else
  return 1 / x;
#endif
}

/* a0, a1, a2 of reference.c for g = 1 - e^-x, x going to 2^(turns) x where d doubles: t of a Gaussian
   (2), o of a core (4). */
YLM_INLINE void rise(vreal x, const real power, const int order, vreal a[3]) {
  vreal rest = decay(x);
  x = smaller(x, vreal_set(NOTHING));
  vreal g = 1 - rest, steep = power * x * rest;
  a[0] = g;
  if (order > 0) a[1] = steep - 2 * g;
  if (order > 1) a[2] = steep * (power * (1 - x) - 4) + 4 * g;
  vmask small = x < SMALL;
  if (!any(small)) return;
  vreal term = x, s[3] = {x, (power - 2) * x, (power - 2) * (power - 2) * x};
  for (int m = 2; m <= SERIES; m++) {
    const real slope = power * (real)m - 2;
    term *= -x / (real)m;
    s[0] += term, s[1] += slope * term, s[2] += slope * slope * term;
  }
  for (int i = 0; i <= order; i++) a[i] = choose(small, s[i], a[i]);
}

/* How a smooth profile falls off: its core, d a1/a0, and of the degree at hand a0 of the whole, B1/B0 less that,
   and the factor to the next. */
typedef struct falloff {
  vreal a[3], steep, q1, h, q, step, ratio;
  real n;
} falloff;

/* At degree 0. d2 > 0, inv2 its inverse; heat: e^(-sg^2/d^2); outer: a far part's larger core whose far part is not
   in it, or 0. */
YLM_INLINE falloff begin_fall(const int profile, const int order, const real *lamp, real core,
                              real outer, vreal d2, vreal inv2, vreal heat) {
  vreal a[3] = {vreal_set(1), vreal_set(-2), vreal_set(4)}, b[3];
  falloff f = {.steep = vreal_set(-2), .q1 = vreal_set(0), .h = inv2, .q = vreal_set(0), .n = 0};
  f.step = f.ratio = vreal_set(1);
  if (profile != YLM_LIGHT_VIRTUAL_POINT) {
    const real width2 = width2_of(lamp);
    vreal t = d2 * (2 / width2);
    if (profile != YLM_LIGHT_VIRTUAL_FAR && any(t < RISEN)) rise(t, 2, order, a);
    f.q1 = inv2 * (2 * width2); /* q of degree 1: 4/t */
    f.ratio = f.step = heat;
  }
  if (profile == YLM_LIGHT_VIRTUAL_FAR || profile == YLM_LIGHT_VIRTUAL_NEAR) {
    vreal o = d2 * (1 / (core * core));
    bool far = profile == YLM_LIGHT_VIRTUAL_FAR;
    b[0] = vreal_set(1), b[1] = vreal_set(-2), b[2] = vreal_set(4);
    o = smaller(o, vreal_set(NOTHING));
    if (any(o * o < RISEN)) rise(o * o, 4, order, b);
    if (far && outer > 0) {
      vreal all[3];
      o = smaller(d2 * (1 / (outer * outer)), vreal_set(NOTHING));
      rise(o * o, 4, order, all);
      for (int i = 0; i <= order; i++) b[i] -= all[i];
    }
    for (int i = 0; i <= order; i++) a[i] = far ? b[i] : a[i] - b[i];
  }
  if (order > 0 && profile != YLM_LIGHT_VIRTUAL_POINT)
    f.steep = a[1] * inverse(larger(a[0], vreal_set(TINY)));
  for (int i = 0; i < 3; i++) f.a[i] = a[i];
  return f;
}

/* To the next degree. */
YLM_INLINE void go_on(falloff *f) {
  f->n += 1;
  f->q += f->n * f->q1;
  f->h *= f->step;
  f->step *= f->ratio;
}

/* Weights of degrees 0 .. lmax of a smooth profile, [lmax+1][4]: B0, B1, B2, and B1/B0. */
YLM_INLINE void smooth(const int lmax, const int order, falloff f, vreal *B) {
  for (int l = 0; l <= lmax; l++, go_on(&f)) {
    const vreal *a = f.a, q = f.q;
    B[4 * l] = f.h * a[0];
    if (order > 0) B[4 * l + 1] = f.h * (a[1] + q * a[0]), B[4 * l + 3] = f.steep + q;
    if (order > 1) B[4 * l + 2] = f.h * (a[2] + q * (2 * a[1] + (q - 2) * a[0]));
  }
}

/* A cap on its way from degree to degree. */
typedef struct capped {
  vreal alpha, width, u, back, P, before, dP, older;
  real r2;
} capped;

YLM_INLINE void cap_degree(const int l, const int order, capped *c, vreal *B) {
  const vreal dP = c->dP, P = c->P, alpha = c->alpha;
  B[0] = 2 * c->width * (l ? dP * (1 / (real)(l * (l + 1))) : inverse(1 + alpha));
  if (order > 0) B[1] = -2 * P * c->u;
  if (order > 1) B[2] = -2 * c->u * (dP * c->u * c->r2 - P * (1 + c->back));
  vreal next =
      l ? ((2 * (real)l + 1) * alpha * P - (real)l * c->before) * (1 / (real)(l + 1)) : alpha;
  c->dP = c->older + (2 * (real)l + 1) * P;
  c->before = P, c->P = next;
  c->older = dP;
}

/* B0, B1, B2 of a cap: a sphere light's of the same radius; inside of it a hemisphere's. Degrees are `step` apart.
   Of values factors are constants to degree YLM__VIRTUAL_FLOAT; with derivatives that is slower. */
YLM_INLINE void cap(const int lmax, const int order, const int step, const real *lamp, vreal d2,
                    vreal inv2, vreal *B) {
  capped c = {.r2 = lamp[YLM__VIRTUAL_RADIUS] * lamp[YLM__VIRTUAL_RADIUS], .P = vreal_set(1)};
  vreal h2 = d2 - c.r2;
  vmask out = h2 > 0;
  const vreal slope = choose(out, h2, d2) * inv2;
#if defined(YLM_REAL_IS_FLOAT) && defined(__AVX512F__)
  const vreal over = inverse_root(slope), root = slope * over;
#else
  const vreal root = vreal_sqrt(slope), over = 1 / root;
#endif
  c.alpha = keep_lanes(out, root), c.u = keep_lanes(out, over * inv2), c.back = over * over;
  c.width = choose(out, inv2, vreal_set(1 / c.r2));
  c.before = c.dP = c.older = vreal_set(0);
  int l = 0;
  if (order == 0) {
#pragma GCC unroll 16
    for (; l <= YLM__VIRTUAL_FLOAT; l++, B += step) {
      cap_degree(l, order, &c, B);
      if (l == lmax) return;
    }
  }
  for (; l <= lmax; l++, B += step) cap_degree(l, order, &c, B);
}

#endif
