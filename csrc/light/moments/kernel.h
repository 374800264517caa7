/*
** kernel.h - the moment kernels of one lmax for both element types.
**
** Included by gen/moments_L.isa.c after LMAX and its plans:
**   PLAN_s, PLAN_RGB_s   for each set of kinds s: passes over a tile, in the words of body.h
** and by any.isa.c, which leaves LMAX at its limit and has no plans.
*/
#include "ylm_simd.h"

#include "gen/recurrences.h"
#include "moments.h"

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
#define FINE(lmax) (sizeof(REAL) == sizeof(float) ? YLM__FINE(lmax) : 0)

/* Constants of the recurrences, of the element type; z is times GROW. */
#define SLOWS(n) ((REAL)YLM__SLOWS(n))
#define STEP(n) ((REAL)YLM__STEP(n))
#define RHO(k) ((REAL)YLM__RHO(k))
#define BETA(k, m) ((REAL)(GROW * GROW * YLM__BETA(k, m)))

/* Constants by differences from the pole, with o = 1 - z, from e_m = 0:
   e_(k+1) = SLOW e_k - o q_k, q_(k+1) = KEEP q_k + e_(k+1). */
#define KEEP(k, m) ((REAL)(GROW * ((double)(k) + (m) + 1) / (2.0 * (k) + 1)))
#define SLOW(k, m) ((REAL)(GROW * ((double)(k) - (m)) / (2.0 * (k) + 1)))

/* h^2 = d^2 - r^2 with one rounding of r^2 or, without fma, with what that loses in float. */
#if defined(__FMA__) || defined(__aarch64__)
#define SQUARES(d2, r, radius) ((d2) - (r) * (r))
#else
#define SQUARES(d2, r, radius) (((d2)-SQUARE(radius)) - LOST(radius))
#define SQUARE(r) ((REAL)((double)(r) * (r)))
#define LOST(r) ((REAL)((double)(r) * (r)-SQUARE(r)))
#endif

/* ylm__geometry_slots and ylm__weight_slots of LMAX as constants. */
#define GEOMETRY_SLOTS (2 + 2 * (LMAX + 2))
#define WEIGHT_SLOTS (3 * LMAX + 6)

/* X(0) .. X(n-1). */
#define EACH_1(X) X(0)
#define EACH_2(X) EACH_1(X) X(1)
#define EACH_3(X) EACH_2(X) X(2)
#define EACH_4(X) EACH_3(X) X(3)
#define EACH_5(X) EACH_4(X) X(4)
#define EACH_6(X) EACH_5(X) X(5)
#define EACH_7(X) EACH_6(X) X(6)
#define EACH_8(X) EACH_7(X) X(7)
#define EACH_9(X) EACH_8(X) X(8)
#define EACH_10(X) EACH_9(X) X(9)
#define EACH_11(X) EACH_10(X) X(10)
#define EACH_12(X) EACH_11(X) X(11)
#define EACH_13(X) EACH_12(X) X(12)
#define EACH_14(X) EACH_13(X) X(13)
#define EACH_15(X) EACH_14(X) X(14)
#define EACH_16(X) EACH_15(X) X(15)
#define EACH_17(X) EACH_16(X) X(16)
#define EACH_18(X) EACH_17(X) X(17)
#define EACH_19(X) EACH_18(X) X(18)
#define EACH_20(X) EACH_19(X) X(19)
#define EACH_21(X) EACH_20(X) X(20)
#define EACH_22(X) EACH_21(X) X(21)
#define EACH_23(X) EACH_22(X) X(22)
#define EACH_24(X) EACH_23(X) X(23)

/* -- float --------------------------------------------------------------------------- */

#define REAL float
#define V ylm_vf
#define VI ylm_vi
#define LANES YLM_VF
#define LAMP ylm__lamp_f
#define NAME(x) YLM_PASTE(x, f)

#define SQRT ylm_vf_sqrt

/* 1/sqrt(x): an estimate and Newton steps. */
YLM_INLINE V NAME(rsqrt)(V x) {
#if defined(__AVX512F__)
  V y = (V)_mm512_rsqrt14_ps((__m512)x);
  return y + y * (1 - x * y * y) * 0.5f;
#elif defined(__AVX2__)
  V y = (V)_mm256_rsqrt_ps((__m256)x);
  y = y + y * (1 - x * y * y) * 0.5f;
  return y + y * (1 - x * y * y) * 0.5f;
#else
  return 1 / SQRT(x);
#endif
}

YLM_INLINE V NAME(reciprocal)(V x) {
#if defined(__AVX512F__)
  V y = (V)_mm512_rcp14_ps((__m512)x);
  return y + y * (1 - x * y);
#else
  return 1 / x;
#endif
}

#include "body.h"

#undef REAL
#undef V
#undef VI
#undef LANES
#undef LAMP
#undef NAME
#undef SQRT

/* -- double -------------------------------------------------------------------------- */

#define REAL double
#define V ylm_vd
#define VI ylm_vl
#define LANES YLM_VD
#define LAMP ylm__lamp_d
#define NAME(x) YLM_PASTE(x, d)

#define SQRT ylm_vd_sqrt

YLM_INLINE V NAME(rsqrt)(V x) {
#if defined(__AVX512F__)
  V y = (V)_mm512_rsqrt14_pd((__m512d)x);
  y = y + y * (1 - x * y * y) * 0.5;
  return y + y * (1 - x * y * y) * 0.5;
#else
  return 1 / SQRT(x);
#endif
}

YLM_INLINE V NAME(reciprocal)(V x) {
#if defined(__AVX512F__)
  V y = (V)_mm512_rcp14_pd((__m512d)x);
  y = y + y * (1 - x * y);
  return y + y * (1 - x * y);
#else
  return 1 / x;
#endif
}

#include "body.h"

#undef REAL
#undef V
#undef VI
#undef LANES
#undef LAMP
#undef NAME
#undef SQRT

const ylm__moment_kernel *KERNEL_NAME(int dtype);

/* The kernel for a dtype. */
const ylm__moment_kernel *KERNEL_NAME(int dtype) {
  static const ylm__moment_kernel kernels[2] = {
      {YLM_VF, GROW, YLM_PASTE(prepare, f), YLM_PASTE(sum, f), YLM_PASTE(sum_rgb, f)},
      {YLM_VD, GROW, YLM_PASTE(prepare, d), YLM_PASTE(sum, d), YLM_PASTE(sum_rgb, d)}};
  return &kernels[dtype == YLM_DOUBLE];
}
