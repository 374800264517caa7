/*
** ylm_light_emitter.h - lights as rays and particles meet them, for scenes.
**
** An emitter is one light as a plain value: its kind, and numbers that the kind alone knows. It may be copied,
** and moved; it refers to no set. Behind its numbers may be the address of a table, which lives as long as the
** set, or as ylm_light_emitter_keep says. Lamps of a scene are emitters, whatever arrays they stand in.
**
**   where from                                           asked for
**   ylm_light_set_emitter    a set's lights of no size   power, place, light at a point, particles, intensity
**   ylm_light_emitter_sphere, _triangle, _disk, _cone    power, place, particles; records for light fields
**   ylm_light_surfaces       lamps that send different radiance in different directions
**
** Light from infinity is a cone, or a dome: light that fills the sky, as one thing to be sampled. A set has
** a dome for each panorama, and one for all environments that were packed together.
**
** The light field of an environment is a sum of harmonics (csrc/light/environment.c). A panorama
** is what rays see of one that is more than that: an image of the whole sphere, or a sky of the CIE.
*/
#ifndef YLM_LIGHT_EMITTER_H
#define YLM_LIGHT_EMITTER_H

#include "ylm_base.h"
#include "ylm_image.h"
#include "ylm_light.h"

#ifdef __cplusplus
extern "C" {
#endif

/* -- emitters: csrc/light/emitter.c ------------------------------------------------------------ */

#define YLM_LIGHT_EMITTER_NUMBERS 20

typedef struct ylm_light_emitter {
  const struct ylm__light_kind *kind;
  size_t numbers;
  double x[YLM_LIGHT_EMITTER_NUMBERS];
} ylm_light_emitter;

/* Where an emitter is. `bright` is its luminous intensity where that is largest, W/sr; of distant ones luminous
   irradiance, W m^-2. Light of emitters without a size goes where the cosine to the axis is above `outer`. */
typedef struct ylm_light_place {
  double at[3]; /* its middle, scene units */
  double reach; /* no part of it is farther from there; 0: it has no size, and no ray meets it */
  double normal[3]; /* of flat ones, of length 1; else 0 */
  double axis[3], outer;
  double bright;
} ylm_light_place;

/* Light on its way to a point. */
typedef struct ylm_light_way {
  double at[3];           /* where it comes from */
  double to[3], distance; /* of length 1, towards that place */
  double radiance[3];     /* W sr^-1 m^-2 */
  double solid;           /* the solid angle that the light seems to fill, sr */
} ylm_light_way;

/* A particle that leaves: from a place, in a direction about an axis. */
typedef struct ylm_light_leaving {
  double at[3], axis[3];
  double cosine, sine, turn; /* to the axis; around it, 0 .. 1 */
  double light[3];           /* radiance, W sr^-1 m^-2, or intensity, W sr^-1 */
  double extent;             /* times it, the power that the particle stands for: m^2 sr, or sr */
  bool flat; /* the light may lie on a surface, which is not in the particle's way */
} ylm_light_leaving;

/* Emitter i of a set, of those lights that are neither surfaces nor light from infinity; false: there are no more. */
YLM_API bool ylm_light_set_emitter(const ylm_light_set *set, size_t i, ylm_light_emitter *out);
/* A sphere: radiance [3], its middle [3] and radius. */
YLM_API void ylm_light_emitter_sphere(const float radiance[3], const double at[3], double radius,
                                      ylm_light_emitter *out);
/* A triangle of corners [3][3], or a disk of a middle and two half axes [3][3], of this radiance to both sides; what is
   below the plane across `horizon` (NULL: none) through a point brings no light there. */
YLM_API void ylm_light_emitter_triangle(const float radiance[3], const float *horizon,
                                        const double corner[9], ylm_light_emitter *out);
YLM_API void ylm_light_emitter_disk(const float radiance[3], const float *horizon,
                                    const double middle_and_axes[9], ylm_light_emitter *out);

/* Moves it. */
YLM_API void ylm_light_emitter_move(ylm_light_emitter *e, const double way[3]);
/* Its luminous power, W. */
YLM_API double ylm_light_emitter_power(const ylm_light_emitter *e);
/* Where it is; false: infinitely far away, and `bright` is all that out says. */
YLM_API bool ylm_light_emitter_place(const ylm_light_emitter *e, ylm_light_place *out);
/* Of an emitter without a size: its light at `from`; false: none comes there. */
YLM_API bool ylm_light_emitter_toward(const ylm_light_emitter *e, const double from[3],
                                      ylm_light_way *out);
/* Of an emitter without a size: luminous irradiance at `from` on a surface with this normal; NULL: the scalar one of a point
   in space. */
YLM_API double ylm_light_emitter_weight(const ylm_light_emitter *e, const double from[3],
                                        const float *normal);
/* Of an emitter without a size: the intensity [3], W/sr, along `way`, of length 1. */
YLM_API void ylm_light_emitter_intensity(const ylm_light_emitter *e, const double way[3],
                                         double out[3]);
/* Of a lamp that is `directed`: the part of the radiance of its row that it sends about to a place; it may be above 1. */
YLM_API double ylm_light_emitter_part(const ylm_light_emitter *e, const double from[3]);
/* The table that it refers to lives until it is let go. */
YLM_API void ylm_light_emitter_keep(const ylm_light_emitter *e);
YLM_API void ylm_light_emitter_drop(const ylm_light_emitter *e);
/* Of a lamp that is `directed`: the radiance [3] that it sends along `way`, of any length but 0. */
YLM_API void ylm_light_emitter_radiance(const ylm_light_emitter *e, const double way[3],
                                        double out[3]);
/* A particle for numbers u [4] from 0 below 1; false: it carries nothing. */
YLM_API bool ylm_light_emitter_leave(const ylm_light_emitter *e, const double u[4],
                                     ylm_light_leaving *out);

/* The record whose light field it has, dimmed by a part, to `to` [YLM_LIGHT_EMITTER_NUMBERS]: how many numbers; *kind: its
   name for ylm_light_set_create. Kinds have an order. */
YLM_API size_t ylm_light_emitter_record(const ylm_light_emitter *e, double part, double *to,
                                        const char **kind);
YLM_API size_t ylm_light_emitter_order(const ylm_light_emitter *e);
/* Why it has no light field, a sentence; NULL: it has one. */
YLM_API const char *ylm_light_emitter_fieldless(const ylm_light_emitter *e);

/* -- what rays see: csrc/light/surfaces.c ------------------------------------------------------ */

/* A texture on triangles, the last ones of surfaces; pointers live as long as the set. */
typedef struct ylm_light_image {
  double corner[3], u[3], v[3]; /* its bottom left, to its bottom right, to its top left */
  size_t width, height;
  const float *texel; /* [height][width][3], the top row first */
  double scale;       /* multiplies it */
  size_t triangles;   /* how many cover it */
} ylm_light_image;

/* The arrays of lamps that a directed one may stand in, in their order. */
typedef enum ylm_light_directed_shape {
  YLM_LIGHT_DIRECTED_SPHERE,
  YLM_LIGHT_DIRECTED_TRIANGLE,
  YLM_LIGHT_DIRECTED_DISK
} ylm_light_directed_shape;

/* Lamp i of a shape, whose radiance depends on the direction, as `emitter` says: its row has the one that it is
   weighed by. */
typedef struct ylm_light_directed {
  ylm_light_directed_shape shape;
  size_t i;
  ylm_light_emitter emitter;
} ylm_light_directed;

/* Surfaces that emit, spheres in the order of the set; of flat ones first triangles, then disks.
   Radiances in W sr^-1 m^-2; a horizon of 0 cuts nothing off. */
typedef struct ylm_light_surfaces {
  size_t spheres, triangles, disks, images;
  ylm_light *sphere;         /* [spheres] */
  double *triangle, *disk;   /* [triangles][9] corners; [disks][7] centre, radius, normal */
  double *triangle_emission; /* [triangles][6] radiance, horizon */
  double *disk_emission;     /* [disks][6] */
  ylm_light_image *image;    /* [images], in the order of their triangles */
  size_t directions;
  ylm_light_directed *directed; /* [directions], each shape in order */
  size_t tiles;                 /* an image is covered by, a side */
} ylm_light_surfaces;

/* To be freed with ylm_light_surfaces_free in any case; images are covered by at most `tiles` tiles
   a side. YLM_ENOMEM. */
YLM_API ylm_status ylm_light_set_surfaces(const ylm_light_set *set, size_t tiles,
                                          ylm_light_surfaces *out);
YLM_API void ylm_light_surfaces_free(ylm_light_surfaces *s);

/* -- light from infinity: csrc/light/sky.c ------------------------------------------------------ */

/* Directions about an axis of length 1, with the cosine of half the angle; radiance all over it. */
typedef struct ylm_light_cone {
  double axis[3], cosine, radiance[3];
} ylm_light_cone;

/* Whether there are distant lights. */
YLM_API bool ylm_light_set_is_distant(const ylm_light_set *set);
/* The radiance that comes from infinity, from direction d of length 1: of lights that fill the sky,
   and with `cones` of all. */
YLM_API void ylm_light_set_sky(const ylm_light_set *set, const double d[3], bool cones,
                               double rgb[3]);
/* Cone i of the set; false where there are no more. */
YLM_API bool ylm_light_set_cone(const ylm_light_set *set, size_t i, ylm_light_cone *out);
YLM_API void ylm_light_emitter_cone(const ylm_light_cone *cone, ylm_light_emitter *out);

/* -- skies of the CIE: csrc/light/cie.c -------------------------------------------------------- */

/* Skies of the CIE: their names and the constants a, b, k, c, e of ylm_light_cie_luminance. */
#define YLM_LIGHT_CIE_LIST(X)                                                                      \
  X(overcast, 0, 0, 0, 0, 0)                                                                       \
  X(clear, 0.91, 10, -3, 0.45, -0.32)                                                              \
  X(partly_cloudy, 0.526, 5, -1.5, 0, -0.8)

typedef enum ylm_light_cie_kind {
#define X(name, a, b, k, c, e) YLM_LIGHT_CIE_##name,
  YLM_LIGHT_CIE_LIST(X)
#undef X
} ylm_light_cie_kind;

typedef struct ylm_light_cie {
  ylm_light_cie_kind kind;
  double zenith[3], sun[3]; /* of length 1; overcast skies know no sun */
  double luminance;         /* at the zenith */
} ylm_light_cie;

/*
** ylm_light_cie_luminance - the luminance of a sky in a direction d of length 1.
**
** With t the angle to the zenith, g that to the sun and s that between these,
**
**   overcast   (1 + 2 cos t)/3
**   others     (f(g) h(t)) / (f(s) h(0)),  f(g) = a + b exp(k g) + c cos^2 g,
**                                          h(t) = 1 - exp(e / cos t)
**
** times the luminance at the zenith; 0 below the horizon.
**
** Source  Green 2003, "Creating Light Sources" (cos t in 'partly cloudy', misprinted there)
*/
YLM_API double ylm_light_cie_luminance(const ylm_light_cie *sky, const double d[3]);

/* -- panoramas: csrc/light/panorama.c ---------------------------------------------------------- */

typedef struct ylm_light_panorama {
  int width, height;
  const float
      *texel; /* [height][width][3], the top row first; W sr^-1 m^-2. NULL: a sky of the CIE */
  ylm_mapping mapping;
  ylm_up up;
  ylm_light_cie cie;
  double scale; /* multiplies it */
} ylm_light_panorama;

/* Whether an image may be a panorama: YLM_ESHAPE (of another shape than its mapping's), YLM_EDOMAIN
   (a texel is negative or not finite); `e` names the pixel, counted from 1. */
YLM_API ylm_status ylm_light_panorama_check(const ylm_light_panorama *p, ylm_error *e);
/*
** ylm_light_set_panorama - a set of the environment that a panorama is.
**
**   p        in   texels are copied
**   n        in   number of records
**   record   in   [n]  of kind "environment": its coefficients, the scale included
**
** Returns  YLM_OK; as ylm_light_panorama_check, ylm_light_set_create
*/
YLM_API ylm_status ylm_light_set_panorama(const ylm_light_panorama *p, size_t n,
                                          const double *const *record, ylm_light_set **set,
                                          ylm_error *e);

/* -- domes: csrc/light/sky.c ------------------------------------------------------------------- */

typedef struct ylm_light_dome {
  const ylm_light_panorama *panorama; /* NULL: environments, whose coefficients are all */
  bool uniform;                       /* radiance is the same in every direction */
  const void *pack;
} ylm_light_dome;

/* Dome i of the set, as long as that lives; false where there are no more. */
YLM_API bool ylm_light_set_dome(const ylm_light_set *set, size_t i, ylm_light_dome *out);
/* The radiance that comes from direction d of length 1. */
YLM_API void ylm_light_dome_radiance(const ylm_light_dome *dome, const double d[3], double rgb[3]);

#ifdef __cplusplus
}
#endif
#endif
