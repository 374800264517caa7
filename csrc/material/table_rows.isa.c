/* table_rows.isa.c - rows of a material's table, blended, once per instruction set. */
#include "ylm_simd.h"

#include "table.h"

material_blend_fn YLM_KERNEL(ylm_k_material_blend);

void YLM_KERNEL(ylm_k_material_blend)(size_t n, int rows, const float *const *a, const float *w,
                                      float *out) {
  if (n < YLM_VF) {
    for (size_t k = 0; k < n; k++) {
      float sum = w[0] * a[0][k];
      for (int q = 1; q < rows; q++) sum += w[q] * a[q][k];
      out[k] = sum;
    }
    return;
  }
  for (size_t k = 0;; k += YLM_VF) {
    if (k > n - YLM_VF) k = n - YLM_VF; /* the last vector overlaps the one before */
    ylm_vf sum = ylm_vf_load(a[0] + k) * ylm_vf_set(w[0]);
    for (int q = 1; q < rows; q++) sum += ylm_vf_load(a[q] + k) * ylm_vf_set(w[q]);
    ylm_vf_store(out + k, sum);
    if (k == n - YLM_VF) return;
  }
}
