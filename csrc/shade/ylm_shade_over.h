/* ylm_shade_over.h - pictures darkened by the openness of points, and lamps and bodies drawn over pictures. */
#ifndef YLM_SHADE_OVER_H
#define YLM_SHADE_OVER_H

#include "ylm_shade.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- openness: ambient.c, ssao.c ------------------------------------------------ */

/* How the openness of a point is found. */
typedef enum ylm_shade_ambience {
  YLM_SHADE_SCREEN, /* 16 samples of the picture about the point's place in it, and their horizons */
  YLM_SHADE_AMBIENT_RAYS /* 128 rays, dense as the cosine */
} ylm_shade_ambience;

/*
** ylm_shade_ambient - the part of the light from everywhere that nothing keeps from a shading point.
**
**   a = 1/pi integral of cosine over directions in which nothing is nearer than `radius`
**
** SCREEN knows the surfaces that the camera sees: two slices through the line of sight with four samples
** on each side, turned and shifted from pixel to pixel, the mean of 4 x 4 pixels. Samples less than 0.05
** of their distance above the surface are the surface. The result is 1 where the radius is below a
** pixel.
**
**   radius  in   scene units, > 0
**   out     out  [points], 0 to 1
**
** Returns  YLM_OK; YLM_ERANGE (radius), YLM_EINVAL (a view per vertex; SCREEN: of some pixels alone),
**          YLM_ENOMEM, YLM_ECANCELLED (RAYS: progress stage "ambient")
** Source   Bavoil & Sainz 2008, "Screen Space Ambient Occlusion"; slices weighted by the cosine: Jimenez,
**          Wu, Pesce, Jarabo 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion"
*/
YLM_API ylm_status ylm_shade_ambient(const ylm_shade_view *view, ylm_shade_ambience method,
                                     double radius, int threads, const ylm_progress *progress,
                                     float *out);

/* -- lamps that move: lamps.c --------------------------------------------------- */

/*
** ylm_shade_draw_lamps - draw spheres over an image of the view: lamps that are not in its scene.
**
** A lamp covers the part of a pixel by which the pixel's centre is inside of its rim. Surfaces that
** are nearer than the lamp's centre hide it. Farther lamps are drawn first.
**
**   out  in/out  [height][width][3]
*/
YLM_API ylm_status ylm_shade_draw_lamps(const ylm_shade_view *view, const ylm_scene_lamps *lamps,
                                        int threads, float *out);

/* Depth of what such a picture shows: a lamp that covers more than half of a pixel writes its nearest
   depth where that is less than what stands there. depth in/out [height][width] of
   YLM_SHADE_DEPTH. YLM_ENOMEM. */
YLM_API ylm_status ylm_shade_lamp_depth(const ylm_shade_view *view, const ylm_scene_lamps *lamps,
                                        int threads, float *depth);

/* A lamp near a place of the image. */
typedef struct ylm_shade_lamp {
  size_t index; /* of the sphere */
  double away;  /* from its rim, pixels; 0: the place lies on it */
  double depth; /* of its centre, along the view axis */
} ylm_shade_lamp;

/* The lamp whose rim is nearest to place x, y of the image (pixels from its upper left corner; the
   first pixel's centre is 0.5, 0.5), at most `reach` pixels away; of several there that with the least depth.
   False: there is none, or surfaces hide it. No allocation. */
YLM_API bool ylm_shade_lamp_at(const ylm_shade_view *view, const ylm_scene_lamps *lamps, double x,
                               double y, double reach, ylm_shade_lamp *found);

#define YLM_SHADE_DISC 12

/* Spheres as ylm_shade_draw_lamps draws them, the farthest first. A row has the direction to a
   sphere [3], its depth, the chord of half the angle it fills, and its radiance [3]. The box x0,
   x1, y0, y1 of its pixels (x0 <= x < x1) ends the row. disc
   [lamps->shape.spheres][YLM_SHADE_DISC]; *n: how many are in sight. */
YLM_API ylm_status ylm_shade_view_discs(const ylm_shade_view *view, const ylm_scene_lamps *lamps,
                                        double *disc, size_t *n);

/* -- bodies that move: bodies.c -------------------------------------------- */

/* A body at its place. A point p of the body's frame is at + scale rotation p. */
typedef struct ylm_shade_body {
  const ylm_shade_view *view; /* of the body alone, in its frame: options.all_vertices, matte, with
                                 transfer vectors, which know the body alone                   */
  double at[3], rotation[9], scale;
  const float *radiance; /* [points of view][3], for ylm_shade_draw_bodies                     */
} ylm_shade_body;

/*
** ylm_shade_body_field - radiance of a body's vertices where it stands: its transfer vectors, turned, times light there.
**
**   light  in   light without the body's own shadow (ylm_light_shadowed_without), asked for values at lmax of the
**               body's view, 3 channels, float
**   out    out  [points of the body's view][3]
**
** Returns  YLM_OK; YLM_EINVAL (the view is not such a one), YLM_EDOMAIN (its place), as ylm_shade_field
** Source   Sloan et al. 2002; Zhou et al. 2005
*/
YLM_API ylm_status ylm_shade_body_field(const ylm_shade_body *body, const ylm_field *light,
                                        int threads, const ylm_progress *progress, float *out,
                                        uint64_t *pairs, ylm_error *e);

/*
** ylm_shade_draw_bodies - draw bodies over an image of the view, by the camera rays that it was made with.
**
** A sample that meets a body covers its share of the pixel, less the part of the pixel that shows nearer surfaces of the
** view. Lamps of the view are behind bodies. Radiance is interpolated over triangles.
**
**   out   in/out  [height][width][3]
**   rays  out     that were traced, may be NULL
**
** Returns  YLM_OK; YLM_EINVAL, YLM_EDOMAIN as ylm_shade_body_field; YLM_ENOMEM
*/
YLM_API ylm_status ylm_shade_draw_bodies(const ylm_shade_view *view, size_t n,
                                         const ylm_shade_body *body, int threads, float *out,
                                         uint64_t *rays, ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
