/* unwrap.h - what the files of csrc/geom/unwrap share. Private. */
#ifndef YLM_GEOM_UNWRAP_PRIVATE_H
#define YLM_GEOM_UNWRAP_PRIVATE_H

#include "ylm_geom_unwrap.h"

#define UNWRAP_NONE YLM_UNWRAP_NONE

/* -- calibration -------------------------------------------------------------------------------- */

/* A chart is projected where all its normals are within this cosine of their mean. */
#define NEARLY_FLAT 0.97
/* A triangle has no area where it is below this part of its longest edge's square: floats cannot tell it from a line. */
#define DEGENERATE 1e-12
/* Rounds of rotations and solutions, steps of a solution, and the change at which each ends. */
#define RIGID_ROUNDS 12
#define RIGID_STEPS 60
#define RIGID_SMALL 1e-2
/* A chart with more than this part of the whole area is cut where it fills less than this part of its rectangle. */
#define SPARSE_LEAST 0.004
#define FILLED 0.5
/* Directions that are tried for the smallest rectangle. */
#define HULL_EDGES 96
/* Packings that look for a factor, of few charts and of many, and the part of the texels that is near enough. */
#define FITS 9
#define FITS_MANY 4
#define FIT_NEAR 0.985

/* -- the whole ---------------------------------------------------------------------------------- */

typedef struct unwrap_chart {
  size_t first, triangles; /* of the list */
  double (*flat)[2];       /* [vertices] scene units, counter-clockwise, in a box from 0 */
  uint32_t vertices;
  bool curved;
  double area, size[2], stretch;
  /* How it is packed. */
  double scale[2];
  size_t at[2];
  bool turned;
} unwrap_chart;

struct ylm_unwrap {
  size_t meshes, triangles;
  size_t *first;    /* [meshes + 1] triangles before a mesh's */
  size_t *vertices; /* [meshes] */
  uint32_t *index;  /* [3 triangles] vertices of the mesh */
  uint32_t *corner; /* [3 triangles] vertices of the chart */
  uint32_t *of;     /* [triangles] the chart or UNWRAP_NONE */
  uint32_t *list;   /* [triangles] by chart */
  uint32_t *across; /* [3 triangles] the surface's */
  unwrap_chart *chart;
  size_t charts, room;
  size_t width, height, used; /* texels; those that are looked up */
  ylm_unwrap_stats stats;
};

/* The surface while it is cut. */
typedef struct unwrap_surface {
  size_t triangles;
  double (*point)[3][3]; /* [triangles] corners */
  double (*normal)[3];   /* [triangles] unit; 0 of a triangle without area */
  double *area;          /* [triangles] */
  double whole;          /* their sum */
  uint32_t *
      across; /* [3 triangles] the same edge of the triangle beside, or UNWRAP_NONE; the unwrap's */
  uint32_t *of;          /* the unwrap's */
  const uint32_t *label; /* [triangles] or NULL */
} unwrap_surface;

static inline size_t unwrap_next(size_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/* surface.c: corners, normals and what joins. */
ylm_status ylm__unwrap_surface(size_t meshes, const ylm_unwrap_mesh *mesh, ylm_unwrap *u,
                               unwrap_surface *s, ylm_error *e);
void ylm__unwrap_surface_free(unwrap_surface *s);

/* grow.c: charts of all triangles, by normals: their number in s->of, their lists. */
ylm_status ylm__unwrap_grow(ylm_unwrap *u, const unwrap_surface *s, double cosine);
/* grow.c: cuts a chart in two or more; new charts come last. */
ylm_status ylm__unwrap_halve(ylm_unwrap *u, const unwrap_surface *s, size_t chart);
/* grow.c: a new chart of triangles of the list. YLM_ENOMEM. */
ylm_status ylm__unwrap_add(ylm_unwrap *u, size_t first, size_t triangles);

/* flatten.c: coordinates of a chart, and its stretch. False in *valid: it overlaps itself. */
ylm_status ylm__unwrap_flatten(ylm_unwrap *u, const unwrap_surface *s, unwrap_chart *c,
                               bool *valid);
/* rigid.c: moves the flat vertices of a chart so that its triangles keep their shapes as well as they can. */
ylm_status ylm__unwrap_rigid(const ylm_unwrap *u, const unwrap_surface *s, unwrap_chart *c);
/* valid.c: whether a flat chart is counter-clockwise and covers no place twice. */
ylm_status ylm__unwrap_valid(const ylm_unwrap *u, const unwrap_surface *s, const unwrap_chart *c,
                             bool *valid);
/* rectangle.c: turns a flat chart to its smallest rectangle. YLM_ENOMEM. */
ylm_status ylm__unwrap_turn(unwrap_chart *c);

/* -- masks: mask.c ------------------------------------------------------------------------------ */

/* Bits of texels, rows of whole words. */
typedef struct unwrap_mask {
  size_t width, height, words; /* words of a row */
  uint64_t *bit;
} unwrap_mask;

/* Texels that bilinear look-ups in a chart read, with its scale and turn. YLM_ENOMEM. */
ylm_status ylm__unwrap_mask(const ylm_unwrap *u, const unwrap_chart *c, unwrap_mask *m);
/* Sets the bits from .. to of row y. */
void ylm__unwrap_set(unwrap_mask *m, size_t y, size_t from, size_t to);
static inline bool unwrap_is_set(const unwrap_mask *m, size_t x, size_t y) {
  return m->bit[y * m->words + x / 64] >> x % 64 & 1;
}
/* A place of a flat chart, in texels of its mask. */
static inline void unwrap_texel(const unwrap_chart *c, const double flat[2], double at[2]) {
  double x = c->scale[0] * flat[0], y = c->scale[1] * (c->size[1] - flat[1]);
  at[0] = 0.5 + (c->turned ? c->scale[1] * c->size[1] - y : x);
  at[1] = 0.5 + (c->turned ? x : y);
}

#endif
