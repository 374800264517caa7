/* surface.h - what the files of csrc/surface share. Private. */
#ifndef YLM_SURFACE_PRIVATE_H
#define YLM_SURFACE_PRIVATE_H

#include <math.h>

#include "calibration.h"
#include "ylm_list.h"
#include "ylm_surface.h"
#include "ylm_vector.h"

#define SURFACE_NONE UINT32_MAX
/* Parts of a chart's edge: corners of rectangles are whole numbers of these. */
#define SURFACE_TOP 32768

/* -- charts.c -------------------------------------------------------------------- */

/* A map of a surface: a plane, or what lies along an axis. */
typedef struct surface_chart {
  float origin[3], axis[3][3], size[3]; /* size[2] is 0 of a plane */
} surface_chart;

typedef struct surface_charts {
  const ylm_scene *scene;
  size_t *first; /* [meshes + 1] of triangles */
  double area;   /* of all triangles, once */
  double unit;   /* its root */
  surface_chart *chart;
  size_t charts;
  /* [triangles] twice the first of a triangle's charts; + 1: six that blend, else front and back of a plane;
     SURFACE_NONE: no area. */
  uint32_t *of;
} surface_charts;

/* A place on a chart, its part of the place's light, and its coordinates, 0 .. SURFACE_TOP. */
typedef struct surface_spot {
  uint32_t chart;
  float weight, at[3];
} surface_spot;

/* The area of a triangle of a mesh with these positions, its corners p and its normal n; 0: it has none. */
double ylm__surface_triangle(const float *positions, const uint32_t *triangle, const float *p[3],
                             double n[3]);
ylm_status ylm__surface_charts(const ylm_scene *scene, surface_charts *c, ylm_error *e);
void ylm__surface_charts_free(surface_charts *c);
/* The spots of a place whose position and normal are known, 3 at most; how many. */
int ylm__surface_spots(const surface_charts *c, const ylm_scene_place *p, const float position[3],
                       const float normal[3], surface_spot spot[3]);

/* Whether x lies on the second side of a cut: not where a . x < a[3]. */
static inline bool ylm__surface_is_beyond(const float a[4], const float x[3]) {
  return !(ylm_dot3(a, x) < a[3]);
}
/* Bilinear weights of the corners of a rectangle at a spot; beyond its edges those of the edges. */
static inline void ylm__surface_weights(const uint16_t lo[2], const uint16_t hi[2],
                                        const float at[2], float w[4]) {
  float t[2];
  for (int a = 0; a < 2; a++) t[a] = fminf(fmaxf((at[a] - lo[a]) / (float)(hi[a] - lo[a]), 0), 1);
  for (int c = 0; c < 4; c++) w[c] = (c & 1 ? t[0] : 1 - t[0]) * (c & 2 ? t[1] : 1 - t[1]);
}

/* -- look.c: a finished grid ------------------------------------------------------ */

/* A node is a number: its kind, and 8 times what it names. */
enum { NODE_U, NODE_V, NODE_W, NODE_PLANE, NODE_RECTANGLE, NODE_BITS = 3 };

/* A cut by part: child where a . x < a[3], child + 1 elsewhere. */
typedef struct surface_plane {
  float a[4];
  uint32_t child;
} surface_plane;

typedef struct surface_rectangle {
  uint32_t corner[4]; /* rows: (0,0), (1,0), (0,1), (1,1) */
  uint16_t lo[2], hi[2];
  uint32_t chart;
} surface_rectangle;

struct ylm_surface_grid {
  surface_charts charts;
  uint32_t *root; /* [charts] nodes, or SURFACE_NONE */
  uint32_t *node; /* [nodes] */
  surface_plane *plane;
  surface_rectangle *rectangle;
  float (*row)[3];
  size_t nodes, planes;
  ylm_surface_stats stats;
};

/* -- the bake ------------------------------------------------------------------- */

/* A random place. */
typedef struct surface_site {
  ylm_scene_place at;
  float position[3], normal[3];
  uint32_t light; /* the number of its light; SURFACE_NONE: not asked for */
  uint8_t known;  /* SITE_* */
} surface_site;

/* Covered: another surface is so near that nobody looks at it. Such places are fitted, and not judged. */
enum { SITE_UNKNOWN, SITE_OPEN, SITE_COVERED, SITE_BURIED };

/* Its light by two halves of its rays. */
typedef struct surface_light {
  float a[3], b[3];
} surface_light;

/* A site on a chart. */
typedef struct surface_entry {
  uint32_t site;
  float at[3];
} surface_entry;

typedef struct surface_branch {
  uint32_t chart, kind; /* NODE_* */
  uint32_t child, leaf; /* the first of two; of a leaf its number */
  float a[4];           /* of NODE_PLANE */
  uint16_t lo[3], hi[3];
} surface_branch;

typedef struct surface_leaf {
  uint32_t branch;
  size_t first, n, sampled; /* of entries; those whose light is known come first */
  double weight;            /* its area: the sites that it has of those spread over all surfaces */
  double square;            /* of its error over the tolerance's scale, without noise */
  float value[4][3];        /* at its corners */
  uint32_t corner[4];       /* classes */
  bool stuck, parted;       /* it cannot be halved; nothing parts its places */
} surface_leaf;

/* A class of corners: those of leaves that join at one place. */
typedef struct surface_class {
  uint32_t host; /* the leaf on whose edge it hangs, or SURFACE_NONE */
  uint32_t free; /* its unknown, or SURFACE_NONE */
  uint16_t at[2];
  float value[3];
} surface_class;

/* Weights of unknowns. */
typedef struct surface_term {
  uint32_t unknown;
  float weight;
} surface_term;

typedef struct surface_bake {
  const ylm_radiosity *r;
  const ylm_surface_form *form;
  const ylm_scene *scene;
  surface_charts charts;
  ylm_error *e;
  surface_site *site;
  size_t sites, spread, site_room; /* those spread over all surfaces stand first */
  surface_light *light;
  size_t lights, light_room;
  surface_entry *entry;
  size_t entries;
  surface_branch *branch;
  size_t branches, branch_room;
  uint32_t *root; /* [charts] branches or SURFACE_NONE */
  surface_leaf *leaf;
  size_t leaves, leaf_room;
  surface_class *class;
  size_t classes, class_room, unknowns;
  double mean[3];
  double aim; /* the tolerance that is refined for */
  int links;  /* rays of each half of a place's light: the form's, more where these are noisy */
  ylm_surface_stats stats;
} surface_bake;

/* Is a site kept for judges? Leaves take most of the sites that a small one has: by those that they leave over, small leaves would
   count for less than their area. */
static inline bool site_judges(const surface_bake *b, size_t site) {
  return site < b->spread && site % JUDGES_SHARE == 0;
}

/* The light at n places that the list names, its two halves of `links` rays each; `share` of ylm_radiosity_places. */
ylm_status ylm__surface_ask(surface_bake *b, size_t n, const uint32_t *site, int links,
                            surface_light *light, float *share);

/* -- places.c -------------------------------------------------------------------- */

/* Whether a side of a triangle has light: one of the sides that reflect, or of a mesh that does not occlude. */
bool ylm__surface_is_lit(const ylm_transfer *t, const ylm_scene_place *p);
/* Sums of the areas of triangles, [triangles + 1], to be freed; NULL without memory. */
double *ylm__surface_areas(const surface_charts *c, const ylm_transfer *transfer);
/* Whether another surface covers a place. */
bool ylm__surface_is_covered(const surface_charts *c, double unit, const ylm_scene_surface *at);
/* A random place on either side of all triangles. */
ylm_scene_place ylm__surface_random(const surface_charts *c, const double *sum, ylm_rng *rng);

/* Random places that a promise is about: ylm_surface_draw. */
ylm_status ylm__surface_draw(const surface_charts *c, const ylm_radiosity *r, size_t n,
                             uint64_t seed, ylm_scene_place *place, size_t *drawn);

/* sites.c: random sites by area, and entries of all charts; leaves of charts. */
ylm_status ylm__surface_sites(surface_bake *b);
/* sites.c: asks for the light of sites until leaves have enough. */
ylm_status ylm__surface_sample(surface_bake *b);
/* sites.c: asks for all light that there is anew, with b->links. */
ylm_status ylm__surface_renew(surface_bake *b);
/* sites.c: finds out what a list of sites is; of `share` that ylm__surface_ask found, or of rays of its own. */
ylm_status ylm__surface_know(surface_bake *b, size_t n, const uint32_t *site, const float *share);
/* sites.c: keeps the light of a list of sites, of those that have none yet and are not buried. */
ylm_status ylm__surface_keep(surface_bake *b, size_t n, const uint32_t *site,
                             const surface_light *light);
/* denser.c: more sites of leaves whose error is too large and that have too few to be halved. */
ylm_status ylm__surface_denser(surface_bake *b, uint64_t round);
/* Takes an entry of a leaf, whose light is known, to those that are sampled. */
void ylm__surface_take(surface_leaf *l, surface_entry *entry, size_t at);

/* tree.c */
static inline float ylm__surface_extent(const surface_bake *b, const surface_branch *n, int a) {
  return (float)(n->hi[a] - n->lo[a]) / SURFACE_TOP * b->charts.chart[n->chart].size[a];
}
/* The leaf that a spot lies on; SURFACE_NONE: its chart has none. */
uint32_t ylm__surface_descend(const surface_bake *b, const surface_spot *s,
                              const float position[3]);
/* A leaf of a chart with all its sites, entries first .. first + n - 1. */
ylm_status ylm__surface_plant(surface_bake *b, uint32_t chart, size_t first, size_t n);
/* Halves a leaf; kind NODE_U .. NODE_W, or by the plane `a`. */
ylm_status ylm__surface_halve(surface_bake *b, uint32_t leaf, uint32_t kind, const float a[4]);
/* Halves the planted leaves as those of another grid are; YLM_EFORMAT: its nodes are no trees. */
ylm_status ylm__surface_grow(surface_bake *b, const ylm_surface_grid *like);
/* Whether a leaf may be halved across an axis. */
bool ylm__surface_may(const surface_bake *b, const surface_branch *n, int axis);
/* The light of the bake as it is at a site. */
void ylm__surface_value(const surface_bake *b, const surface_site *s, float E[3]);

/* sight.c: whether pairs of sites join: clear [n] */
ylm_status ylm__surface_join(surface_bake *b, size_t n, const uint32_t (*pair)[2], bool *joined);

/* corners.c: classes of the leaves' corners, and those that hang. */
ylm_status ylm__surface_corners(surface_bake *b);

/* fit.c: the mean of the light by area. */
void ylm__surface_mean(surface_bake *b);
/* fit.c: the values of all classes, and of the leaves' corners. */
ylm_status ylm__surface_fit(surface_bake *b);

/* cut.c: halves a leaf in the way that leaves the least error; false in *done where none is allowed. */
ylm_status ylm__surface_split(surface_bake *b, uint32_t leaf, bool *done);

/* cut.c: cuts leaves that are new where their places do not see each other. */
ylm_status ylm__surface_part(surface_bake *b);

/* compact.c: the finished grid. */
ylm_status ylm__surface_compact(surface_bake *b, ylm_surface_grid **out);

/* look.c: the bytes that a grid takes. */
void ylm__surface_weigh(ylm_surface_grid *g);

static inline void ylm__surface_mid(const surface_light *l, double E[3]) {
  for (int c = 0; c < 3; c++) E[c] = 0.5 * ((double)l->a[c] + (double)l->b[c]);
}
/* The scale of errors at a place, by channel. */
static inline double ylm__surface_scale(const surface_bake *b, double E, int c) {
  return fmax(E, b->mean[c]);
}

#endif
