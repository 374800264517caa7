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
#define FINE 0
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
#undef FINE
#undef RANGE
#undef TREE_RANGE
#undef SMALL
#undef PROXIES
#undef LEAVES
#undef LIST
#undef VECTORS
#undef CROWD

/* -- double -------------------------------------------------------------------------- */

#define REAL double
#define V ylm_vd
#define VI ylm_vl
#define LANES YLM_VD
#define LAMP ylm__lamp_d
#define NAME(x) YLM_PASTE(x, d)
#define COEF coef
#define TINY 1e-280
#define FINE 1
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

#include "sum_body.h"
#include "tree_body.h"
