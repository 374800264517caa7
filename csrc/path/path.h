/* path.h - what the files of csrc/path share. Private. */
#ifndef YLM_PATH_PRIVATE_H
#define YLM_PATH_PRIVATE_H

#include "calibration.h"
#include "ylm_path.h"
#include "ylm_random.h"
#include "ylm_vector.h"

/* A tile holds batches of items: pairs of the two. */
#define PATH_TILE (PATH_PAIRS * YLM_PATH_BATCH)

/* One path. */
typedef struct path_state {
  ylm_rng rng;
  float throughput[3], radiance[3];
  double pixel[2];  /* numbers that are stratified over the batch: a place in the pixel, */
  double light[3];  /* the first light sample, */
  double chosen[3]; /* the first direction */
  float usual;      /* luminance of what the path may bring; 0: not known */
  uint32_t noted;   /* of a pilot: the last place that was noted */
} path_state;

/* Where a path is reflected. */
typedef struct path_vertex {
  uint32_t path, material;
  ylm_scene_surface at;
  float other[3]; /* the frame's second axis, across tangent and normal */
} path_vertex;

/* Rays whose first hits are the next places. */
typedef struct path_rays {
  size_t n;
  ylm_trace_ray *ray; /* [PATH_TILE] */
  ylm_trace_ray *way; /* [PATH_TILE] as far as lamps along it count; far < 0: it meets some */
  ylm_trace_hit *hit; /* [PATH_TILE] */
  uint32_t *of;       /* [PATH_TILE] its vertex; between two steps its path */
  float (*lit)[3];    /* [PATH_TILE] the point that it brings light to, beside its origin */
} path_rays;

/* Rays to lamps. */
typedef struct path_lights {
  size_t n;
  ylm_trace_ray *ray;             /* [PATH_TILE] */
  float (*radiance)[3], *density; /* [PATH_TILE] the former over the latter */
  float (*wi)[3], (*wo)[3];       /* [PATH_TILE] in the surface's frame */
  float (*f)[3], *pdf;            /* [PATH_TILE] what the material says of them */
  float (*toward)[3];             /* [PATH_TILE] as they were aimed */
  uint32_t *of;                   /* [PATH_TILE] its vertex */
} path_lights;

/* Where a path goes from a place that was noted: to another one, or */
enum { PATH_NOWHERE = UINT32_MAX, PATH_UNKNOWN = UINT32_MAX - 1 };

/* Places at which paths are reflected, that guides are learnt from. */
typedef struct path_places {
  size_t n, room;
  float (*x)[3], (*normal)[3], (*origin)[3]; /* [room] */
  float (*albedo)[3];                        /* what is reflected there, roughly */
  float (*direction)[3];                     /* where the path goes on */
  uint32_t *next;                            /* and to which place */
  bool *cosine;                              /* directions there are chosen as the cosine */
} path_places;

/* Knowledge of a pilot about light that was reflected: known.c. */
typedef struct path_known path_known;

typedef struct path_job path_job;

/* The memory of one thread. */
typedef struct path_tile {
  const path_job *job;
  ylm_scene_chooser *lamps;
  path_places *noted; /* NULL, or of a pilot: its places are noted, and nothing is lit */
  ylm_path_stats counts;
  size_t pairs;           /* in use */
  uint64_t *item, *batch; /* [PATH_PAIRS] */
  path_state *path;       /* [PATH_TILE] */
  /* of this step */
  size_t n;
  path_vertex *vertex;     /* [PATH_TILE] those of a material follow one another */
  uint32_t *behind;        /* [materials] where a material's end */
  float (*wo)[3], (*u)[3]; /* [PATH_TILE] */
  float (*wi)[3], (*weight)[3], *pdf;
  float (*way)[3];            /* [PATH_TILE] wi in the scene */
  float (*f)[3], *own;        /* [PATH_TILE] of guided ones: the material's f and density */
  uint32_t *cluster;          /* [PATH_TILE] of `known`, or PATH_UNKNOWN */
  float *chance;              /* [PATH_TILE] that the path goes on; */
  bool *ends;                 /* [PATH_TILE] it does not */
  uint32_t start[PATH_PAIRS]; /* clusters of the points where paths begin */
  path_rays rays;
  path_lights lights;
  /* of probes: the light samples of the start */
  float (*toward)[3], (*straight)[3],
      (*first)[3]; /* [PATH_TILE] direction, radiance; first direction */
  float *basis;    /* [2 YLM_PATH_BATCH][count] */
} path_tile;

/* A kind of estimate. */
typedef struct path_kind {
  const char *stage;
  /* Fills tile->rays with the first ones, traced, and the paths' throughput and radiance. */
  void (*begin)(path_tile *t);
  /* Writes the means over the batch of pair k. */
  void (*finish)(path_tile *t, size_t k, double *values);
} path_kind;

struct path_job {
  const path_kind *kind;
  const ylm_scene *scene;
  const ylm_trace *trace;
  const ylm_path_options *o;
  ylm_scene_guide *guide; /* NULL: rays to lamps have none */
  path_known *known;      /* NULL: nothing is known about reflected light */
  size_t items, values;
  size_t batches_per_tile;
  const ylm_material **material; /* [materials] distinct */
  uint32_t *material_of;         /* [meshes] */
  float (*albedo)[3];            /* [materials] */
  bool *glosses;                 /* [materials] too narrowly for guides of matte surfaces */
  size_t materials;
  double radical[YLM_PATH_BATCH];
  /* images */
  ylm_camera_frame frame;
  int width, height;
  const float *background;
  /* probes; normals NULL: light from all sides to degree lmax */
  const float (*points)[3], (*normals)[3];
  const float (*origin)[3]; /* where their rays start; NULL: there */
  int lmax;
  /* places of surfaces */
  const ylm_scene_place *places;
  const size_t *first; /* [items+1] their places, weight says how often; NULL: an item is a place */
  const float *weight;
  double eye[3];
  bool open; /* nothing occludes */
};

/* -- tile.c ---------------------------------------------------------------------- */

path_tile *ylm__path_tile_create(const path_job *j);
void ylm__path_tile_free(path_tile *t);
/* Starts the generators of all paths, and the numbers that are stratified. */
void ylm__path_tile_seed(path_tile *t);
/* Turns first hits into vertices, sorted by material; drops rays that hit nothing. */
void ylm__path_tile_vertices(path_tile *t);
/* A direction in the vertex's frame, and back. */
static inline void ylm__path_inward(const path_vertex *v, const float d[3], float out[3]) {
  out[0] = ylm_dot3(d, v->at.tangent);
  out[1] = ylm_dot3(d, v->other);
  out[2] = ylm_dot3(d, v->at.normal);
}
static inline void ylm__path_outward(const path_vertex *v, const float d[3], float out[3]) {
  for (int a = 0; a < 3; a++)
    out[a] = d[0] * v->at.tangent[a] + d[1] * v->other[a] + d[2] * v->at.normal[a];
}

/* Where the vertices from v on are that scenes are asked of in one go; returns how many. */
static inline size_t ylm__path_next(const path_tile *t, size_t v, float x[YLM_SCENE_AHEAD][3],
                                    float normal[YLM_SCENE_AHEAD][3]) {
  size_t n = t->n - v < YLM_SCENE_AHEAD ? t->n - v : YLM_SCENE_AHEAD;
  for (size_t k = 0; k < n; k++) {
    memcpy(x[k], t->vertex[v + k].at.lit, 12);
    memcpy(normal[k], t->vertex[v + k].at.normal, 12);
  }
  return n;
}

/* -- direct.c -------------------------------------------------------------------- */

/* Adds to the paths' radiance the lamps' light on their vertices: by rays to lamps, and along
   t->rays, of which ray i leaves vertex of[i] with density pdf[of[i]]. */
void ylm__path_direct(path_tile *t, bool first);
/* Finds which of t->rays meet lamps before their hits. */
void ylm__path_look(path_tile *t);
/* The radiance of lamps along ray i of t->rays, which was chosen with density pdf. The strategy
   weighs it against choosing these lamps by t->lamps. */
void ylm__path_meet(path_tile *t, size_t i, float pdf, float radiance[3]);
/* Adds to `sum` what is finite; counts what is not. */
void ylm__path_add(path_tile *t, float sum[3], const float x[3]);
/* The next random number, from 0 below 1. */
static inline double ylm__path_random(ylm_rng *r) { return ylm_draw_u32(r) * 0x1p-32; }
/* How much an estimate counts whose direction another kind of ray finds with density `other`. */
static inline float ylm__path_balance(float own, float other) { return own / (own + other); }

/* -- path.c ---------------------------------------------------------------------- */

/* Fills values [pairs][values] of a tile whose pairs are chosen. */
void ylm__path_walk(path_tile *t, double *values);

/* path_kind's finish of radiance itself. */
void ylm__path_mean(path_tile *t, size_t k, double *values);

/* -- guide.c -------------------------------------------------------------------- */

/* Learns j->guide and j->known, which may stay NULL, from paths with random numbers of their own; counts its rays. */
ylm_status ylm__path_learn(path_job *j, ylm_path_stats *stats);
/* Frees them, unless j->o->kept has them. */
void ylm__path_forget(path_job *j);

/* -- known.c -------------------------------------------------------------------- */

/* Learns j->known from these places, and from rays to lamps. */
ylm_status ylm__path_know(path_job *j, const path_places *places, ylm_path_stats *stats);
void ylm__path_known_free(path_known *k);
size_t ylm__path_clusters(const path_known *k);
/* The cluster of a place; PATH_UNKNOWN: there is none. */
uint32_t ylm__path_cluster(const path_known *k, const float x[3], const float normal[3]);
/* The clusters of n places; the light that is expected there is asked for soon. */
void ylm__path_clusters_at(const path_known *k, size_t n, const float (*x)[3],
                           const float (*normal)[3], uint32_t *cluster);
/* Irradiance [3] of light that counts where it is reflected as the path's reflection `order`, without light straight from
   lamps. */
void ylm__path_expected(const path_job *j, uint32_t cluster, int order, float irradiance[3]);
/* A cluster's guide is asked soon; then for a direction by u, or for the density of a direction: what is needed is fetched to the
   cache. */
void ylm__path_guide_ahead(const path_known *k, uint32_t cluster);
void ylm__path_guided_ahead(const path_known *k, uint32_t cluster, const float u[2]);
void ylm__path_density_ahead(const path_known *k, uint32_t cluster, const float direction[3]);
/* A direction by a cluster's guide from u [2], 0 .. 1; false: it is below the surface. */
bool ylm__path_guided(const path_known *k, uint32_t cluster, const float u[2], float direction[3]);
/* The density of such directions, sr^-1. */
float ylm__path_guided_density(const path_known *k, uint32_t cluster, const float direction[3]);
/* The density of a direction as what a path goes along from vertex v, by its material, which has `own`, and by its guide. */
static inline float ylm__path_density(const path_tile *t, size_t v, float own,
                                      const float direction[3]) {
  if (t->cluster[v] == PATH_UNKNOWN) return own;
  float guided = ylm__path_guided_density(t->job->known, t->cluster[v], direction);
  return t->chance[v] * ((1 - GUIDED_PART) * own + GUIDED_PART * guided);
}
static inline float ylm__path_luminance(const float *c) {
  return (float)YLM_LUMINANCE_R * c[0] + (float)YLM_LUMINANCE_G * c[1] +
         (float)YLM_LUMINANCE_B * c[2];
}

/* -- film.c ---------------------------------------------------------------------- */

/* Runs all batches that are missing. */
ylm_status ylm__path_run(path_job *j, ylm_path_sum *sum, ylm_path_stats *stats, ylm_error *e);

#endif
