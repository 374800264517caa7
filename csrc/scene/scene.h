/* scene.h - what the files of csrc/scene share. Private. */
#ifndef YLM_SCENE_PRIVATE_H
#define YLM_SCENE_PRIVATE_H

#include <stdatomic.h>

#include "calibration.h"
#include "dome.h"
#include "tree.h"
#include "ylm_scene.h"
#include "ylm_vector.h"

typedef struct ylm_light_cone ylm_light_cone; /* ylm_light.h */

/* How far rays start off a triangle, and which part of the way to its middle off its edges. */
typedef struct scene_off {
  float lift, pull;
} scene_off;

/* A mesh as copied: `smooth` where it came with normals; else they are means over triangles, for
   shading per vertex alone. */
typedef struct scene_mesh {
  float *position, *normal; /* [vertices][3] */
  float *uv;                /* [vertices][2] or NULL */
  scene_off *off;           /* [count]       */
  uint32_t *around;   /* [vertices] of its triangles the one with the most lift; UINT32_MAX: none */
  uint32_t *triangle; /* [count][3]    */
  size_t vertices, count, first_vertex;
  bool smooth, occludes;
  const ylm_material *material;
  float *colour; /* [vertices][3] or NULL */
  const ylm_texture *texture;
} scene_mesh;

/* Meshes as scenes that differ in lamps alone share them. */
typedef struct scene_meshes {
  atomic_uint references;
  scene_mesh *mesh;
  size_t meshes, vertices;
} scene_meshes;

/* A texture as copied. */
typedef struct scene_texture {
  double corner[3], across[3], up[3]; /* s = across.(p - corner) from 0 to 1, upwards by up */
  size_t width, height;
  float *texel;         /* [height][width][3], times the scale */
  size_t first, behind; /* its triangles: first .. behind-1 */
} scene_texture;

/* A triangle as it is seen from afar. */
typedef struct scene_far {
  double centre[3], across[3]; /* the normal, as long as the area */
  double area, reach2;         /* from this distance on, squared, it counts as far */
} scene_far;

struct ylm_scene {
  double origin[3]; /* of all positions */
  ylm_trace *trace;
  scene_meshes *shared;
  const scene_mesh *mesh;  /* [meshes] of `shared` */
  size_t meshes, vertices; /* of `shared` */
  size_t lamps;
  float *lamp[4]; /* x, y, z, radius: each [lamps], padded to a multiple of YLM_LAMP_CHUNK */
  float *lamp_luminance;
  float *lamp_radiance;    /* [lamps + triangles + disks][3] */
  size_t triangles, disks; /* of flat lights: "patches", triangles first */
  float *triangle, *disk;  /* [triangles][9], [disks][7] */
  float *patch_luminance;  /* [triangles + disks] */
  scene_far *far;          /* [triangles] */
  float *horizon;          /* [triangles + disks][3] or NULL */
  size_t textures;
  scene_texture *texture; /* in the order of their triangles */
  ylm_light_set *sky;     /* distant lights; NULL: none */
  bool sky_is_seen;
  size_t domes, cones, sky_lights;
  scene_dome *dome;     /* [domes] those that fill the sky */
  ylm_light_cone *cone; /* [cones] the others */
  float *sky_bound[6];  /* [sky_lights] mean x, y, z, spread, 1/(4 spread), power */
  size_t spots;
  ylm_light_spot *spot;
  scene_tree *tree; /* of lamps; NULL: they are weighed one by one */
};

/* -- tint.c --------------------------------------------------------------------- */

/* Copies colours and keeps the texture of mesh i; YLM_EINVAL, YLM_EDOMAIN, YLM_ENOMEM. */
ylm_status ylm__scene_copy_tint(scene_mesh *m, size_t i, const ylm_scene_mesh *in, ylm_error *e);
void ylm__scene_free_tint(scene_mesh *m);
/* The tint at a place on a triangle, by the weights of its corners. */
void ylm__scene_tint(const scene_mesh *m, const uint32_t corner[3], const float weight[3],
                     float tint[3]);

/* -- weights.c ------------------------------------------------------------------ */

/* w[j]: bound of the unshadowed luminous irradiance, over pi, at x with normal n from lamp j;
   sum[b]: over chunk b of YLM_LAMP_CHUNK lamps. Arrays are padded with lamps of luminance 0. */
typedef void ylm_scene_weights_fn(size_t chunks, float *const lamp[4], const float *luminance,
                                  const float x[3], const float n[3], float *w, float *sum);

/* The kernel of the instruction set in use. */
ylm_scene_weights_fn *ylm__scene_weights(void);
/* The bound of one lamp at v with radius r, for luminance 1; n NULL: of the scalar irradiance of a
   point in space. */
double ylm__scene_weight(const double v[3], double r, const float n[3]);

/* -- patch.c ------------------------------------------------------------------ */

/* A bound of about the unshadowed irradiance over pi of patch i for luminance 1, above 0 wherever it
   brings light; n NULL: of the scalar irradiance of a point in space. *solid: the solid angle, if it
   had to be known; else 0. */
double ylm__scene_patch_weight(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                               double *solid);

/* For each patch its luminance times about its unshadowed irradiance over pi, above 0 wherever it
   brings light. `sum`: over chunks. n NULL: the scalar irradiance of a point in space. */
void ylm__scene_patch_weights(const ylm_scene *s, const float x[3], const float n[3], float *weight,
                              float *sum, double *solid);
/* A ray from x to a random place on patch i. The place is uniform in the solid angle of triangles
   that fill much of it (Arvo 1995), else in area. *radiance: the radiance there. Returns the
   irradiance that the ray brings for radiance 1; n NULL: the scalar irradiance of a point in
   space. */
double ylm__scene_patch_sample(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                               double u0, double u1, double solid, ylm_trace_ray *ray,
                               const float **radiance);

/* For choosers of one lamp these take less time: triangles that are far count as if they were at
   their centre, and rays to them are uniform in area. */
ylm_status ylm__scene_make_far(ylm_scene *s);
void ylm__scene_patch_weights_of_one(const ylm_scene *s, const float x[3], const float n[3],
                                     float *weight, float *sum, double *solid);
double ylm__scene_patch_sample_one(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                                   double u0, double u1, double solid, ylm_trace_ray *ray,
                                   const float **radiance);
/* The density per solid angle of these rays, sr^-1, in a direction of length 1 that meets patch i;
   0: it does not. */
double ylm__scene_patch_density(const ylm_scene *s, size_t i, const float x[3], double solid,
                                const float d[3]);

/* -- sky.c --------------------------------------------------------------------- */

/* Shares the distant lights of the lamps, and what `from` (or NULL) knows of them; to be freed in any
   case. */
ylm_status ylm__scene_share_sky(ylm_scene *s, const ylm_scene_lamps *l, const ylm_scene *from);
void ylm__scene_free_sky(ylm_scene *s);
/* Distant lights: tiles of domes, or uniform domes, then cones. */
static inline size_t ylm__scene_sky_lights(const ylm_scene *s) { return s->sky_lights; }
/* As ylm__scene_patch_weights, of distant lights. */
void ylm__scene_sky_weights(const ylm_scene *s, const float *n, float *weight, float *sum);
/* A ray from x to distant light i, the radiance there and the irradiance that it brings for radiance 1. Points in space (n
   NULL) have the scalar one. */
double ylm__scene_sky_sample(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                             double u0, double u1, ylm_trace_ray *ray, float radiance[3]);
/* The density of those rays, sr^-1, in a direction of length 1. */
double ylm__scene_sky_density(const ylm_scene *s, size_t i, const float *n, const float d[3]);

/* -- spot.c --------------------------------------------------------------------- */

/* Copies the spots of the lamps; to be freed in any case. */
ylm_status ylm__scene_copy_spots(ylm_scene *s, const ylm_scene_lamps *l);
/* As ylm__scene_sky_weights, of spots seen from x. */
void ylm__scene_spot_weights(const ylm_scene *s, const float x[3], const float *n, float *weight,
                             float *sum);
/* As ylm__scene_sky_sample, of the ray to spot i. */
double ylm__scene_spot_sample(const ylm_scene *s, size_t i, const float x[3], const float *n,
                              ylm_trace_ray *ray, float radiance[3]);

/* -- lamps.c -------------------------------------------------------------------- */

struct ylm_scene_chooser {
  const ylm_scene *scene;
  /* chunks of all lamps; of spheres; of spheres and patches: those of a tree are in none */
  size_t chunks, spheres, near, sky; /* of all these and distant lights; spots follow */
  ylm_scene_weights_fn *weights;
  float *weight, *sum; /* [chunks*YLM_LAMP_CHUNK], [chunks]: spheres, patches, the sky */
  double *solid;       /* [patches] solid angles that are known, else 0; NULL: none is */
  /* what ylm_scene_choose was told last */
  float x[3], normal[3];
  bool in_space;
  double
      total; /* of the sums, and of the tree of lamps: lamps of a tree come before distant lights */
  ylm_scene_nodes_fn *nodes;
  ylm_scene_spheres_fn *aim_at_spheres;
  scene_cut *cut; /* of the tree, as it is seen from x; NULL: there is none */
};

/* Turns a chooser to x; `normal` may be NULL. */
void ylm__scene_turn_to(ylm_scene_chooser *c, const float x[3], const float *normal);
/* Weighs the tree of lamps, if there is one, for so many samples, and distant lights; returns the total with all chunks. */
double ylm__scene_add_weights(ylm_scene_chooser *c, int light_samples);
/* The weight of the tree of lamps. */
static inline double ylm__scene_tree_weight(const ylm_scene_chooser *c) {
  return c->cut->n > 0 ? c->cut->open[0].upto[SCENE_WIDTH - 1] * c->scene->tree->unit : 0;
}

/* A place in the list of lamps as strata walk along the sum of weights. */
typedef struct scene_walk {
  size_t chunk, lamp;
  double passed; /* weight of all lamps before `lamp` */
} scene_walk;

/* The lamp at a place in the chooser's weights. */
uint32_t ylm__scene_lamp_at(const ylm_scene_chooser *c, size_t place);
/* The solid angle of patch i, if it is known; else 0. */
static inline double ylm__scene_solid(const ylm_scene_chooser *c, size_t i) {
  return c->solid ? c->solid[i] : 0;
}
/* Moves on to the lamp that holds `target`; targets increase. */
void ylm__scene_walk_to(scene_walk *w, const ylm_scene_chooser *c, double target);

/* A direction about the axis: cosine z, azimuth u of 0 .. 1. */
void ylm__scene_turn(const float axis[3], double z, double u, float out[3]);

/* A ray from x to a random place of sphere i and the irradiance that it brings for radiance 1. Points in space (n NULL)
   have the scalar one. */
double ylm__scene_sphere_sample(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                                double u0, double u1, ylm_trace_ray *ray);
/* The density of those rays, sr^-1, in a direction of length 1 that meets sphere i. */
double ylm__scene_sphere_density(const ylm_scene *s, size_t i, const float x[3], const float n[3],
                                 const float d[3]);

/* -- texture.c ---------------------------------------------------------------- */

/* Copies textures; their triangles are the last of s->triangles. */
ylm_status ylm__scene_copy_textures(ylm_scene *s, const ylm_scene_lamps *l, ylm_error *e);
void ylm__scene_free_textures(ylm_scene *s);
/* The radiance of patch i at the place p on it, [3]. */
const float *ylm__scene_patch_radiance(const ylm_scene *s, size_t i, const double p[3]);

#endif
