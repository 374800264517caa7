/* many.h - rivals of virtual lights: what their files share. Private to csrc/rival. */
#ifndef YLM_RIVAL_MANY_H
#define YLM_RIVAL_MANY_H

#include "ylm_shade_rival.h"

/* -- spheres: vsl.c -- */

/* Ways to choose directions. */
enum { VSL_CONE, VSL_RECEIVER, VSL_LIGHT };
/* Of smaller cones, in parts of the hemisphere, the other ways find next to nothing. */
#define VSL_SMALL 0.03f
/* Light i begins with the numbers (seed + i step)/2^32 (Roberts 2018). */
#define VSL_STEP_U 3242174889u
#define VSL_STEP_V 2447445414u

/* The plain form. */
ylm_many_spheres_fn ylm__many_spheres;
ylm_many_spheres_gloss_fn ylm__many_spheres_gloss;

/* -- points: vpl.c, vpl_plain.c -- */

/* The plain form. */
ylm_many_weights_fn ylm__many_points;
/* The factor g = c_x c_y/d^2 as a bound leaves it. */
double ylm__many_bound(const ylm_many_ask *a, double g, double d2);
/* ylm_shade_rival */
ylm_status ylm__many_compensate(const ylm_many_ask *a, float *out, uint64_t *rays, ylm_error *e);

/* -- groups: vsgl.c -- */

/* The plain forms. */
ylm_many_weights_fn ylm__many_gaussians;
ylm_many_gloss_fn ylm__many_gaussians_gloss;
/* ylm_shade_rival */
ylm_status ylm__many_parts(const ylm_light_virtual *lights, size_t groups, size_t *count,
                           const ylm_many_lights *out);

/* subset.c: ylm_shade_rival */
ylm_status ylm__many_filter(const ylm_many_host *host, int tile, int threads, float *out);

#endif
