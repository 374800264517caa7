/* sums.isa.c - sums of two products, once per instruction set. sums.c has the plain form. */
#include "ylm_simd.h"

#include "shadow.h"

shadow_sums_fn YLM_KERNEL(ylm_k_shadow_sums);

void YLM_KERNEL(ylm_k_shadow_sums)(size_t n, float *out, const float *a, const float *b,
                                   const float *c, const float *d) {
  size_t i = 0;
  for (; i + YLM_VF <= n; i += YLM_VF)
    ylm_vf_store(out + i,
                 ylm_vf_load(a + i) * ylm_vf_load(b + i) + ylm_vf_load(c + i) * ylm_vf_load(d + i));
  for (; i < n; i++) out[i] = a[i] * b[i] + c[i] * d[i];
}
