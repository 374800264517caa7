/* ylm_shade_gloss.h - points that gloss, by rays where harmonics are too few. */
#ifndef YLM_SHADE_GLOSS_H
#define YLM_SHADE_GLOSS_H

#include "ylm_shade.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_shade_blending {
  const ylm_scene *lit;    /* whose lamps: as ylm_shade_raycast; NULL: the view's             */
  ylm_shade_weight weight; /* what the light was multiplied by                                */
  int lmax;                /* its degree                                                      */
  int light_samples; /* 1 .. YLM_SCENE_SAMPLES: rays to lamps, and as many by the material; 0: there
                              are no lamps, and no rays                                       */
  double noise;      /* > 0: light_samples is the least number of a pixel and mesh, raised
                              where it varies until each mesh's noise is at most this, root mean
                              square over that of its radiance (a tenth of the picture's, if less), */
  int most_samples;  /* up to this                                                      */
  bool shadows;      /* false: nothing occludes                                         */
  uint64_t seed;
  int threads;
  const ylm_progress *progress; /* stage "places" */
} ylm_shade_blending;

/* How points of surfaces that are not matte were shaded. */
typedef struct ylm_shade_blended {
  size_t sh, rays;   /* points by harmonics, and by rays: both, where they are mixed            */
  double missed;     /* root mean square of e at points, each as often as harmonics count there */
  uint64_t traced;   /* rays                                                                    */
  int light_samples; /* the mean of pixels and meshes                                      */
  double noise;      /* that they leave in the mesh that has most; below 0: not measured   */
  double seconds;
} ylm_shade_blended;

/*
** ylm_shade_blend - radiance of points that gloss by rays, where the light's degree is too low for them.
**
** A point's slice f cos, towards the camera, misses the part e of its norm at degree lmax. Rays count
**
**   w = smoothstep(gloss_error[0], gloss_error[1], e)     SH: 0     RAYS: 1
**
** and what harmonics made of the point 1 - w. Rays are those of ylm_shade_raycast.
**
**   radiance  in/out  [points][3]
**   share     out     [points]: w; 0 of matte points
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EINVAL (other meshes; RAYS, per_vertex), YLM_ENOMEM, YLM_ECANCELLED
** Cost     as ylm_shade_raycast for points where w > 0; the others' radiance keeps its bits
*/
YLM_API ylm_status ylm_shade_blend(const ylm_shade_view *view, const ylm_shade_blending *o,
                                   float *radiance, float *share, ylm_shade_blended *report,
                                   ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
