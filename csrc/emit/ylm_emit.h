/*
** ylm_emit.h - virtual lights of a scene: particles of light, traced from its lamps and skies to surfaces.
**
** A particle carries a part of the lamps' power. Where it lands, a surface reflects a part of it: the
** landing becomes a virtual light, of an intensity along the normal that falls off as the cosine, and of surfaces
** that gloss as their slice of the arrival: fitted over the hemisphere, to a degree.
**
**   light      of lamps and skies as rays see them (ylm_scene.h). Lamps occlude nothing.
**   surfaces   that occlude. Both sides of a triangle reflect. With degree 0 those that gloss are matte ones of
**              their mean albedo.
**   normals    of vertices, unless these look away from where the particle came from: then of the
**              triangle, and counted
**   numbers    a particle keeps its random numbers whatever moves, and however many there are
**
** Ownership   ylm_emit_free frees what ylm_emit fills.
** Threads     results do not depend on their number, bit for bit.
** Source      Keller 1997, "Instant Radiosity"; Mezieres & Paulin 2022, "Harmonics Virtual Lights"
*/
#ifndef YLM_EMIT_H
#define YLM_EMIT_H

#include "ylm_scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_light_virtual ylm_light_virtual; /* ylm_light_virtual.h */

/* The most reflections of a particle; the most particles, and the most lights. */
#define YLM_EMIT_BOUNCES 64
#define YLM_EMIT_PARTICLES ((size_t)1 << 27)
/* The least number of lights that landings are merged into, where normals point to all sides. */
#define YLM_EMIT_LEAST_MERGED 6
/* The highest degree of an emission; the degree by materials. */
#define YLM_EMIT_DEGREE 8
#define YLM_EMIT_AUTO (-1)

/* The radius of a light. */
typedef enum ylm_emit_radius {
  YLM_EMIT_DENSITY, /* scale d/sqrt(10), d the distance to the tenth light whose normal is within 60
                       degrees, within d/2 of the tangent plane */
  YLM_EMIT_ANGLE,   /* scale d tan g, d the way of the particle, g half the angle of its share of
                       4 pi; of a grid sqrt(2) times the angle of a texel, opening over side: the
                       paper's, Eqs. 24-26 */
  YLM_EMIT_FIXED,   /* options.fixed, which scale does not change */
  YLM_EMIT_FOOTPRINT, /* of a grid: scale sqrt(A/pi), A the area that a texel's solid angle covers */
  YLM_EMIT_NEIGHBOURS /* of a grid: scale times the mean distance to the lights of the eight texels around,
                         weighed by 1/(difference of their ways from the lamp): the paper's, Eq. 23 */
} ylm_emit_radius;

typedef struct ylm_emit_options {
  size_t particles; /* 1 .. YLM_EMIT_PARTICLES */
  size_t lights; /* landings that are chosen by power, where there are more; 0: each is a light */
  int bounces;   /* 1 .. YLM_EMIT_BOUNCES: reflections of a particle, at most */
  int grid;      /* > 0: texels a side of a picture from each spot, with a ray through the middle
                       of each, reflected once; `particles` and `lights` do not count. 0: none */
  ylm_emit_radius radius;
  double fixed; /* scene units, > 0 */
  double scale; /* > 0 */
  int degree; /* of emission, 0 .. YLM_EMIT_DEGREE; YLM_EMIT_AUTO: 0 where no light is of a surface that glosses, else
                   the least of 2, 4, 8 whose slices at 45 degrees miss at most 14 %, 26 %, all */
  bool
      merge; /* all landings of a cell whose normals point to one side of a cube become one light; `lights`
                      bounds their number from above, 0 does not */
  double
      cell; /* the edge of these cells, scene units, whatever their number; 0: the least 2^(k/4) of which
                      there are no more than `lights` */
  bool conserve; /* emission is scaled, channel by channel, to the power that is reflected */
  uint64_t seed;
  int threads;
  const ylm_progress *progress; /* stages "particles", "merge", "radius" */
} ylm_emit_options;

/* Lights, in the order of their particles; merged ones in that of their cells. */
typedef struct ylm_emit_lights {
  size_t n;
  double *at, *normal; /* [n][3] scene units; length 1 */
  double *radius;      /* [n]    scene units */
  double *intensity;   /* [n][3] W/sr along the normal, of matte surfaces of that power */
  double *shift;       /* [n]    of merged lights (ylm_light_virtual.h); NULL: 0 */
  int degree;          /* of emission */
  double *
      emission; /* [n][3][(degree+1)^2] W/sr without the cosine, in world axes; NULL of degree 0, where it is
                          sqrt(4 pi) intensity */
} ylm_emit_lights;

/* Powers in W: of particles that set out; at their first landings; of those that left the scene before
   one; reflected at all landings. emitted = landed + lost. */
typedef struct ylm_emit_report {
  uint64_t particles, rays;
  uint64_t landings[YLM_EMIT_BOUNCES]; /* by reflection, the first is direct light's */
  double emitted[3], landed[3], lost[3], reflected[3];
  double going[3];   /* W: still under way behind the last reflection that was asked for */
  uint64_t turned;   /* landings with the normal of their triangle */
  uint64_t absorbed; /* directions that a normal of vertices sent below the triangle */
  uint64_t glossy;   /* landings on surfaces that gloss */
  int degree;        /* of the lights */
  double missed
      [2]; /* the error of slices over their norm, of lights of surfaces that gloss: root mean square by
                        power, largest */
  double below; /* power that they send below zero, over their power */
  uint64_t
      unscaled; /* lights that `conserve` left as they are: their slices keep less than a twentieth */
  double radius[3];  /* least, median, largest */
  uint64_t cut;      /* radii above four medians, which became that */
  uint64_t merged;   /* landings that merged lights stand for */
  double cell;       /* the edge of their cells */
  double seconds[4]; /* tracing, radii, emission, merging */
} ylm_emit_report;

/*
** ylm_emit - trace particles and make lights of where they land.
**
** A lamp is chosen in proportion to its luminous power, a place on it uniformly, a direction as the
** cosine: numbers of the sequence R5. Particles of a sky come from a disk as wide as the scene.
** Reflections behind the first survive with the chance min(0.95, luminance of the albedo).
**
** Of more landings than options.lights, some are chosen in proportion to their luminous power, by
** equal steps along its sum; each then has the same share of it.
**
** Merged lights stand at the mean place of their landings, by power, lifted along the normal above the highest of them
** and above the lowest of their tangent planes; their normal is the mean. Matte landings of one normal add up;
** of several normals, whose mean has the length R, the light has the shift 2 (1 - R) and with it their power and
** the mean of their directions. Emission of degree > 0 is fitted to what the landings send, in 98 directions, and
** scaled to their power. Radii by density are at least scale sqrt(2 v), v the mean square of distances from the
** middle.
**
** A grid is the paper's reflective shadow map: a texel of solid angle (2 tan(angle/2)/side)^2 cos^3 stands
** for the power intensity times that. Cones count as of 170 degrees at most.
**
** Returns  YLM_OK; YLM_ERANGE (an option); YLM_EINVAL (a grid, and lamps that are no spots, or none; merged);
**          YLM_ENOMEM, YLM_ECANCELLED. No lights where there are no
**          lamps, or nothing is met.
** Cost     a ray a landing and one that finds nothing; 68 bytes a landing; 0.6 us a light for density, 0.2 us a landing for merging
** Source   Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences" (R_d); Arvo &
**          Kirk 1990, "Particle Transport and Image Synthesis"
*/
YLM_API ylm_status ylm_emit(const ylm_scene *scene, const ylm_emit_options *o,
                            ylm_emit_lights *lights, ylm_emit_report *report, ylm_error *e);
YLM_API void ylm_emit_free(ylm_emit_lights *lights);

/* Virtual lights that surfaces of a scene hide. */
typedef struct ylm_emit_visible ylm_emit_visible;

/*
** ylm_emit_visible_create - the light field of virtual lights with their shadows.
**
**   scene    in   whose meshes occlude; outlives the field
**   lights   in   which the field shares
**
** A ray goes from each point to the middle of each light that does not show it its back. Lights that it reaches are
** summed, whole, with their derivatives: a shadow's edge is a step, which has none. Rays begin ylm_trace_offset
** from the point, and end as far before the light and a ten-thousandth of the way.
**
** Returns  YLM_OK; YLM_ENOMEM
** Cost     of a query: a ray and a pair for each point and light, and some 0.1 us to gather what a point sees
*/
YLM_API ylm_status ylm_emit_visible_create(const ylm_scene *scene, ylm_light_virtual *lights,
                                           ylm_emit_visible **visible, ylm_error *e);
/* NULL is fine. */
YLM_API void ylm_emit_visible_free(ylm_emit_visible *visible);
/* Its field, of quantity indirect, as long as it lives; queries as of the lights' own. */
YLM_API const ylm_field *ylm_emit_visible_field(const ylm_emit_visible *visible);

/*
** ylm_emit_write_ply - lights as points of a PLY file, for viewers and other programs.
**
** Properties are x y z, nx ny nz, red green blue (sRGB of the intensity, its largest is white), radius,
** intensity_red intensity_green intensity_blue, all but the colours float; x y z are double
** where the lights lie far from 0 (ylm_origin).
**
** Returns  YLM_OK, YLM_EIO
*/
YLM_API ylm_status ylm_emit_write_ply(const ylm_emit_lights *lights, const char *path,
                                      ylm_error *e);

#ifdef __cplusplus
}
#endif
#endif
