/* many.h - lines that the benches of trees have in common. */
#ifndef YLM_BENCH_MANY_H
#define YLM_BENCH_MANY_H

#include <stdlib.h>

#include "ylm_light.h"

/* About a normal deviate: the sum of twelve uniform ones less its mean. */
static inline double bench_normal(ylm_rng *r) {
  double s = 0;
  for (int i = 0; i < 12; i++) s += ylm_rng_double(r);
  return s - 6;
}

/* For qsort of doubles. */
static inline int bench_upwards(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static inline ylm_light_cut *bench_cut(ylm_light_set *lights, double tolerance) {
  ylm_light_cut *cut = NULL;
  if (ylm_light_cut_create(lights, tolerance, 0, &cut, NULL) != YLM_OK) abort();
  return cut;
}

#endif
