/* sums.c - sums of two products: the plain form, and the choice of kernels. */
#include "shadow.h"
#include "ylm_sets.h"

static void sums(size_t n, float *out, const float *a, const float *b, const float *c,
                 const float *d) {
  for (size_t i = 0; i < n; i++) out[i] = a[i] * b[i] + c[i] * d[i];
}

YLM_SETS_DECLARE(shadow_sums_fn, ylm_k_shadow_sums)

shadow_sums_fn *ylm__shadow_sums(void) {
  switch (ylm_isa_current()) {
    YLM_SETS_RETURN(ylm_k_shadow_sums)
  default: return sums;
  }
}
