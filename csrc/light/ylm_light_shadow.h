/*
** ylm_light_shadow.h - bodies in the way of light: what they hide, where they stand, what they let through.
**
** A visibility is a light field, of quantity YLM_QUANTITY_visibility: 1 from where light reaches a point, 0 from where a
** body hides it. The visibility is sqrt(4 pi) in (0, 0) less what a light of radiance 1 of the
** body's shape would bring.
**
**     ylm_light_occluder *ball;
**     ylm_light_shadowed *shade;
**     double origin[3] = {0, 0, 0};
**     if (ylm_light_occluder_sphere(origin, 0.5, &ball, &error) == YLM_OK) {
**       ylm_light_caster caster = {.hides = ylm_light_occluder_field(ball), .at = {0, 1, 0},
**                                  .rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .scale = 1, .radius = 0.5};
**       ...
**       ylm_light_shadowed_create(lamps, NULL, 1, &caster, &form, &shade, &error);
**
** Source  Zhou et al. 2005; docs/shadow_fields.md
*/
#ifndef YLM_LIGHT_SHADOW_H
#define YLM_LIGHT_SHADOW_H

#include "ylm_light.h"
#include "ylm_sh_exponential.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- what one body hides: csrc/light/shadow/occluder.c ------------------------------------------ */

/* The visibility around one body, exactly, with gradients and Hessians. Immutable. */
typedef struct ylm_light_occluder ylm_light_occluder;

/* The most triangles of a solid: each point asks all its faces. */
#define YLM_OCCLUDER_TRIANGLES 4096

/* A sphere. YLM_EDOMAIN (not finite, radius not above 0), YLM_ERANGE (beyond YLM_LIGHT_EXTENT), YLM_ENOMEM. */
YLM_API ylm_status ylm_light_occluder_sphere(const double at[3], double radius,
                                             ylm_light_occluder **out, ylm_error *e);
/*
** ylm_light_occluder_solid - the inside of a closed convex mesh: half the sum of its faces as lights of two sides,
** since each direction through it crosses two faces.
**
**   position  in   [vertices][3]    finite; vertices at one place are one
**   index     in   [triangles][3]   each below `vertices`; either orientation
**
** Returns  YLM_OK; YLM_EDOMAIN (open, not convex, flat, empty, not finite): `e` says what; YLM_ERANGE (more than
**          YLM_OCCLUDER_TRIANGLES); YLM_ENOMEM
*/
YLM_API ylm_status ylm_light_occluder_solid(size_t vertices, const float *position,
                                            size_t triangles, const uint32_t *index,
                                            ylm_light_occluder **out, ylm_error *e);
YLM_API void ylm_light_occluder_free(ylm_light_occluder *o);
/* The field lives as long as the occluder. Points in or on the body: 0 everywhere, `inside` 1. */
YLM_API const ylm_field *ylm_light_occluder_field(const ylm_light_occluder *o);
/* A sphere around the body, and the mean area of its projections: a quarter of the surface. */
YLM_API void ylm_light_occluder_body(const ylm_light_occluder *o, double at[3], double *radius,
                                     double *area);

/* n places around the body, at random by seed: the logarithm of their distance from its middle is even between its surface,
   `near` times farther than that, and `far`. [n][3] */
YLM_API void ylm_light_occluder_places(const ylm_light_occluder *o, double near, double far,
                                       uint64_t seed, size_t n, float *places);

/* Facts about a closed mesh. */
typedef struct ylm_light_body {
  double at[3], radius; /* a sphere around it */
  double area;          /* of its surface */
  double volume;        /* negative where triangles are clockwise, seen from outside */
} ylm_light_body;

/*
** ylm_light_body_measure - a closed mesh of any shape and size: csrc/light/shadow/solid.c.
**
** Returns  as ylm_light_occluder_solid, which is more strict: a mesh may be hollow, and may have any number of triangles
*/
YLM_API ylm_status ylm_light_body_measure(size_t vertices, const float *position, size_t triangles,
                                          const uint32_t *index, ylm_light_body *out, ylm_error *e);

/* -- bodies in the way: csrc/light/shadow/shadowed.c -------------------------------------------- */

#define YLM_CASTERS 65535

/* A body at its place. A point p of the body's frame is at + scale rotation p. */
typedef struct ylm_light_caster {
  const ylm_field *hides; /* of the body; NULL: a sphere of radius `scale` about `at` */
  double at[3], rotation[9], scale;
  int lmax;                 /* that `hides` is known to; above it is 0 */
  double centre[3], radius; /* a sphere around the body, in its frame */
  double
      far; /* farther from `centre` than this `hides` is not asked; 0: there is no such distance */
  double area;   /* with `far`: beyond it the body is a disk of this area */
  uint32_t body; /* spheres of one number that follow one another are one body */
} ylm_light_caster;

/* How visibilities are multiplied: at directions of one rule; of one that is exact; two at a time, cut off at lmax; as an
   exponential of the sum of their logarithms, of spheres alone (ylm_sh_exponential.h). */
#define YLM_SHADOW_PRODUCT_LIST(X) X(rule) X(accurate) X(recursive) X(exp)

typedef enum ylm_shadow_product {
#define X(name) YLM_SHADOW_PRODUCT_##name,
  YLM_SHADOW_PRODUCT_LIST(X)
#undef X
      YLM_SHADOW_PRODUCT_COUNT
} ylm_shadow_product;

YLM_API const char *ylm_shadow_product_name(ylm_shadow_product p);

typedef struct ylm_light_shadow_form {
  ylm_shadow_product product;
  double rule; /* of product rule: the rule's degree over lmax, 2 .. 12 */
  double
      cull; /* 0 .. 1: casters that change a visibility by less than this, over their number, are left out */
  bool layers; /* bodies that do not overlap, seen from a point, are summed: one factor */
  ylm_sh_exp_method exponential; /* of product exp */
  int terms;                     /* of its series PS, 1 .. YLM_SH_EXP_TERMS */
} ylm_light_shadow_form;

/* Light behind bodies. Its field may be asked by many threads; it is moved by one. */
typedef struct ylm_light_shadowed ylm_light_shadowed;

/*
** ylm_light_shadowed_create - the light of `lights` and of `other` that casters let through.
**
**   lights  in   may be NULL; of lights that have a place (spheres, flat lights), casters that are farther away take
**                nothing. It and all fields must outlive the result
**   other   in   may be NULL; every caster stands before it
**   caster  in   [n], copied; n = 0: the light as it is
**
** The field has values, gradients and the metric, no Hessians. lmax <= YLM_SH_PRODUCT_LMAX, of product exp
** YLM_SH_LOG_LMAX.
**
** Returns  YLM_OK; YLM_ERANGE (n, form, accurate with more than 15 casters), YLM_EDOMAIN (a caster that is not finite,
**          scale not above 0, no rotation: `e` names it, counted from 1), YLM_EINVAL (no sphere, with exp); YLM_ENOMEM.
**          The field: YLM_ERANGE where a series diverges, naming the point
** Cost     of a point: a sample, a rotation and a transform for each caster, and two transforms for each channel
*/
YLM_API ylm_status ylm_light_shadowed_create(const ylm_light_set *lights, const ylm_field *other,
                                             size_t n, const ylm_light_caster *caster,
                                             const ylm_light_shadow_form *form,
                                             ylm_light_shadowed **out, ylm_error *e);
YLM_API void ylm_light_shadowed_free(ylm_light_shadowed *s);
YLM_API const ylm_field *ylm_light_shadowed_field(const ylm_light_shadowed *s);
/* Caster i, where it stands; i < their number. */
YLM_API const ylm_light_caster *ylm_light_shadowed_caster(const ylm_light_shadowed *s, size_t i);

/* The light that all casters but a few let through: that of a body's own surface, which its own shadow would darken. */
typedef struct ylm_light_shadowed_rest {
  ylm_field field;
  const ylm_light_shadowed *of;
  size_t first, n; /* the casters that are left out */
} ylm_light_shadowed_rest;

/* Its field lives as long as `rest` and `s`, and follows the casters of `s`. YLM_ERANGE: there are no such casters. */
YLM_API ylm_status ylm_light_shadowed_without(const ylm_light_shadowed *s, size_t first, size_t n,
                                              ylm_light_shadowed_rest *rest);

/* Work since the light was made: points asked, casters that count there, products of light and casters, factors that are
   multiplied at directions, seconds. A layer of bodies is one factor. */
typedef struct ylm_light_shadowed_stats {
  uint64_t points, casters, products, factors;
  double seconds;
} ylm_light_shadowed_stats;

YLM_API void ylm_light_shadowed_look(const ylm_light_shadowed *s, ylm_light_shadowed_stats *out);
/* Puts casters first .. first+n-1 elsewhere: at [n][3], rotation [n][9], scale [n]; NULL: as it was. All of them or,
   where one is not sound, none: as ylm_light_shadowed_create. */
YLM_API ylm_status ylm_light_shadowed_move(ylm_light_shadowed *s, size_t first, size_t n,
                                           const double *at, const double *rotation,
                                           const double *scale, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
