/* gather.h - what the files that gather virtual lights share. Private to csrc/shade. */
#ifndef YLM_SHADE_GATHER_H
#define YLM_SHADE_GATHER_H

#include "view.h"
#include "ylm_light_virtual.h"

/* Lights that are looked at in one go; arrays of them are padded to a multiple of it. */
#define GATHER_CHUNK 512

/* Lights as kernels want them: arrays of one number each. Padding lies at 0 and sends nothing. */
typedef struct gather_lights {
  size_t n, padded;
  ylm_light_virtual_form form;
  float *at[3], *normal[3], *shift; /* [padded]; without a normal the shift is 1 */
  float *radius;                    /* [padded] */
  float *intensity[3];              /* [padded] degree 0; NULL: form.emission */
  float *memory;
} gather_lights;

/* The question to a light. */
typedef struct gather_ask {
  const ylm_shade_gather_options *o;
  float zonal[YLM_SHADE_GATHER_LMAX + 1]; /* a_l (2l+1)/(4 pi) window_l */
  float core;                             /* 1/R^4 of far and near */
  float reflectance;                      /* of the receiver: luminance of its albedo over pi */
} gather_ask;

/* w[k]: irradiance at x, normal N, by light first + k for an intensity of 1, k < GATHER_CHUNK. */
typedef void ylm_shade_weights_fn(const gather_lights *l, const gather_ask *a, size_t first,
                                  const float x[3], const float N[3], float *w);
/* sum[c] += w[k] I[c][k], k < GATHER_CHUNK. */
typedef void ylm_shade_collect_fn(const float *w, const float *const I[3], double sum[3]);

typedef struct gather_kernels {
  ylm_shade_weights_fn *weights;
  ylm_shade_collect_fn *collect;
} gather_kernels;

/* The kernels of the instruction set in use. gather_kernels.c */
gather_kernels ylm__gather_kernels(const ylm_shade_gather_options *o);
/* The weight of one light: the plain form, which judges the others. gather_plain.c */
double ylm__gather_weight(const gather_lights *l, const gather_ask *a, size_t i, const float x[3],
                          const float N[3]);

/* The factor g = c_x c_y/d^2 as a bound leaves it. */
static inline double ylm__gather_bound(const gather_ask *a, double g, double d2) {
  const ylm_shade_gather_options *o = a->o;
  switch (o->clamp) {
  case YLM_SHADE_CLAMP_DISTANCE: return d2 * o->limit < 1 ? g * d2 * o->limit : g;
  case YLM_SHADE_CLAMP_GEOMETRY: return fmin(g, o->limit);
  case YLM_SHADE_CLAMP_WHOLE: return a->reflectance * g > o->limit ? o->limit / a->reflectance : g;
  default: return g;
  }
}

/* The weight of a light as a sphere. gather_vsl.c */
double ylm__gather_sphere(const gather_lights *l, const gather_ask *a, size_t i, const float x[3],
                          const float N[3], ylm_rng *rng);

/* Adds to irradiances [points][3] what the bound took. gather_vpl.c */
ylm_status ylm__gather_compensate(const ylm_shade_view *v, const gather_ask *a, float *out,
                                  uint64_t *rays, ylm_error *e);

#endif
