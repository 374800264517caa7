/*
** point.h - lights of no size as rays meet them, once their intensity along a direction is known. Private to csrc/light.
**
** Such a light is sampled as if it filled a solid angle so small that no other ray finds it: estimates by several
** kinds of rays leave its light to the rays that are aimed. Its numbers begin with a colour [3].
*/
#ifndef YLM_LIGHT_POINT_H
#define YLM_LIGHT_POINT_H

#include "ylm_light_emitter.h"

/* The part of the colour that goes along `way`, of length 1: with it an intensity. */
typedef double ylm__point_along(const double *x, const double way[3]);

/* A kind's answers `weight` and `toward` for a light at `at`. point.c */
double ylm__point_weight(const double *x, const double at[3], ylm__point_along *along,
                         const double from[3], const float *normal);
bool ylm__point_toward(const double *x, const double at[3], ylm__point_along *along,
                       const double from[3], ylm_light_way *out);

#endif
