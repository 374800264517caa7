/* sums.isa.c - sums, once per instruction set. sums.c has the plain forms. */
#include "ylm_simd.h"

#include "shadow.h"

shadow_sums_fn YLM_KERNEL(ylm_k_shadow_sums);
shadow_add_fn YLM_KERNEL(ylm_k_shadow_add);

void YLM_KERNEL(ylm_k_shadow_sums)(size_t n, float *out, const float *a, const float *b,
                                   const float *c, const float *d) {
  size_t i = 0;
  for (; i + YLM_VF <= n; i += YLM_VF)
    ylm_vf_store(out + i,
                 ylm_vf_load(a + i) * ylm_vf_load(b + i) + ylm_vf_load(c + i) * ylm_vf_load(d + i));
  for (; i < n; i++) out[i] = a[i] * b[i] + c[i] * d[i];
}

void YLM_KERNEL(ylm_k_shadow_add)(size_t n, float *to, const float *from) {
  size_t i = 0;
  for (; i + YLM_VF <= n; i += YLM_VF)
    ylm_vf_store(to + i, ylm_vf_load(to + i) + ylm_vf_load(from + i));
  for (; i < n; i++) to[i] += from[i];
}
