/* many.h - what the files that gather virtual lights share. Private to csrc/shade. */
#ifndef YLM_SHADE_MANY_H
#define YLM_SHADE_MANY_H

#include "../view.h"
#include "ylm_light_virtual.h"
#include "ylm_shade_bounce.h"

/* Lights that are looked at in one go; arrays of them are padded to a multiple of it. */
#define GATHER_CHUNK 512

/* Lights as kernels want them: arrays of one number each. Padding lies at 0 and sends nothing. */
typedef struct gather_lights {
  size_t n, padded; /* with groups n is `padded` */
  ylm_light_virtual_form form;
  size_t groups; /* that points ask one of: of a tile's pixels; else 1 */
  size_t *begin; /* [groups + 1] multiples of GATHER_LOBES; NULL: one */
  float *bright; /* [padded] bounds of the luminance of intensities; NULL: not asked for */
  float *at[3], *normal[3], *shift; /* [padded]; without a normal the shift is 1 */
  float *radius;                    /* [padded] */
  float *intensity[3];              /* [padded] degree 0; else lobes */
  float *memory;
  /* of a degree: emission of GATHER_LOBES lights beside each other, in the order of gather_series:
     [padded/GATHER_LOBES][entries][3][2: m >= 0, m < 0][GATHER_LOBES], and the highest degree in it that counts */
  float *lobe;
  uint8_t *top;
  const struct gather_series *series; /* of their degree */
} gather_lights;

/* Lights whose emission stands together. */
#define GATHER_LOBES 16

/* The question to a light. */
typedef struct gather_ask {
  const ylm_shade_gather_options *o;
  float zonal[YLM_SHADE_GATHER_LMAX + 1]; /* a_l (2l+1)/(4 pi) window_l */
  float up[YLM_SHADE_GATHER_LMAX + 1],
      down[YLM_SHADE_GATHER_LMAX + 1]; /* P_(l+1) = up_l c P_l - down_l P_(l-1) */
  float core;                          /* 1/R^4 of far and near */
  double alpha;                        /* stochastic: light above which a light is always kept */
  float reflectance;                   /* of the receiver: luminance of its albedo over pi */
} gather_ask;

/* w[k]: irradiance at x, normal N, by light first + k for an intensity of 1, k < n. In all of these n <= GATHER_CHUNK is a
   multiple of GATHER_LOBES. */
typedef void ylm_shade_weights_fn(const gather_lights *l, const gather_ask *a, size_t first,
                                  size_t n, const float x[3], const float N[3], float *w);
/* sum[c] += w[k] I[c][k], k < n. */
typedef void ylm_shade_collect_fn(size_t n, const float *w, const float *const I[3], double sum[3]);

/* As collect, with weights for each channel: w [3][GATHER_CHUNK]. */
typedef void ylm_shade_collect_each_fn(size_t n, const float (*w)[GATHER_CHUNK],
                                       const float *const I[3], double sum[3]);
/* I[c][k]: intensity of light first + k, whose emission has a degree, towards x; k < n. `soft`: profiles
   whose direction is. */
typedef void ylm_shade_send_fn(const gather_lights *l, bool soft, size_t first, size_t n,
                               const float x[3], float (*I)[GATHER_CHUNK]);
struct gather_receiver;
/* As weights, of a receiver that glosses: w [functions][GATHER_CHUNK], radiance by functions of its slices; of zonal
   lobes [3], of VSGL without the base. */
typedef void ylm_shade_gloss_fn(const gather_lights *l, const gather_ask *a,
                                const struct gather_receiver *r, size_t first, size_t n,
                                const float x[3], float (*w)[GATHER_CHUNK]);

/* -- spheres: many_vsl.c -- */

/* Ways to choose directions. */
enum { GATHER_CONE, GATHER_RECEIVER, GATHER_LIGHT };
/* Of smaller cones, in parts of the hemisphere, the other ways find next to nothing. */
#define GATHER_SMALL 0.03f
/* Light i begins with the numbers (seed + i step)/2^32 (Roberts 2018). */
#define GATHER_STEP_U 3242174889u
#define GATHER_STEP_V 2447445414u

/* As weights, of lights as spheres; seed: of the point; keep [n]: factors, 0 leaves a light out; NULL: 1. */
typedef void ylm_shade_spheres_fn(const gather_lights *l, const gather_ask *a, size_t first,
                                  size_t n, const float x[3], const float N[3],
                                  const uint32_t seed[2], const float *keep, float *w);
typedef struct gather_kernels {
  ylm_shade_weights_fn *weights;
  ylm_shade_collect_fn *collect;
  ylm_shade_collect_each_fn *collect_each;
  ylm_shade_send_fn *send;
  ylm_shade_gloss_fn *gloss;
  ylm_shade_spheres_fn *spheres;
} gather_kernels;

/* The kernels of the instruction set in use. many_kernels.c */
gather_kernels ylm__gather_kernels(const ylm_shade_gather_options *o);
/* The weight of one light: the plain form, which judges the others. many_plain.c */
double ylm__gather_weight(const gather_lights *l, const gather_ask *a, size_t i, const float x[3],
                          const float N[3]);

/*
** ylm__gather_parts - groups of lights, parted where they are widest in place and direction. many_vsgl.c
**
** Light i of `out` is group i: at its mean place, normal the axis of its lobe, radius the deviation of its places, shift its
** sharpness, intensity its power over A (sharpness). *count: how many there are, at most `groups`. YLM_ENOMEM
*/
ylm_status ylm__gather_parts(const ylm_light_virtual *lights, size_t groups, size_t *count,
                             const gather_lights *out);
/* The weight of group i at x, normal N: out [1]; r not NULL: of the lobe of that receiver, out [3]. The plain form. */
void ylm__gather_gaussian(const gather_lights *l, const struct gather_receiver *r, size_t i,
                          const float x[3], const float N[3], double out[3]);

/* Pairs of a shading point and a light at the same place. many_singular.c, YLM_ENOMEM */
ylm_status ylm__gather_singular(const ylm_shade_view *v, const gather_lights *l, uint64_t *pairs);

/* The plain form of ylm_shade_send_fn. many_plain.c */
ylm_shade_send_fn ylm__gather_send;

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

/* The plain form. */
ylm_shade_spheres_fn ylm__gather_spheres;
/* As that, of a receiver that glosses: radiance for an intensity of 1, w [3][GATHER_CHUNK]. */
void ylm__gather_spheres_gloss(const gather_lights *l, const gather_ask *a,
                               const struct gather_receiver *r, size_t first, size_t n,
                               const float x[3], const uint32_t seed[2], const float *keep,
                               float (*w)[GATHER_CHUNK]);

/* -- many_subset.c: which lights a point asks --------------------------------------- */

/* The group of a point's pixel. */
size_t ylm__gather_group(const ylm_shade_view *v, int tile, size_t pixel);
/* In place: irradiances [points][3] of points that ask one light of tile^2 become means over a tile
   of pixels. A mean takes points on the same mesh whose normals are within 20 degrees. `keeps`:
   point p stays as it is. YLM_ENOMEM */
typedef bool ylm_shade_keeps_fn(const void *context, size_t p);
ylm_status ylm__gather_filter(const ylm_shade_view *v, int tile, ylm_shade_keeps_fn *keeps,
                              const void *context, int threads, float *out);
/* One walk along a point's lights: each step of alpha along the sum of their bounds keeps one. */
typedef struct gather_walk {
  double alpha, upto;
} gather_walk;
/* The factor of a light of this bound: 0 leaves it out; the mean is 1. */
static inline float ylm__gather_keep(gather_walk *w, double bound) {
  if (!(bound < w->alpha)) return 1;
  w->upto += bound;
  if (w->upto < w->alpha) return 0;
  w->upto -= w->alpha;
  return (float)(w->alpha / bound);
}

struct gather_gloss;
/* Adds to irradiances [points][3], of points that gloss radiances, what the bound took. many_vpl.c */
ylm_status ylm__gather_compensate(const ylm_shade_view *v, const gather_ask *a,
                                  const struct gather_gloss *gloss, float *out, uint64_t *rays,
                                  ylm_error *e);

#endif
