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

static YLM_KERNEL_CHOICE(ylm_many_weights_fn, weights_now, ylm_k_many_weights, weights);
static YLM_KERNEL_CHOICE(ylm_many_collect_fn, collect_now, ylm_k_many_collect, collect);
static YLM_KERNEL_CHOICE(ylm_many_collect_each_fn, collect_each_now, ylm_k_many_collect_each,
                         collect_each);
static YLM_KERNEL_CHOICE(ylm_many_send_fn, send_now, ylm_k_many_send, ylm__many_send);
static YLM_KERNEL_CHOICE(ylm_many_gloss_fn, gloss_now, ylm_k_many_gloss, gloss);

ylm_many_kernels ylm__many_kernels(const ylm_shade_gather_options *o) {
  ylm_many_kernels k = {weights_now(), collect_now(), collect_each_now(), send_now(), gloss_now(),
                        NULL,          NULL};
  if (o->method == YLM_SHADE_HVL && o->horizon == YLM_SHADE_HORIZON_PAPER) k.weights = weights;
  return k;
}
