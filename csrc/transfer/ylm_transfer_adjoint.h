/*
** ylm_transfer_adjoint.h - light as a function of its lamps: values at receivers, and their derivatives.
**
**   ylm_receivers  places that are no elements, with links of their own: planes of desks, points
**   ylm_lamplight  direct light of each of a few lamps at each place, with derivatives by the lamp
**   ylm_transpose  the links of a transfer backwards: importance, the bounces of derivatives
**
** With g the derivatives of a number J by the irradiance at receivers, one solution for all lamps gives
**
**   (I - rho M^T) lambda = rho Q^T g + h,      dJ/dp = sum_r g_r dF0_r/dp + sum_i lambda_i dE0_i/dp
**
** M the links of elements, Q those of receivers, h the derivatives of J by the irradiance of elements, E0 and F0 direct light.
**
** Occluders stand still in the directions of a place when a lamp moves: its shadow changes at the rim of the lamp alone. With V the
** visibility, V' its mean over the lamp and E' the light without shadows
**
**   dE/dp = V' dE'/dp + integral over the lamp (V - V') df/dp + integral over its rim (V - V') f v
**
** f radiance times cosine, its derivative that in a fixed direction, v the speed of the rim.
**
** Source  Smits, Arvo, Salesin 1992, "An Importance-driven Radiosity Algorithm"; docs/math.md "Derivatives by the lamp"
*/
#ifndef YLM_TRANSFER_ADJOINT_H
#define YLM_TRANSFER_ADJOINT_H

#include "ylm_light_photometry.h"
#include "ylm_transfer.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- receivers: csrc/transfer/adjoint/receivers.c ------------------------------------------------- */

typedef struct ylm_receivers ylm_receivers;

/*
** ylm_receivers_create - places, and what they see of the elements.
**
**   point, normal  in  [n][3]  relative to the scene's origin; unit normals. Points on surfaces are taken off them
**   links          in  of a place, 4 .. YLM_TRANSFER_LINKS, a multiple of 4
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EDOMAIN (numbers that are not finite, long normals), YLM_ENOMEM,
**          YLM_ECANCELLED (stage "links")
*/
YLM_API ylm_status ylm_receivers_create(const ylm_transfer *t, size_t n, const float (*point)[3],
                                        const float (*normal)[3], int links, uint64_t seed,
                                        int threads, const ylm_progress *progress,
                                        ylm_receivers **out, ylm_error *e);
YLM_API void ylm_receivers_free(ylm_receivers *r);
YLM_API const ylm_transfer *ylm_receivers_transfer(const ylm_receivers *r);
YLM_API size_t ylm_receivers_count(const ylm_receivers *r);
YLM_API int ylm_receivers_links(const ylm_receivers *r);
/* [n] the part of each place's rays that does not begin inside of a body. */
YLM_API const float *ylm_receivers_share(const ylm_receivers *r);
/* Irradiance out [n][3] that the elements of a radiosity send. YLM_OK; YLM_EINVAL (of another transfer), YLM_ENOMEM */
YLM_API ylm_status ylm_receivers_indirect(const ylm_receivers *r, const ylm_radiosity *lit,
                                          int threads, float (*out)[3], ylm_error *e);
/* Direct irradiance out [n][3] by rays to the lamps and the sky of a scene of the same meshes.
   YLM_OK; YLM_EINVAL, YLM_ERANGE, YLM_ENOMEM, YLM_ECANCELLED (stage "direct") */
YLM_API ylm_status ylm_receivers_rays(const ylm_receivers *r, const ylm_scene *scene,
                                      int light_samples, uint64_t seed, int threads,
                                      const ylm_progress *progress, float (*out)[3], ylm_error *e);
/* out [elements][3] = Q^T weight [n][3]: what a unit of light that leaves an element is worth. */
YLM_API void ylm_receivers_scatter(const ylm_receivers *r, const double (*weight)[3],
                                   double (*out)[3]);

/* -- lamps one by one: csrc/transfer/adjoint/lamplight.c ------------------------------------------- */

typedef enum ylm_lamp_shape {
  YLM_LAMP_point,
  YLM_LAMP_sphere,
  YLM_LAMP_disk,
  YLM_LAMP_rectangle,
  YLM_LAMP_polygon,
  YLM_LAMP_sun /* a disc infinitely far away */
} ylm_lamp_shape;

/* A corner of a polygon, from its middle along `across` and at right angles to that; area and rim are filled in by
   ylm_lamplight_create: those up to it. */
typedef struct ylm_lamp_corner {
  double place[2];
  double area, rim;
} ylm_lamp_corner;

/* A lamp that derivatives are known of. */
typedef struct ylm_lamp {
  ylm_lamp_shape shape;
  double at[3];              /* its middle */
  double axis[3], across[3]; /* across: C0; unit, perpendicular; axis of a sun: towards it */
  double half
      [2]; /* of the opening along C0 and C90; a radius twice; of polygons 1; of suns the sine of
                                        half the angle, below 1 */
  double
      scale[3]; /* multiplies intensities, by channel; of suns the irradiance of what faces them */
  const ylm_light_photometry *table; /* NULL: these intensities, in all directions or .. */
  double power;                      /* .. times |cos|^power of the angle to the axis, or .. */
  double cone[2];                    /* .. a smooth step between two cosines of it; equal: none */
  size_t corners;
  const ylm_lamp_corner *corner; /* of a convex polygon, in order */
} ylm_lamp;

typedef struct ylm_lamplight_form {
  int light_samples; /* rays of a place to each lamp, 4 .. YLM_TRANSFER_LINKS, even */
  int rim;           /* rays to its rim where these disagree, even; 0: shadows are held */
  uint64_t seed;
  size_t bytes; /* of records at most; 0: YLM_LAMPLIGHT_BYTES */
  int threads;
  const ylm_progress *progress; /* stage "direct" */
} ylm_lamplight_form;

typedef struct ylm_lamplight_stats {
  uint64_t rays, rim_rays;
  uint64_t pairs, partly; /* pairs of place and lamp with light; of these those partly in shadow */
  size_t bytes;
  bool again; /* records of all places were too many: derivatives trace their rays again */
  double seconds;
} ylm_lamplight_stats;

typedef struct ylm_lamplight ylm_lamplight;

/* The most bytes of records that are kept: of more, derivatives trace the same rays again. */
#define YLM_LAMPLIGHT_BYTES ((size_t)1 << 30)

/*
** ylm_lamplight_create - direct light of each lamp at each element, or at each receiver.
**
** Rays of an element start all over it. With one seed they go to the same places of a lamp, wherever it stands.
**
**   receivers  in  NULL: the elements of t. Both are to live as long as what is made
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EINVAL (no lamp, a shape), YLM_EDOMAIN (a number that is not finite), YLM_ENOMEM,
**          YLM_ECANCELLED
** Cost     places * lamps * light_samples rays at most; 64 bytes a place and lamp, as many as are kept
*/
YLM_API ylm_status ylm_lamplight_create(const ylm_transfer *t, const ylm_receivers *receivers,
                                        size_t lamps, const ylm_lamp *lamp,
                                        const ylm_lamplight_form *form, ylm_lamplight **out,
                                        ylm_error *e);
YLM_API void ylm_lamplight_free(ylm_lamplight *l);
YLM_API size_t ylm_lamplight_places(const ylm_lamplight *l);
YLM_API size_t ylm_lamplight_lamps(const ylm_lamplight *l);
YLM_API void ylm_lamplight_look(const ylm_lamplight *l, ylm_lamplight_stats *stats);
/* Irradiance out [places][3] of all lamps. */
YLM_API void ylm_lamplight_direct(const ylm_lamplight *l, float (*out)[3]);

/* Numbers of a lamp in ylm_lamplight_weigh: derivatives by its scale, its place, a turn of it (radians about x, y, z), the half
   sizes of its opening; the standard errors of that by all of scale at once, relative, by place, and by turn. */
enum {
  YLM_LAMPLIGHT_SCALE = 0,
  YLM_LAMPLIGHT_PLACE = 3,
  YLM_LAMPLIGHT_TURN = 6,
  YLM_LAMPLIGHT_SIZE = 9,
  YLM_LAMPLIGHT_NOISE = 11,
  YLM_LAMPLIGHT_NUMBERS = 18
};

/* Derivatives out [lamps][YLM_LAMPLIGHT_NUMBERS] of the sum of weight [places][3] times direct light. With one block of records
   or with many the bits are the same. */
YLM_API ylm_status ylm_lamplight_weigh(ylm_lamplight *l, const double (*weight)[3], int threads,
                                       double *out);

/* -- importance: csrc/transfer/adjoint/importance.c ------------------------------------------------ */

typedef struct ylm_transpose ylm_transpose;

/* The links of a transfer, by the element that they lead to. YLM_OK; YLM_ENOMEM. Memory: 4 bytes a link */
YLM_API ylm_status ylm_transpose_create(const ylm_transfer *t, ylm_transpose **out);
YLM_API void ylm_transpose_free(ylm_transpose *x);

/*
** ylm_transpose_importance - what direct light on each element is worth, with as many bounces as a radiosity has, and its closure.
**
**   leaving  in   [elements][3]  Q^T g
**   falling  in   [elements][3]  h; NULL: zeros
**   out      out  [elements][3]  lambda
**
** Returns  YLM_OK; YLM_EINVAL (another transfer), YLM_ENOMEM. Cost: as many reads of links as the solution's
*/
YLM_API ylm_status ylm_transpose_importance(const ylm_transpose *x, const ylm_radiosity *lit,
                                            const double (*leaving)[3], const double (*falling)[3],
                                            int threads, double (*out)[3], ylm_error *e);
/* dJ/drho out [elements][3] = E (M^T lambda + Q^T g), of an importance: one more read of the links. */
YLM_API ylm_status ylm_transpose_albedo(const ylm_transpose *x, const ylm_radiosity *lit,
                                        const double (*leaving)[3], const double (*importance)[3],
                                        int threads, double (*out)[3], ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
