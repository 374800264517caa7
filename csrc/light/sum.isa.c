/* sum.isa.c - the loop over points and lights around the moment kernels, for both element types. */
#include "ylm_simd.h"

#include "tree.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "tree_walk.h"

/* -- float --------------------------------------------------------------------------- */

#define REAL float
#define V ylm_vf
#define VI ylm_vi
#define LANES YLM_VF
#define LAMP ylm__lamp_f
#define NAME(x) YLM_PASTE(x, f)
#define COEF coef_f
#define TINY 1e-30f
#define RANGE YLM_KERNEL(ylm__sum_range_f)
#define TREE_RANGE YLM_KERNEL(ylm__tree_range_f)
#define SMALL 1e-4f
#define PROXIES proxies_f
#define LEAVES leaf_f

YLM_INLINE V NAME(root)(V x) {
#if defined(__AVX512F__)
  return (V)_mm512_sqrt_ps((__m512)x);
#elif defined(__AVX2__)
  return (V)_mm256_sqrt_ps((__m256)x);
#elif defined(__x86_64__)
  return (V)_mm_sqrt_ps((__m128)x);
#else
  for (int i = 0; i < LANES; i++) x[i] = sqrtf(x[i]);
  return x;
#endif
}

/* cos(2/3 acos(t)) for t = (1+u)/2 in 0 .. 1, to 4e-9: Chebyshev interpolation. */
YLM_INLINE V NAME(third)(V u) {
  static const float c[] = {0.766044443f,     0.247409067f,    -0.0155091689f,   0.00246634011f,
                            -0.000504279435f, 0.000116495476f, -2.84967340e-05f, 7.3851101e-06f,
                            -2.49732176e-06f, 7.1227402e-07f};
  V s = (V){0} + c[9];
  for (int i = 8; i >= 0; i--) s = s * u + c[i];
  return s;
}

#include "sum_body.h"
#include "tree_body.h"

#undef REAL
#undef V
#undef VI
#undef LANES
#undef LAMP
#undef NAME
#undef COEF
#undef TINY
#undef RANGE
#undef TREE_RANGE
#undef SMALL
#undef PROXIES
#undef LEAVES
#undef LIST
#undef BROAD

/* -- double -------------------------------------------------------------------------- */

#define REAL double
#define V ylm_vd
#define VI ylm_vl
#define LANES YLM_VD
#define LAMP ylm__lamp_d
#define NAME(x) YLM_PASTE(x, d)
#define COEF coef
#define TINY 1e-280
#define RANGE YLM_KERNEL(ylm__sum_range_d)
#define TREE_RANGE YLM_KERNEL(ylm__tree_range_d)
#define SMALL 1e-8
#define PROXIES proxies_d
#define LEAVES leaf_d

YLM_INLINE V NAME(root)(V x) {
#if defined(__AVX512F__)
  return (V)_mm512_sqrt_pd((__m512d)x);
#elif defined(__AVX2__)
  return (V)_mm256_sqrt_pd((__m256d)x);
#elif defined(__x86_64__)
  return (V)_mm_sqrt_pd((__m128d)x);
#else
  for (int i = 0; i < LANES; i++) x[i] = sqrt(x[i]);
  return x;
#endif
}

/* The same to 1e-15. */
YLM_INLINE V NAME(third)(V u) {
  static const double c[] = {
      0.7660444431189779,      0.24740906632284712,     -0.015509188436479752,
      0.002466352815327989,    -0.000504124691375387,   0.00011642544964303237,
      -2.891993276519552e-05,  7.5411011213028505e-06,  -2.035895290512516e-06,
      5.640626796428738e-07,   -1.5944028400288515e-07, 4.607182479821059e-08,
      -1.3595880766041157e-08, 3.6162572749631748e-09,  -8.22254314453013e-10,
      6.375020298321488e-10,   -4.1134878791124913e-10, -1.1124320309363611e-10,
      1.3821345135056616e-10,  3.4040482432828866e-11,  -3.151308192173019e-11};
  V s = (V){0} + c[20];
  for (int i = 19; i >= 0; i--) s = s * u + c[i];
  return s;
}

#include "sum_body.h"
#include "tree_body.h"
