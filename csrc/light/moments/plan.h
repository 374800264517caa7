/*
** plan.h - from sums of moments to results: maps, the plan of a query, the kernels that it needs.
**
** Private to csrc/light. The kernels of one lmax (gen/moments_N.h) know nothing of it.
*/
#ifndef YLM_LIGHT_PLAN_H
#define YLM_LIGHT_PLAN_H

#include "../light.h"
#include "moments.h"
#include "ylm_light_device.h"

typedef ylm_light_rows ylm__rows;

/* Room for n rows with so many terms in all; rows are then made one after the other. */
ylm_status ylm__rows_create(ylm__rows *r, size_t n, size_t terms);
/* Adds a term to the row being built. */
void ylm__rows_term(ylm__rows *r, size_t index, double coef);
void ylm__rows_end(ylm__rows *r);
/* Appends `factor` times a row over sums that begin at `offset` to the row being built. maps.c */
void ylm__rows_append(ylm__rows *to, const ylm__rows *from, size_t row, size_t offset,
                      double factor);
/* Appends row i of hessian * to_u; own [m->sums] is scratch. maps.c */
void ylm__rows_by_u(ylm__rows *to, const ylm_light_maps *m, size_t i, double *own);
void ylm__rows_free(ylm__rows *r);

/*
** Maps from the sums of one set of channels to results. Rows are in the order of the results:
** coefficient i = l(l+1)+m, then x y z, or xx xy xz yy yz zz. `to_u` makes U of docs/math.md,
** [(lmax+2)^2][3], from sums, and `hessian` (in ylm__plan) the Hessian from U.
*/
typedef struct ylm__map {
  ylm__rows value, gradient, to_u;
} ylm__map;

/* The maps for the kinds of `need` out of sums of `kinds`. */
ylm_status ylm__map_create(ylm__map *map, int lmax, int need, int kinds, double grow);
void ylm__map_free(ylm__map *map);
/* H_ab L_lm from U. */
ylm_status ylm__map_hessian(ylm__rows *r, int lmax);
/* Y_km over (monic polynomial in z) times Re or Im (x+iy)^|m|. */
double ylm__harmonic_scale(int k, int m, double grow);
/* The kinds of sums that results of `channels` channels need. */
int ylm__kinds_of(const ylm_field_query *q, int channels);

/* How a query is answered: what is summed in which channels, and how results follow. */
typedef struct ylm__plan {
  const ylm_field_query *q;
  const ylm_lights *lights;
  const ylm__moment_kernel *kernel;
  int need_lum, need_rgb;   /* kinds that results need in luminance and in rgb */
  int kinds_lum, kinds_rgb; /* kinds that are summed in each */
  int n_lum, n_rgb;         /* how many sums these are */
  ylm__map lum, mixed, rgb; /* from luminance sums, from rgb sums weighted to luminance, from rgb */
  ylm__rows hessian;
} ylm__plan;

/* The plan of a query for a kernel, or YLM_ENOMEM; to be freed with ylm__plan_free in any case. */
ylm_status ylm__plan_create(ylm__plan *p, const ylm_lights *lights, const ylm_field_query *q,
                            const ylm__moment_kernel *kernel);
void ylm__plan_free(ylm__plan *p);

/* The kernel of an instruction set for (lmax, dtype), and the loop around it: points begin ..
 *end-1. scratch is NULL at a worker's first call; what it then holds is freed by the caller. */
typedef ylm_status ylm__sum_range(const ylm__plan *p, void **scratch, size_t begin, size_t end,
                                  const void *points, ylm_field_result *r);
struct ylm__tree_plan;
/* The loop over a tree of lights (tree/tree.h), for blocks begin .. end-1 of points; scratch is of
   three, the first of which begins with the number of lights and proxies that were summed, a
   uint64_t. */
typedef ylm_status ylm__tree_range(const struct ylm__tree_plan *p, void **scratch, size_t begin,
                                   size_t end, const void *points, ylm_field_result *r);
typedef struct ylm__kernel_set {
  const ylm__moment_kernel *moments;
  ylm__sum_range *range;
  ylm__tree_range *tree;
  ylm_light_lambda2_fn *lambda2; /* always of floats */
} ylm__kernel_set;
/* False where there are none (the reference). */
bool ylm__kernels_of(ylm_isa isa, int lmax, ylm_dtype t, ylm__kernel_set *set);

#endif
