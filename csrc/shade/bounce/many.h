/* many.h - what the files that gather virtual lights share. Private to csrc/shade. */
#ifndef YLM_SHADE_MANY_H
#define YLM_SHADE_MANY_H

#include "../view.h"
#include "ylm_shade_rival.h"

/* The kernels of HVL, of the instruction set in use. many_kernels.c */
ylm_many_kernels ylm__many_kernels(const ylm_shade_gather_options *o);
/* The weight of one light: the plain form, which judges the others. many_plain.c */
double ylm__many_weight(const ylm_many_lights *l, const ylm_many_ask *a, size_t i, const float x[3],
                        const float N[3]);
/* The plain form of ylm_many_send_fn. many_plain.c */
ylm_many_send_fn ylm__many_send;

/* Pairs of a shading point and a light at the same place. many_singular.c, YLM_ENOMEM */
ylm_status ylm__many_singular(const ylm_shade_view *v, const ylm_many_lights *l, uint64_t *pairs);

/* The group of a pixel's points, of interleaved lights. */
static inline size_t ylm__many_group(const ylm_shade_view *v, int tile, size_t pixel) {
  size_t side = (size_t)tile, width = (size_t)v->image[0];
  return pixel / width % side * side + pixel % width % side;
}

/* One walk along a point's lights: each step of alpha along the sum of their bounds keeps one. */
typedef struct many_walk {
  double alpha, upto;
} many_walk;
/* The factor of a light of this bound: 0 leaves it out; the mean is 1. */
static inline float ylm__many_keep(many_walk *w, double bound) {
  if (!(bound < w->alpha)) return 1;
  w->upto += bound;
  if (w->upto < w->alpha) return 0;
  w->upto -= w->alpha;
  return (float)(w->alpha / bound);
}

#endif
