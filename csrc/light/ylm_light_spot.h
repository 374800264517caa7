/*
** ylm_light_spot.h - spots: lights of one place that shine into a cone, as rays see them.
**
** A spot has no size, so it has no light field: what asks for one is refused. Rays aim at its place
** alone; particles leave it.
*/
#ifndef YLM_LIGHT_SPOT_H
#define YLM_LIGHT_SPOT_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_light_set ylm_light_set; /* ylm_light.h */

/* The intensity is `intensity` where the cosine to the axis is above `inner`, 0 below `outer`, and a
   smooth step of the cosine between. */
typedef struct ylm_light_spot {
  double intensity[3]; /* W/sr */
  double at[3];        /* scene units */
  double axis[3];      /* of length 1 */
  double inner, outer; /* cosines, -1 <= outer <= inner < 1 */
} ylm_light_spot;

/* Spot i of a set; false: there are no more. */
YLM_API bool ylm_light_set_spot(const ylm_light_set *set, size_t i, ylm_light_spot *out);
/* The part of the intensity that goes in a direction of this cosine to the axis: 0 .. 1. */
YLM_API double ylm_light_spot_part(const ylm_light_spot *spot, double cosine);
/* The solid angle that the intensity would fill if it were the same everywhere: power over intensity, sr. */
YLM_API double ylm_light_spot_solid(const ylm_light_spot *spot);

#ifdef __cplusplus
}
#endif
#endif
