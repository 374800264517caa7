/* many_kernels.c - the kernels of the instruction set in use, and the plain form, which judges them. */
#include "many_gloss.h"
#include "ylm_sets.h"

static void weights(const ylm_many_lights *l, const ylm_many_ask *a, size_t first, size_t n,
                    const float x[3], const float N[3], float *w) {
  for (size_t k = 0; k < n; k++)
    w[k] = first + k < l->n ? (float)ylm__many_weight(l, a, first + k, x, N) : 0;
}

static void collect(size_t n, const float *w, const float *const I[3], double sum[3]) {
  for (int c = 0; c < 3; c++)
    for (size_t k = 0; k < n; k++) sum[c] += (double)w[k] * (double)I[c][k];
}

static void collect_each(size_t n, const float (*w)[YLM_MANY_CHUNK], const float *const I[3],
                         double sum[3]) {
  for (int c = 0; c < 3; c++)
    for (size_t k = 0; k < n; k++) sum[c] += (double)w[c][k] * (double)I[c][k];
}

static void gloss(const ylm_many_lights *l, const ylm_many_ask *a, const ylm_many_receiver *r,
                  size_t first, size_t n, const float x[3], float (*w)[YLM_MANY_CHUNK]) {
  for (size_t k = 0; k < n; k++) {
    double one[3] = {0, 0, 0};
    if (first + k < l->n) ylm__many_gloss_weight(l, a, r, first + k, x, one);
    for (int f = 0; f < (r->zonal ? 3 : r->functions); f++) w[f][k] = (float)one[f];
  }
}

#define X(isa)                                                                                     \
  ylm_many_weights_fn ylm_k_many_weights_##isa;                                                    \
  ylm_many_collect_fn ylm_k_many_collect_##isa;                                                    \
  ylm_many_collect_each_fn ylm_k_many_collect_each_##isa;                                          \
  ylm_many_send_fn ylm_k_many_send_##isa;                                                          \
  ylm_many_gloss_fn ylm_k_many_gloss_##isa;
YLM_SETS(X)
#undef X

ylm_many_kernels ylm__many_kernels(const ylm_shade_gather_options *o) {
  ylm_many_kernels k = {weights, collect, collect_each, ylm__many_send, gloss, NULL, NULL};
  switch (ylm_isa_current()) {
#define X(isa)                                                                                     \
  case YLM_ISA_##isa:                                                                              \
    k = (ylm_many_kernels){ylm_k_many_weights_##isa,                                               \
                           ylm_k_many_collect_##isa,                                               \
                           ylm_k_many_collect_each_##isa,                                          \
                           ylm_k_many_send_##isa,                                                  \
                           ylm_k_many_gloss_##isa,                                                 \
                           NULL,                                                                   \
                           NULL};                                                                  \
    break;
    YLM_SETS(X)
#undef X
  default: break;
  }
  if (o->method == YLM_SHADE_HVL && o->horizon == YLM_SHADE_HORIZON_PAPER) k.weights = weights;
  return k;
}
