/* scene.h - what the files of csrc/scene share. Private. */
#ifndef YLM_SCENE_PRIVATE_H
#define YLM_SCENE_PRIVATE_H

#include <stdatomic.h>

#include "calibration.h"
#include "dome.h"
#include "tree.h"
#include "ylm_scene.h"
#include "ylm_vector.h"

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

/* A lamp near by whose radiance depends on the direction. */
typedef struct scene_directed {
  size_t lamp;
  ylm_light_emitter emitter;
} scene_directed;

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
  size_t directions;
  scene_directed *directed; /* [directions] in order */
  ylm_light_set *sky;       /* distant lights; NULL: none */
  bool sky_is_seen;
  size_t domes, cones, sky_lights; /* tiles of domes, or uniform domes, then cones */
  scene_dome *dome;                /* [domes] those that fill the sky */
  ylm_light_cone *cone;            /* [cones] the others */
  float *sky_bound[6];             /* [sky_lights] mean x, y, z, spread, 1/(4 spread), power */
  size_t points;
  ylm_light_emitter *point; /* [points] lamps without a size */
  scene_tree *tree;         /* of lamps; NULL: they are weighed one by one */
};

/* -- tint.c --------------------------------------------------------------------- */

/* Copies colours and keeps the texture of mesh i; YLM_EINVAL, YLM_EDOMAIN, YLM_ENOMEM. */
ylm_status ylm__scene_copy_tint(scene_mesh *m, size_t i, const ylm_scene_mesh *in, ylm_error *e);
void ylm__scene_free_tint(scene_mesh *m);
/* The tint at a place on a triangle, by the weights of its corners. */
void ylm__scene_tint(const scene_mesh *m, const uint32_t corner[3], const float weight[3],
                     float tint[3]);

/* -- scene.c -------------------------------------------------------------------- */

/* Places on triangles and the surfaces there, side by side. */
enum { SCENE_LANES = 16 };
typedef struct scene_lanes {
  /* in: corners, their normals and texture coordinates, 0 where these do not count; the place; -1: it is seen from the back */
  float p[3][3][SCENE_LANES], n[3][3][SCENE_LANES], uv[3][2][SCENE_LANES];
  float u[SCENE_LANES], v[SCENE_LANES], side[SCENE_LANES], lift[SCENE_LANES], pull[SCENE_LANES];
  /* out: as in ylm_scene_surface */
  float position[3][SCENE_LANES], normal[3][SCENE_LANES], lit[3][SCENE_LANES];
  float origin[3][SCENE_LANES], flat[3][SCENE_LANES], tangent[3][SCENE_LANES];
  float way[3][SCENE_LANES], from[2][SCENE_LANES]; /* from the place to `lit`; where rays start */
} scene_lanes;
/* The first n lanes, and those behind them to the end of a vector. */
typedef void ylm_scene_lanes_fn(size_t n, scene_lanes *s);
/* The kernel of the instruction set in use; NULL: there is none. */
ylm_scene_lanes_fn *ylm__scene_lanes(void);

/* -- weights.c ------------------------------------------------------------------ */

/* w[j]: bound of the unshadowed luminous irradiance, over pi, at x with normal n from lamp j;
   sum[b]: over chunk b of YLM_LAMP_CHUNK lamps. Arrays are padded with lamps of luminance 0, whose weight is 0. */
typedef void ylm_scene_weights_fn(size_t lamps, float *const lamp[4], const float *luminance,
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

/* Fills s->far: triangles that are far count as if they were at their centre, for choosers of one lamp. */
ylm_status ylm__scene_make_far(ylm_scene *s);

/* -- sky.c --------------------------------------------------------------------- */

/* Shares the distant lights of the lamps, and what `from` (or NULL) knows of them; to be freed in any
   case. */
ylm_status ylm__scene_share_sky(ylm_scene *s, const ylm_scene_lamps *l, const ylm_scene *from);
void ylm__scene_free_sky(ylm_scene *s);
/* Cells of all domes, and that of a direction to light i of the sky; false: it is in none. */
size_t ylm__scene_sky_cells(const ylm_scene *s);
bool ylm__scene_sky_cell(const ylm_scene *s, size_t i, const float direction[3], size_t *cell);

/* -- point.c -------------------------------------------------------------------- */

/* Copies the lamps without a size; to be freed in any case. */
ylm_status ylm__scene_copy_points(ylm_scene *s, const ylm_scene_lamps *l);
void ylm__scene_free_points(ylm_scene *s);

/* -- storage.c ------------------------------------------------------------------ */

/* Where a ray to a lamp starts, and how its place there is chosen. */
typedef struct scene_aim {
  const float *x, *normal; /* normal NULL: x is a point in space */
  double u[2];
  double solid; /* the lamp's solid angle, if it is known; else 0 */
  bool one;     /* as choosers of one lamp do it, which takes less time */
  const float
      *seen; /* [cells of the sky] by which directions in a tile are chosen; NULL: as it shines */
} scene_aim;

/*
** Lamps stand in arrays that suit their shape: spheres, patches, the sky, points. Their numbers follow one
** another in this order. A storage says how its lamps are weighed and sampled; i counts them from 0.
*/
typedef struct scene_storage {
  size_t (*count)(const ylm_scene *s);
  /* weight[i]: luminance times about the unshadowed irradiance over pi at the chooser's place, in space the
     scalar one, above 0 wherever the lamp brings light; sum: over chunks. Padding keeps its weight 0. */
  void (*weigh)(const ylm_scene_chooser *c, bool one, float *weight, float *sum);
  /* A ray to a random place of lamp i, and the radiance that comes from there. Returns the irradiance that it
     brings for radiance 1, in space the scalar one; 0: none comes. */
  double (*sample)(const ylm_scene *s, size_t i, const scene_aim *a, ylm_trace_ray *ray,
                   float radiance[3]);
  /* The density of these rays, sr^-1, in a direction of length 1; 0: it does not meet the lamp. */
  double (*density)(const ylm_scene_chooser *c, size_t i, const float d[3]);
  /* The light that lamp i is, of an image the mean of a part; false: a part of light that fills the sky. */
  bool (*emitter)(const ylm_scene *s, size_t i, ylm_light_emitter *out);
} scene_storage;

extern const scene_storage ylm__scene_spheres_storage; /* sphere.c */
extern const scene_storage ylm__scene_patch_storage;
extern const scene_storage ylm__scene_sky_storage;
extern const scene_storage ylm__scene_point_storage;

enum { SCENE_SPHERES, SCENE_PATCHES, SCENE_SKY, SCENE_POINTS, SCENE_STORAGES };
extern const scene_storage *const ylm__scene_storage[SCENE_STORAGES];

/* Whether lamps of a storage are in the tree, if there is one. */
static inline bool ylm__scene_is_planted(int storage) { return storage <= SCENE_PATCHES; }
/* The storage of a lamp, whose number comes to count from its first. */
int ylm__scene_storage_of(const ylm_scene *s, size_t *lamp);

/* -- ahead.c -------------------------------------------------------------------- */

/* Few lamps as they are weighed at several places. */
typedef struct scene_ahead {
  float x[3][YLM_SCENE_AHEAD], normal[3][YLM_SCENE_AHEAD]; /* in, to the end of a vector */
  double weight[CHOOSE_FEW]
               [YLM_SCENE_AHEAD]; /* of near triangles over the solid angle's part of pi */
  /* of triangles: whether each is near, and the sides whose arc is then half the solid angle */
  double near[CHOOSE_FEW][YLM_SCENE_AHEAD], arc[2][CHOOSE_FEW][YLM_SCENE_AHEAD];
} scene_ahead;
typedef void ylm_scene_ahead_fn(const ylm_scene *s, size_t n, scene_ahead *a);
/* Makes c->ahead where a scene's lamps are few, spheres and triangles alone; false: without memory. */
bool ylm__scene_ahead_create(ylm_scene_chooser *c);

/* -- lamps.c -------------------------------------------------------------------- */

struct ylm_scene_chooser {
  const ylm_scene *scene;
  /* chunks of all lamps; the first chunk of each storage and one behind the last: those of a tree have none */
  size_t chunks, chunk[SCENE_STORAGES + 1];
  size_t first[SCENE_STORAGES]; /* the number of each storage's first lamp */
  ylm_scene_weights_fn *weights;
  float *weight, *sum; /* [chunks*YLM_LAMP_CHUNK], [chunks] */
  double *solid;       /* [patches] solid angles that are known, else 0; NULL: none is */
  /* what ylm_scene_choose was told last */
  float x[3], normal[3];
  bool in_space;
  double
      total; /* of the sums, and of the tree of lamps: lamps of a tree come before distant lights */
  ylm_scene_nodes_fn *nodes;
  ylm_scene_spheres_fn *aim_at_spheres;
  scene_spheres spheres;        /* lanes behind those in use have numbers of earlier ones */
  scene_cut *cut;               /* of the tree, as it is seen from x; NULL: there is none */
  const ylm_scene_guide *guide; /* NULL: rays are aimed without */
  scene_ahead *ahead;           /* NULL: lamps are not weighed ahead */
  ylm_scene_ahead_fn *weigh_ahead;
  const float *row[YLM_SCENE_AHEAD]; /* of the guide, at places that the chooser was told of */
};

/* -- guide.c -------------------------------------------------------------------- */

/* Weighs the lamps of a chooser by its guide. Returns the factors, in the order of c->weight, and how far what a lamp
   brings spreads, relative to its root mean square: [2][chunks*YLM_LAMP_CHUNK], all above 0; then factors of the cells of the
   sky. */
const float *ylm__scene_guide_weights(ylm_scene_chooser *c);
/* As that, at place k of those that a chooser was told of. */
void ylm__scene_guide_ahead(ylm_scene_chooser *c, size_t n, const float (*x)[3],
                            const float (*normal)[3]);
void ylm__scene_guide_weights_ahead(ylm_scene_chooser *c, size_t k);

/* Turns a chooser to x; `normal` may be NULL. */
void ylm__scene_turn_to(ylm_scene_chooser *c, const float x[3], const float *normal);
/* Weighs all lamps, the tree as a whole, for so many samples; returns the total. `one`: for choosers of one lamp. */
double ylm__scene_weigh(ylm_scene_chooser *c, bool one, int light_samples);
/* The weight of the tree of lamps. */
static inline double ylm__scene_tree_weight(const ylm_scene_chooser *c) {
  return c->cut->n > 0 ? c->cut->open[0].upto[SCENE_WIDTH - 1] * c->scene->tree->unit : 0;
}

/* A place in the list of lamps as strata walk along the sum of weights. */
typedef struct scene_walk {
  size_t chunk, lamp;
  double passed; /* weight of all lamps before `lamp` */
} scene_walk;

/* As ylm__scene_storage_of. */
static inline int ylm__scene_storage_in(const ylm_scene_chooser *c, size_t *lamp) {
  int k = SCENE_STORAGES - 1;
  while (k > 0 && *lamp < c->first[k]) k--;
  *lamp -= c->first[k];
  return k;
}
/* The lamp at a place in the chooser's weights, and the place of a lamp that is in no tree. */
static inline uint32_t ylm__scene_lamp_at(const ylm_scene_chooser *c, size_t place) {
  int k = SCENE_STORAGES - 1;
  while (k > 0 && place < c->chunk[k] * YLM_LAMP_CHUNK) k--;
  return (uint32_t)(c->first[k] + place - c->chunk[k] * YLM_LAMP_CHUNK);
}
static inline size_t ylm__scene_place_of(const ylm_scene_chooser *c, size_t lamp) {
  int k = ylm__scene_storage_in(c, &lamp);
  return c->chunk[k] * YLM_LAMP_CHUNK + lamp;
}
/* The solid angle of a lamp, if it is known; else 0. */
static inline double ylm__scene_solid(const ylm_scene_chooser *c, int storage, size_t i) {
  return c->solid && storage == SCENE_PATCHES ? c->solid[i] : 0;
}
/* Moves on to the lamp that holds `target`; targets increase. */
void ylm__scene_walk_to(scene_walk *w, const ylm_scene_chooser *c, double target);

/* A direction about the axis: cosine z, azimuth u of 0 .. 1. */
void ylm__scene_turn(const float axis[3], double z, double u, float out[3]);

/* -- texture.c ---------------------------------------------------------------- */

/* Copies textures; their triangles are the last of s->triangles. */
ylm_status ylm__scene_copy_textures(ylm_scene *s, const ylm_scene_lamps *l, ylm_error *e);
void ylm__scene_free_textures(ylm_scene *s);

/* -- directed.c --------------------------------------------------------------- */

/* Copies lamps whose radiance depends on the direction; to be freed in any case. */
ylm_status ylm__scene_copy_directed(ylm_scene *s, const ylm_scene_lamps *l);
void ylm__scene_free_directed(ylm_scene *s);
/* The emitter that such a lamp near by is; NULL: its radiance is the same in all directions. */
const ylm_light_emitter *ylm__scene_directed(const ylm_scene *s, size_t lamp);
/* Puts the radiance of such a lamp along a ray of direction d, of any length; false: it is none. */
bool ylm__scene_directed_radiance(const ylm_scene *s, size_t lamp, const float d[3],
                                  float radiance[3]);
/* Weights of lamps first .. first + n - 1 at x, multiplied by the parts of such lamps; sums of chunks follow. */
void ylm__scene_weigh_directed(const ylm_scene *s, size_t first, size_t n, const float x[3],
                               float *weight, float *sum);

/* -- patch.c ------------------------------------------------------------------ */

/* The radiance of patch i at the place p on it, along a ray of direction d, of any length, that meets it there. */
void ylm__scene_patch_radiance(const ylm_scene *s, size_t i, const double p[3], const float d[3],
                               float radiance[3]);

#endif
