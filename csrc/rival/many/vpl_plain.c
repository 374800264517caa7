/* vpl_plain.c - one virtual light as a point, in plain code and double. */
#include <math.h>

#include "many.h"

double ylm__many_bound(const ylm_many_ask *a, double g, double d2) {
  const ylm_shade_gather_options *o = a->o;
  switch (o->clamp) {
  case YLM_SHADE_CLAMP_DISTANCE: return d2 * o->limit < 1 ? g * d2 * o->limit : g;
  case YLM_SHADE_CLAMP_GEOMETRY: return fmin(g, o->limit);
  case YLM_SHADE_CLAMP_WHOLE: return a->reflectance * g > o->limit ? o->limit / a->reflectance : g;
  default: return g;
  }
}

static double weight(const ylm_many_lights *l, const ylm_many_ask *a, size_t i, const float x[3],
                     const float N[3]) {
  double d2 = 0, up = 0, along = 0;
  for (int k = 0; k < 3; k++) {
    double v = (double)l->at[k][i] - (double)x[k];
    d2 += v * v;
    up += v * (double)N[k];
    along -= v * (double)l->normal[k][i];
  }
  double d = sqrt(d2), c = d > 0 ? up / d : 0;
  double cosine = fmax(0, (double)l->shift[i] + (d > 0 ? along / d : 0));
  return d2 > 0 ? ylm__many_bound(a, fmax(0, c) * cosine / d2, d2) : 0;
}

void ylm__many_points(const ylm_many_lights *l, const ylm_many_ask *a, size_t first, size_t n,
                      const float x[3], const float N[3], float *w) {
  for (size_t k = 0; k < n; k++) w[k] = first + k < l->n ? (float)weight(l, a, first + k, x, N) : 0;
}
