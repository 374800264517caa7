/*
** sphere.h - sphere lights: spheres that emit the same radiance everywhere and in every direction.
** Private to csrc/light.
**
** | parameter | unit            | allowed                                            |
** | radiance  | W sr^-1 m^-2    | finite, linear Rec. 709, may be negative           |
** | at        | scene units     | finite, |coordinate| <= YLM_LIGHT_EXTENT           |
** | radius    | scene units     | 0 .. YLM_LIGHT_EXTENT; a radius of 0 emits nothing |
**
** The coefficients at a point x of a light with centre y, v = y - x, d = |v| > r:
** L_lm(x) = integral of Y_lm over the cap of half-angle asin(r/d) about v/d, times the radiance.
** At points in or on a light the sphere fills every direction: L_00 = sqrt(4pi) times the radiance,
** all else and all derivatives 0, and `inside` is set.
*/
#ifndef YLM_LIGHT_SPHERE_H
#define YLM_LIGHT_SPHERE_H

#include "../lamp.h"
#include "ylm_base.h"

typedef struct ylm_lights {
  ylm_field field;
  size_t n;
  ylm__lamp_d *all;    /* [n] as they were given */
  size_t active;       /* number of lights with a radius above 0 */
  double origin[3];    /* of lamp_d, lamp_f and the tree: ylm_origin of all that emit */
  ylm__lamp_d *lamp_d; /* [active], in the order given; `all` itself where all emit near 0 */
  ylm__lamp_f *lamp_f; /* [active] */
  struct ylm_light_tree *tree; /* NULL until a cut needs it */
} ylm_lights;

/* n sphere lights, all of them checked; to be freed with ylm_lights_free. Returns as
   ylm_light_set_spheres. */
ylm_status ylm_lights_create(size_t n, const double *at, const double *radius,
                             const double *radiance, ylm_lights **lights, ylm_error *e);
void ylm_lights_free(ylm_lights *lights);

/*
** ylm_lights_evaluate - the field's `evaluate` by the kernels of a given instruction set.
**
** Value, gradient, Hessian and the metric of the sum of all lights at n points, see
** ylm_field_query and ylm_field_result. YLM_ISA_reference is the product rule in double, light by
** light, and judges the others, which sum moments.
**
**   isa     in   an available one
**   points  in   [n][3] of q->dtype, finite, |coordinate| <= YLM_LIGHT_EXTENT
**   r       out  what q->want asks for; r->pairs grows by n times the number of lights
**
** Returns  YLM_OK; YLM_ERANGE (lmax, a point too far out), YLM_EDOMAIN (a point is not finite),
**          YLM_EINVAL (channels, isa): nothing is written then; YLM_ENOMEM; YLM_ECANCELLED
** Accuracy relative to the L2 norm over all degrees, against double at the inputs rounded to the
**          dtype, d/r from 1.001 on: double 1e-13 + 1e-15 d/(d-r); float 4e-6 + 1.5e-7 d/(d-r) to
**          lmax 31 (spec/bench/accuracy.c; docs/performance.md has what is found)
** Sums     of 1e5 lights in float stay within 1e-5 of double (compensated sums of 256)
** Threads  a point's result depends on the point and the lights alone: neither on the number of
**          threads nor on the other points of the batch
** Source   Iwasaki & Dobashi 2025, Eqs. 2-8, 15-20; docs/math.md "Sum of sphere lights"
*/
ylm_status ylm_lights_evaluate(const ylm_lights *lights, ylm_isa isa, const ylm_field_query *q,
                               size_t n, const void *points, ylm_field_result *r, ylm_error *e);

/* The field of spheres by their tree, which is made where there is none: tree/tree.c. The field
   must not outlive them. `tolerance` is that of ylm_light_cut_create. YLM_ENOMEM. */
typedef struct ylm__tree_field ylm__tree_field;
ylm_status ylm__tree_field_create(ylm_lights *lights, double tolerance, int threads,
                                  ylm__tree_field **field, ylm_error *e);
void ylm__tree_field_free(ylm__tree_field *field);
const ylm_field *ylm__tree_field_get(const ylm__tree_field *field);
ylm_status ylm__tree_field_evaluate(const ylm__tree_field *field, ylm_isa isa,
                                    const ylm_field_query *q, size_t n, const void *points,
                                    ylm_field_result *r, ylm_error *e);
/* The memory that the tree takes; 0 where there is none. */
size_t ylm__lights_tree_bytes(const ylm_lights *lights);

#endif
