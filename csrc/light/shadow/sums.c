/* sums.c - sums: the plain forms, and the choice of kernels. */
#include "shadow.h"
#include "ylm_sets.h"

static void sums(size_t n, float *out, const float *a, const float *b, const float *c,
                 const float *d) {
  for (size_t i = 0; i < n; i++) out[i] = a[i] * b[i] + c[i] * d[i];
}

static void add(size_t n, float *to, const float *from) {
  for (size_t i = 0; i < n; i++) to[i] += from[i];
}

YLM_KERNEL_CHOICE(shadow_sums_fn, ylm__shadow_sums, ylm_k_shadow_sums, sums);
YLM_KERNEL_CHOICE(shadow_add_fn, ylm__shadow_add, ylm_k_shadow_add, add);
