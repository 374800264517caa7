/*
** ylm_trace_occlusion.h - what a body of any shape hides, by rays.
**
** The visibility of a closed mesh as a light field, of quantity YLM_QUANTITY_visibility: see ylm_light_shadow.h, whose
** solids are convex and exact.
**
**     ylm_trace_occlusion *knot;
**     if (ylm_trace_occlusion_create(vertices, position, triangles, index, 64, &knot, &error) == YLM_OK)
**       ... ylm_trace_occlusion_field(knot) ...
**
** Source  Zhou et al. 2005; Ward & Heckbert 1992 (gradients); docs/shadow_fields.md
*/
#ifndef YLM_TRACE_OCCLUSION_PUBLIC_H
#define YLM_TRACE_OCCLUSION_PUBLIC_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_OCCLUSION_LEAST_RAYS 4
#define YLM_OCCLUSION_MOST_RAYS 1024

/* Immutable; any number of threads may ask at once. */
typedef struct ylm_trace_occlusion ylm_trace_occlusion;

/*
** ylm_trace_occlusion_create - the inside of a closed mesh.
**
**   position  in   [vertices][3]    finite; vertices at one place are one
**   index     in   [triangles][3]   each below `vertices`; neighbours turn the same way
**   rays      in   YLM_OCCLUSION_LEAST_RAYS .. YLM_OCCLUSION_MOST_RAYS: of a right angle, and twice as many across a body
**                  that is seen within a right angle. Parts that look thinner may be missed
**
** The rim of the body is found between directions that hit and that miss, by halving. Values and gradients are integrals
** over the rim, so errors fall as 1/rays^2 where the rim is smooth; neighbouring points do not jump.
**
** Returns  YLM_OK; YLM_ERANGE (rays), YLM_EDOMAIN (open, flat, empty, not finite): `e` says what; YLM_ENOMEM, YLM_EDEVICE
** Cost     of a point: 4 rays^2 rays, 6 rays^2 near the body; (lmax+1)^2 of each of some 16 rays arcs
*/
YLM_API ylm_status ylm_trace_occlusion_create(size_t vertices, const float *position,
                                              size_t triangles, const uint32_t *index, int rays,
                                              ylm_trace_occlusion **out, ylm_error *e);
YLM_API void ylm_trace_occlusion_free(ylm_trace_occlusion *o);
/* The field lives as long as the occlusion. It has values, gradients and the metric, no Hessians. Points in the body: 0
   everywhere, `inside` 1. */
YLM_API const ylm_field *ylm_trace_occlusion_field(const ylm_trace_occlusion *o);
/* A sphere around the body, and the mean area of its projections, by rays. */
YLM_API void ylm_trace_occlusion_body(const ylm_trace_occlusion *o, double at[3], double *radius,
                                      double *area);
/*
** ylm_trace_occlusion_places - n places around the body, at random by seed.
**
** Each starts off a random place of the surface, `near` along the normal, and goes on along a random direction, to at most
** `far`, so that the logarithm of its distance from the middle is about even, as of ylm_light_occluder_places. Starts that
** are in the body are drawn again.
**
**   near, far  in   scene units
**   places     out  [n][3]
**
** Returns  YLM_OK; YLM_EDOMAIN (the body leaves no room: `near` is too far)
*/
YLM_API ylm_status ylm_trace_occlusion_places(const ylm_trace_occlusion *o, double near, double far,
                                              uint64_t seed, size_t n, float *places, ylm_error *e);
/* The error of values at n places [n][3], as a part of the function 1: the largest distance to those by half of the rays,
   over 2. Errors fall with the rays or faster. */
YLM_API ylm_status ylm_trace_occlusion_noise(const ylm_trace_occlusion *o, int lmax, size_t n,
                                             const float *places, int threads, double *noise,
                                             ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
