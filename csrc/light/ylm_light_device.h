/*
** ylm_light_device.h - what a device needs to sum lights with kernels of its own: how results
** follow from sums, and lights as arrays.
*/
#ifndef YLM_LIGHT_DEVICE_H
#define YLM_LIGHT_DEVICE_H

#include "ylm_light.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Refuses queries that a field of lights refuses, with lmax at most `most`, in its words. */
YLM_API ylm_status ylm_light_check(const ylm_field_query *q, int most, size_t n, const void *points,
                                   const ylm_field_result *r, ylm_error *e);

/* -- lights as they are summed: csrc/light/set.c --------------------------------------------- */

/* A sphere; where it stands for a flat light, the light's normal, else 0. */
typedef struct ylm_light_lamp {
  double at[3], radius, radiance[3], normal[3];
} ylm_light_lamp;

/* Flat lights as arrays: rows of vertices begin at first[i]; horizon: its unit normal, or NULL. */
typedef struct ylm_light_rims {
  size_t n;
  const int *sides;       /* [n]; 0: an ellipse */
  const size_t *first;    /* [n] */
  const double *vertices; /* [..][3]; of an ellipse its centre and two half axes */
  const double *normal, *centroid, *radiance; /* [n][3] */
  const double *horizon;
} ylm_light_rims;

/* Lights of a set that a device sums alike: spheres, spheres times the cosine to their normals, or
   exact flat lights along their rims. As long as the set lives. */
typedef struct ylm_light_part {
  const char *kind; /* its name */
  size_t lamps;
  bool cosine; /* lamps have normals */
  const void *of;
  void (*lamp)(const void *of, size_t i, ylm_light_lamp *out); /* with part->of */
  ylm_light_rims rims;                                         /* n 0: none */
} ylm_light_part;

/* Part i of the set; false where there are no more. A part without lamps and rims is of a kind that
   no device sums. */
YLM_API bool ylm_light_set_part(const ylm_light_set *set, size_t i, ylm_light_part *out);

/* -- sums of moments: csrc/light/moments/maps.c ---------------------------------------------- */

/* A sparse matrix: row i is the sum of coef[t] * x[index[t]] over t = start[i] .. start[i+1]-1. */
typedef struct ylm_light_rows {
  size_t n;
  uint32_t *start, *index;
  double *coef;
  float *coef_f;
} ylm_light_rows;

/*
** How results follow from sums over lights. Rows are in the order of the results: coefficient
** l(l+1)+m, then x y z, or xx xy xz yy yz zz. `to_u` makes U of docs/math.md, [(lmax+2)^2][3],
** from the sums, and `hessian` the Hessians from U; without it they follow from the sums.
*/
typedef struct ylm_light_maps {
  size_t sums; /* how many there are of a channel */
  ylm_light_rows value, gradient, to_u, hessian;
} ylm_light_maps;

/*
** ylm_light_maps_create - for the sums of merged moments.
**
** Kinds of sums are bits: 1 those that values need, 2 gradients, 4 Hessians. Per light,
** unnormalised weights of a kind times monic Legendre polynomials in z times Re or Im (x+iy)^m are
** summed, in the order of csrc/light/moments/moments.h.
**   need   in   kinds of the results; a subset of `kinds`
**   kinds  in   kinds that are summed
** To be freed in any case. YLM_ENOMEM.
*/
YLM_API ylm_status ylm_light_maps_create(int lmax, int need, int kinds, ylm_light_maps *maps);
/* How many of these sums there are at degree k <= lmax + 2 of a column: one for each kind there. */
YLM_API int ylm_light_sums_at(int lmax, int kinds, int k);
/* The constants slows, step, rho, beta of the recurrences of weights and of order m from degree k
   to k + 1 (lua/ylm/codegen/recurrences.lua); returns what z is multiplied by in these sums. */
YLM_API double ylm_light_recurrence(int lmax, int m, int k, double constant[4]);
/* For the sums of the product rule with 0, 1 or 2 derivatives, see shaders/product.real.comp. */
YLM_API ylm_status ylm_light_product_maps_create(int lmax, int derivatives, ylm_light_maps *maps);
/*
** For merged moments of spheres times a cosine c that differs from light to light, as flat lights
** are approximated, with 0, 1 or 2 derivatives. First the sums of kinds 1, 3 or 7 times
** c; with derivatives those of kinds 1 (3 with Hessians) times c's derivatives by the light's x, y,
** z, one after the other; with Hessians those of kind 1 times c's second derivatives xx .. zz.
*/
YLM_API ylm_status ylm_light_flat_maps_create(int lmax, int derivatives, ylm_light_maps *maps);
YLM_API void ylm_light_maps_free(ylm_light_maps *maps);
/* The kinds of sums that a query needs in luminance and in rgb. */
YLM_API void ylm_light_kinds(const ylm_field_query *q, int *lum, int *rgb);
/* -- sums along the rims of exact flat lights: csrc/light/flat/device.c ----------------------- */

/* The highest degree of exact flat lights. */
#define YLM_LIGHT_RIM_LMAX 60
/* An upper bound of |y'| along a rim of half axes u, v. */
YLM_API double ylm_light_rim_speed(const double *u, const double *v);
/* The rules of Gauss and Legendre along rims, to [..][195]: nodes; degree times half angle that
   they integrate to 1e-16, to 1e-10; 96 places, 96 weights, zeros behind the last. How many numbers
   these are; `to` may be NULL. */
YLM_API size_t ylm_light_rim_rules(double *to);
/*
** Sums along rims of kinds 1, 2, 4 (csrc/light/flat/kernel.h says of which; 1 is always among
** them), of a channel: of each axis x, y, z those of all kinds, degree by degree; the solid angle;
** with Hessians, where lights are `cut` at horizons, what these add to xx .. zz.
*/
YLM_API size_t ylm_light_rim_sums(int lmax, int kinds, bool cut);
/* How results of kinds `need` follow from the sums of `base` (none: {0}) and, behind them, these;
   without it. To be freed with ylm_light_maps_free in any case. YLM_ENOMEM. */
YLM_API ylm_status ylm_light_rim_maps_create(int lmax, int need, int kinds, bool cut,
                                             const ylm_light_maps *base, ylm_light_maps *maps);

#ifdef __cplusplus
}
#endif
#endif
