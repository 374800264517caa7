/* emit.h - what the files of csrc/emit share. Private. */
#ifndef YLM_EMIT_PRIVATE_H
#define YLM_EMIT_PRIVATE_H

#include <math.h>
#include <string.h>

#include "ylm_emit.h"
#include "ylm_vector.h"

#define EMIT_WIDEST (85 * YLM_PI / 180) /* half the opening of a grid */

/* -- sequence.c --------------------------------------------------------------------- */

#define EMIT_NUMBERS 5 /* of a particle's start: place, direction, lamp */

/* The sequence R_d, begun at random. */
typedef struct emit_sequence {
  uint64_t step[EMIT_NUMBERS], start[EMIT_NUMBERS]; /* of 2^64 */
} emit_sequence;

void ylm__emit_sequence(uint64_t seed, emit_sequence *s);
/* Its element i, from 0 below 1. */
void ylm__emit_numbers(const emit_sequence *s, uint64_t i, double u[EMIT_NUMBERS]);

/* -- lamps.c ------------------------------------------------------------------------ */

/* The lamps of a scene as sources of particles. */
typedef struct emit_lamps {
  const ylm_scene *scene;
  int side;            /* texels of a grid */
  size_t near, sky, n; /* up to: lamps, distant lights, spots */
  const ylm_light_spot *spot;
  double *upto;         /* [n] luminous power of a lamp and all before it, W */
  double (*record)[17]; /* [near] ylm_scene_lamp_record, then whether it is a sphere */
  double (*power)[3];   /* [near] of a particle from a sphere */
  double particles;
  double centre[3], reach; /* of the scene: particles of a sky come from a disk as wide */
} emit_lamps;

/* To be freed in any case; YLM_ENOMEM. */
ylm_status ylm__emit_lamps(const ylm_scene *scene, size_t particles, emit_lamps *l);
void ylm__emit_lamps_free(emit_lamps *l);
/* The ray of a particle with these numbers and the power [3] that it stands for, the sum of which is
   that of all lamps; false: it carries nothing. */
bool ylm__emit_start(const emit_lamps *l, const double u[EMIT_NUMBERS], ylm_trace_ray *ray,
                     double power[3]);

/* The ray through texel i of all grids, the power [3] that it stands for, and its solid angle; false: it is
   dark. */
bool ylm__emit_texel(const emit_lamps *l, size_t i, ylm_trace_ray *ray, double power[3],
                     double *solid);

/* Cosine and sine of t turns, 0 <= t <= 1, to 2e-16, without branches: Taylor's series within an eighth of a
   turn about the nearest quarter. */
static inline void ylm__emit_turn(double t, double *cosine, double *sine) {
  static const double sign[5][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 0}};
  int quarter = (int)(4 * t + 0.5);
  double x = 2 * YLM_PI * (t - 0.25 * quarter), y = x * x;
  double s = y * (-1.0 / 1307674368000), c = y * (1.0 / 20922789888000);
  s = y * (s + 1.0 / 6227020800), c = y * (c - 1.0 / 87178291200);
  s = y * (s - 1.0 / 39916800), c = y * (c + 1.0 / 479001600);
  s = y * (s + 1.0 / 362880), c = y * (c - 1.0 / 3628800);
  s = y * (s - 1.0 / 5040), c = y * (c + 1.0 / 40320);
  s = y * (s + 1.0 / 120), c = y * (c - 1.0 / 720);
  s = y * (s - 1.0 / 6), c = y * (c + 1.0 / 24);
  s = x + x * s, c = 1 + y * (c - 0.5);
  const double *q = sign[quarter];
  *cosine = q[0] * c - q[1] * s;
  *sine = q[1] * c + q[0] * s;
}

/* A direction about the axis, of length 1, with the density of the cosine. */
static inline void ylm__emit_cosine(const float axis[3], double u, double v, float out[3]) {
  float a[3], b[3];
  double r = sqrt(u), z = sqrt(1 - u), x, y;
  ylm__emit_turn(v, &x, &y);
  x *= r, y *= r;
  ylm_scene_basis(axis, a, b);
  for (int k = 0; k < 3; k++)
    out[k] = (float)(x * (double)a[k] + y * (double)b[k] + z * (double)axis[k]);
}

/* -- gloss.c ------------------------------------------------------------------------ */

#define EMIT_MATTE UINT32_MAX

/* The materials of a scene that gloss. */
typedef struct emit_gloss emit_gloss;

/* *out NULL where none does, or all count as matte; to be freed on failure too. YLM_ENOMEM, YLM_ECANCELLED */
ylm_status ylm__emit_gloss(const ylm_scene *scene, const ylm_emit_options *o, emit_gloss **out);
void ylm__emit_gloss_free(emit_gloss *g);
/* The number of a mesh's material. */
uint32_t ylm__emit_slot(const emit_gloss *g, size_t mesh);
/* Axes of a surface at right angles to its normal, x along the tangent. */
void ylm__emit_frame(const ylm_scene_surface *s, float x[3], float y[3]);
/* The part of light from wo, in that frame, which is reflected: out [3]. */
void ylm__emit_reflectance(const emit_gloss *g, uint32_t slot, const float wo[3], float out[3]);
/* A direction that light from wo takes on, and f cos over its density; false: it is absorbed. */
bool ylm__emit_sample(const emit_gloss *g, uint32_t slot, const float wo[3], const float u[3],
                      float wi[3], float weight[3]);

/* -- particles.c -------------------------------------------------------------------- */

/* Where a particle was reflected. */
typedef struct emit_landing {
  float at[3], normal[3];
  float from[3];  /* the direction to where it came from */
  float azimuth;  /* of that, from the tangent: of surfaces that gloss */
  float power[3]; /* reflected, W */
  float way;      /* from its last place */
  float area; /* of a grid: that its solid angle covers; of a merged one: that it is spread over */
  uint32_t particle;
  uint32_t slot; /* of its material that glosses, or EMIT_MATTE */
} emit_landing;

static inline double ylm__emit_luminous(const emit_landing *l) {
  double power[3] = {(double)l->power[0], (double)l->power[1], (double)l->power[2]};
  return ylm_luminance_size(power);
}

/* Landings that reflect something. */
typedef struct emit_landings {
  size_t n;
  emit_landing *landing; /* in the order of particles, and of a particle's reflections */
} emit_landings;

ylm_status ylm__emit_trace(const ylm_scene *scene, const emit_gloss *g, const ylm_emit_options *o,
                           emit_landings *out, ylm_emit_report *report);
/* gloss.c: chooses the degree of lights, and fills their emission where it is above 0. */
ylm_status ylm__emit_emission(const emit_gloss *g, const emit_landing *landing,
                              const ylm_emit_options *o, ylm_emit_lights *lights,
                              ylm_emit_report *report, ylm_error *e);

/* -- neighbours.c ------------------------------------------------------------------- */

/* radius [n] of each landing: scale d/sqrt(k), d the distance to the k-th neighbour of its surface, k = 10
   or as many as there are; 0: there are none. Neighbours have normals within 60 degrees, and are within d/2
   of the tangent plane. */
ylm_status ylm__emit_density(size_t n, const emit_landing *landing, const ylm_emit_options *o,
                             double *radius);

/* -- merge.c ------------------------------------------------------------------------ */

/* Merges landings, of which there are some: x becomes those of the merged lights, `area` the one that they are spread
   over. Fills all of `lights` but radii. parts: the landings as lights, with their emission, or NULL. */
ylm_status ylm__emit_merge(const ylm_emit_options *o, const ylm_emit_lights *parts,
                           emit_landings *x, ylm_emit_lights *lights, double *edge);

/* -- radius.c ----------------------------------------------------------------------- */

/* Fills lights->radius; the landings are those of the lights. */
ylm_status ylm__emit_radii(const ylm_scene *scene, const emit_landing *landing,
                           const ylm_emit_options *o, ylm_emit_lights *lights,
                           ylm_emit_report *report);

#endif
