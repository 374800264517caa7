/* many_kernels.c - the kernels of the instruction set in use, and the plain form, which judges them. */
#include "many_gloss.h"
#include "ylm_sets.h"

static void weights(const gather_lights *l, const gather_ask *a, size_t first, size_t n,
                    const float x[3], const float N[3], float *w) {
  for (size_t k = 0; k < n; k++) {
    double one[3] = {0, 0, 0};
    if (first + k < l->n) {
      if (a->o->method == YLM_SHADE_VSGL)
        ylm__gather_gaussian(l, NULL, first + k, x, N, one);
      else
        one[0] = ylm__gather_weight(l, a, first + k, x, N);
    }
    w[k] = (float)one[0];
  }
}

static void collect(size_t n, const float *w, const float *const I[3], double sum[3]) {
  for (int c = 0; c < 3; c++)
    for (size_t k = 0; k < n; k++) sum[c] += (double)w[k] * (double)I[c][k];
}

static void collect_each(size_t n, const float (*w)[GATHER_CHUNK], const float *const I[3],
                         double sum[3]) {
  for (int c = 0; c < 3; c++)
    for (size_t k = 0; k < n; k++) sum[c] += (double)w[c][k] * (double)I[c][k];
}

static void gloss(const gather_lights *l, const gather_ask *a, const gather_receiver *r,
                  size_t first, size_t n, const float x[3], float (*w)[GATHER_CHUNK]) {
  for (size_t k = 0; k < n; k++) {
    double one[3] = {0, 0, 0};
    if (first + k < l->n) {
      if (a->o->method == YLM_SHADE_VSGL)
        ylm__gather_gaussian(l, r, first + k, x, r->axis[2], one);
      else
        ylm__gather_gloss_weight(l, a, r, first + k, x, one);
    }
    for (int f = 0; f < (r->zonal ? 3 : r->functions); f++) w[f][k] = (float)one[f];
  }
}

#define X(isa)                                                                                     \
  ylm_shade_weights_fn ylm_k_shade_weights_##isa;                                                  \
  ylm_shade_collect_fn ylm_k_shade_collect_##isa;                                                  \
  ylm_shade_collect_each_fn ylm_k_shade_collect_each_##isa;                                        \
  ylm_shade_send_fn ylm_k_shade_send_##isa;                                                        \
  ylm_shade_gloss_fn ylm_k_shade_gloss_##isa;                                                      \
  ylm_shade_spheres_fn ylm_k_shade_spheres_##isa;
YLM_SETS(X)
#undef X

gather_kernels ylm__gather_kernels(const ylm_shade_gather_options *o) {
  gather_kernels k = {weights, collect, collect_each, ylm__gather_send, gloss, ylm__gather_spheres};
  switch (ylm_isa_current()) {
#define X(isa)                                                                                     \
  case YLM_ISA_##isa:                                                                              \
    k = (gather_kernels){ylm_k_shade_weights_##isa,      ylm_k_shade_collect_##isa,                \
                         ylm_k_shade_collect_each_##isa, ylm_k_shade_send_##isa,                   \
                         ylm_k_shade_gloss_##isa,        ylm_k_shade_spheres_##isa};               \
    break;
    YLM_SETS(X)
#undef X
  default: break;
  }
  if (o->method == YLM_SHADE_HVL && o->horizon == YLM_SHADE_HORIZON_PAPER) k.weights = weights;
  return k;
}
