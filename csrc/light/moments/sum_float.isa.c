/* sum.isa.c - the loop over points and lights around the moment kernels, for both element types. */
#include "ylm_simd.h"

#include "../tree/tree.h"

#include "../tree/walk.h"

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
#define SQRT ylm_vf_sqrt

#include "sum_body.h"

#include "../tree/body.h"

ylm_light_lambda2_fn YLM_KERNEL(ylm__lambda2);

float YLM_KERNEL(ylm__lambda2)(size_t count, const float *hessian) {
  ylm_vf sum = {0};
  float s = 0;
  for (size_t i = 0; i < count; i += YLM_VF) {
    size_t n = count - i < YLM_VF ? count - i : YLM_VF;
    ylm_vf h[6] = {{0}};
    for (size_t a = 0; a < 6; a++) {
      if (n == YLM_VF)
        h[a] = ylm_vf_load(hessian + a * count + i);
      else
        memcpy(&h[a], hessian + a * count + i, n * sizeof s);
    }
    ylm_vf e = largest_eigenvalue_f(h);
    sum += e * e;
  }
  for (int i = 0; i < YLM_VF; i++) s += sum[i];
  return s;
}

#undef REAL
#undef V
#undef VI
#undef LANES
#undef LAMP
#undef NAME
#undef SQRT
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
#undef ABREAST
#undef ALONG
#undef FEWEST
#undef FAR_SHARE
#undef STRONG
#undef LARGEST
#undef COST
#undef INSTEAD

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
#define SQRT ylm_vd_sqrt

#include "sum_body.h"

#include "../tree/body.h"
