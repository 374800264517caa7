/* lambda2.isa.c - squares of the largest eigenvalues of Hessians in float, added up. */
#define YLM_REAL_IS_FLOAT
#include "lanes.h"
#include "plan.h"

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
    ylm_vf e = largest_eigenvalue(h);
    sum += e * e;
  }
  for (int i = 0; i < YLM_VF; i++) s += sum[i];
  return s;
}
