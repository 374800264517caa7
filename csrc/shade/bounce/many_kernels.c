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

static YLM_KERNEL_CHOICE(ylm_shade_weights_fn, weights_now, ylm_k_shade_weights, weights) static YLM_KERNEL_CHOICE(
    ylm_shade_collect_fn, collect_now, ylm_k_shade_collect,
    collect) static YLM_KERNEL_CHOICE(ylm_shade_collect_each_fn, collect_each_now,
                                      ylm_k_shade_collect_each,
                                      collect_each) static YLM_KERNEL_CHOICE(ylm_shade_send_fn,
                                                                             send_now,
                                                                             ylm_k_shade_send,
                                                                             ylm__gather_send) static YLM_KERNEL_CHOICE(ylm_shade_gloss_fn,
                                                                                                                        gloss_now,
                                                                                                                        ylm_k_shade_gloss,
                                                                                                                        gloss) static YLM_KERNEL_CHOICE(ylm_shade_spheres_fn,
                                                                                                                                                        spheres_now,
                                                                                                                                                        ylm_k_shade_spheres,
                                                                                                                                                        ylm__gather_spheres)

    gather_kernels ylm__gather_kernels(const ylm_shade_gather_options *o) {
  gather_kernels k = {weights_now(), collect_now(), collect_each_now(),
                      send_now(),    gloss_now(),   spheres_now()};
  if (o->method == YLM_SHADE_HVL && o->horizon == YLM_SHADE_HORIZON_PAPER) k.weights = weights;
  return k;
}
