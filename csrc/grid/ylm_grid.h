/*
** ylm_grid.h - light fields remembered at grid points, and interpolated.
**
** A grid is made by asking a ylm_field for coefficients, gradients and the
** Hessian metric at the corners of voxels: of a uniform lattice, or of an
** octree that refines itself where the metric (or a tolerance) asks for it and
** where shading points are. Corners are shared between voxels and levels; each
** is evaluated once.
**
** Ownership   ylm_grid_bake and ylm_grid_read make a grid, ylm_grid_free frees it.
**             Pointers of ylm_grid_contents live as long as the grid.
** Threads     a grid is immutable once made: any number of threads may read it.
** Units       lengths and gradients in scene units; voxels count from 0.
** Source      Iwasaki & Dobashi 2025, Sec. 5 and 5.1; docs/grids.md
*/
#ifndef YLM_GRID_H
#define YLM_GRID_H

#include <math.h>

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define YLM_GRID_MAX_DEPTH 16
#define YLM_GRID_NONE UINT32_MAX
#define YLM_GRID_BLOCK 8192                    /* points of one call of the field in a bake */
#define YLM_GRID_MAX_CELLS ((uint64_t)1 << 31) /* of a uniform grid */
#define YLM_GRID_MAX_SIDE (1u << 20)           /* of a uniform grid: cells along an axis */

typedef struct ylm_grid ylm_grid;
typedef struct ylm_light_set ylm_light_set; /* ylm_light.h */

typedef enum ylm_grid_kind { YLM_GRID_ADAPTIVE = 0, YLM_GRID_UNIFORM = 1 } ylm_grid_kind;
typedef enum ylm_grid_metric { YLM_GRID_ABSOLUTE = 0, YLM_GRID_RELATIVE = 1 } ylm_grid_metric;

/* -- baking ------------------------------------------------------------------ */

/* The subject of a tolerance: coefficients, their distance relative to their norm; or the
   irradiance of occupied points with normals (ylm_grid_source.normals). */
typedef enum ylm_grid_measure {
  YLM_GRID_COEFFICIENTS = 0,
  YLM_GRID_IRRADIANCE = 1
} ylm_grid_measure;

/* Fingerprints of the parts of a scene that a grid's light was baked from, 0 of the others; `known` are flags of
   YLM_GRID_PRINT_*. No flag: nobody told. */
typedef struct ylm_grid_prints {
  uint64_t known, geometry, materials, lights;
} ylm_grid_prints;

enum {
  YLM_GRID_PRINT_GEOMETRY = 1,
  YLM_GRID_PRINT_MATERIALS = 2,
  YLM_GRID_PRINT_LIGHTS = 4,
  YLM_GRID_PRINT_ALL = 7
};

/* The body whose visibility a grid holds: a sphere around it, and the mean area of its projections. */
typedef struct ylm_grid_body {
  double at[3], radius, area; /* radius 0: no body is known */
} ylm_grid_body;

/* The description of a grid. */
typedef struct ylm_grid_form {
  ylm_grid_kind kind;
  double bounds[6];       /* min x y z, max x y z; max > min */
  int lmax;               /* 0 .. */
  int channels;           /* 1 luminance, 3 rgb */
  int metric_channels;    /* 1 or 3: of what lambda and norm are; 3 only where channels is 3;
                             0 in a uniform grid: they are not asked for, and NaN */
  int depth;              /* adaptive: finest level N, 0 .. YLM_GRID_MAX_DEPTH */
  uint32_t cells[3];      /* uniform: voxels along each axis */
  ylm_grid_metric metric; /* adaptive, with a threshold */
  double threshold;       /* adaptive: subdivide above it; negative: none, use the tolerance */
  double tolerance;       /* adaptive: relative error promised; 0: none, use the threshold */
  bool continuous;        /* adaptive: no jumps across faces that change level */
  bool dynamic;           /* keeps what ylm_grid_update needs */
  /* Voxels that surfaces cross hold a function for each part of their free space; probes are values alone, and interpolated
     along the axes. Needs ylm_grid_source.walls. */
  bool sides;
  ylm_grid_measure measure; /* adaptive, with a tolerance */
  ylm_quantity quantity;    /* what it holds; a bake takes it from its field */
  double floor; /* of a tolerance of coefficients: smaller norms count as this one; 0: none do */
  ylm_grid_body body;     /* of visibilities; kept and saved */
  ylm_grid_prints prints; /* kept and saved; other light from refresh and update takes them away */
} ylm_grid_form;

/* Triangles whose surface is to be lit. Sides and normals are those of ylm_geom.h. */
typedef struct ylm_grid_mesh {
  size_t vertices, triangles;
  ylm_dtype dtype;       /* of the positions */
  const void *position;  /* [vertices][3], scene units */
  const uint32_t *index; /* [triangles][3], each below `vertices` */
} ylm_grid_mesh;

typedef struct ylm_grid_backend ylm_grid_backend;

/*
** Surfaces that hide light, as a bake and look-ups ask for them. Positions are relative to `origin`. Called on any of the
** threads.
**
**   share   of the ways from a[i] to b[i]: the part of it before the first surface, 1 where there is none
**   meets   whether a box (min, max) meets a triangle; NULL: nobody knows, look-ups alone may be asked for
**   buried  of the directions from x in which surfaces are seen, the part that sees a side that is not used; *open: the part of
**           all directions in which no surface is; NULL: no side is unused
*/
typedef struct ylm_grid_walls {
  void (*share)(const void *self, size_t n, const float (*a)[3], const float (*b)[3], float *share);
  bool (*meets)(const void *self, const double box[6]);
  double (*buried)(const void *self, const float x[3], double *open);
  const void *self;
  double origin[3];
} ylm_grid_walls;

/* From where, and how. */
typedef struct ylm_grid_source {
  const ylm_field *field;
  const ylm_light_set *lights;     /* dynamic: what the field is the sum of; else it may be NULL */
  const ylm_grid_backend *backend; /* NULL: the processor. Not of a dynamic grid */
  size_t occupied;                 /* number of shading points */
  ylm_dtype occupied_dtype;
  const void
      *occupied_points; /* [occupied][3]; NULL: every voxel is occupied, or the back end has them */
  const void *normals; /* [occupied][3] of the points, unit, of their type: the sides that are seen;
                           NULL: none. Surfaces have both of theirs */
  const ylm_grid_walls *walls; /* of a grid with sides */
  size_t meshes;               /* surfaces instead of points: voxels that a triangle meets */
  const ylm_grid_mesh *mesh;   /* [meshes]; a dynamic grid keeps a copy */
  const double
      *within;   /* [6] min, max: a tolerance is of the surfaces in this box; NULL: in the bounds */
  uint64_t seed; /* of the choice of held-out points */
  size_t max_points; /* YLM_ELIMIT beyond; 0: no limit but memory */
  /* Of a grid with sides and a tolerance: refinement is for this part of it (0: all), since another judge will also see the
     field's own error; and ends at so many points (0: none). `squares`: leaves of the largest squared errors are split first,
     over light times its mean, so that places that are far brighter than the mean count; else many small errors outweigh them. */
  double aim;
  size_t budget;
  bool squares;
  const ylm_grid *like;         /* a grid of much the same light, whose bake this one goes on from:
                                   estimates are those, and few points verify. NULL: none */
  int threads;                  /* 0: the default */
  const ylm_progress *progress; /* may be NULL */
  /* Processes that bake the same grid together: each evaluates a part of the points, and all have the
     grid of one process, to the bit. NULL: this process alone. Not of a dynamic grid, or beside a
     back end. */
  ylm_team *team;
} ylm_grid_source;

/* The report of the last update. */
typedef struct ylm_grid_update_stats {
  uint64_t updates; /* since the bake; the numbers below are of the last */
  uint64_t lights;  /* that changed, appeared or vanished */
  uint64_t points;  /* brought up to date: with all lights, or with what changed */
  uint64_t exact;   /* of these, with all lights */
  uint64_t skipped; /* left alone although some light changed: the change is within tolerance */
  uint64_t added, removed; /* points that refinement made, and that it dropped */
  uint64_t pairs;          /* light x point evaluations */
  double seconds;
  double field_seconds; /* of these, inside of the light field */
  double tree_seconds;  /* of these, for octree, verification and continuity */
  bool rebaked;         /* so much changed that everything was baked anew */
} ylm_grid_update_stats;

/* The report of a bake. Counts are of evaluated points unless said otherwise. */
typedef struct ylm_grid_stats {
  uint64_t points;         /* evaluated, each once: N_p of the paper */
  uint64_t tested;         /* of these: only to measure a residual, at a voxel's centre */
  uint64_t interpolated;   /* points that only continuity needs, no light evaluated */
  uint64_t cells, leaves;  /* of the octree (uniform: voxels with data), before continuity */
  uint64_t occupied;       /* leaves that hold shading points */
  uint64_t continuity;     /* leaves added by continuity */
  uint64_t levels;         /* deepest level + 1 */
  uint64_t pairs;          /* light x point evaluations, verification included */
  uint64_t invalid;        /* points in or on a light, filled from their neighbours */
  uint64_t outside;        /* shading points outside of the bounds, moved onto them; triangles that
                             are not wholly within them, whose parts outside count for nothing */
  uint64_t crossed_leaves; /* of a grid with sides: leaves that surfaces cross */
  uint64_t parts;          /* of these */
  uint64_t ghosts; /* of `points`: expanded from the nearest place that the part's class sees */
  uint64_t joined; /* parts beyond the most that a leaf can have, which count as parts of others */
  uint64_t bytes;  /* of memory that the grid holds */
  double seconds;  /* of the whole bake */
  double field_seconds;  /* of these, inside of the light field */
  double verify_seconds; /* of these, for the verification of a tolerance (field included) */
  /* of `seconds`, without the field; what is left is bookkeeping. 0 in a grid that was loaded */
  double occupancy_seconds;  /* the octree of shading points */
  double lattice_seconds;    /* finding corners by their lattice coordinates */
  double residual_seconds;   /* interpolation errors at the centres of voxels */
  double continuity_seconds; /* making the interpolant continuous */
  uint64_t rounds;           /* of refinement and verification */
  /* of a tolerance, by the bake or the last update */
  uint64_t verified;    /* held-out points that judge it */
  double error;         /* a bound of the 99 % quantile of all points' errors; NaN: not measured */
  double confidence;    /* of that bound; 0 in a grid that was loaded */
  double largest_error; /* of the points that judge it */
  uint64_t failed;      /* of the points that judge it: above the tolerance */
  bool met;             /* error <= tolerance */
  bool limited;         /* not met because the depth is reached where it would refine */
  bool spent;           /* not met because the budget of points is spent */
  ylm_grid_update_stats update;
} ylm_grid_stats;

/*
** ylm_grid_bake - make a grid.
**
**   form    in   what grid
**   source  in   its light field and shading points
**   g       out  the grid, or NULL on failure
**
** Returns  YLM_OK; YLM_ERANGE, YLM_EINVAL, YLM_EDOMAIN (what is wrong stands in `e`),
**          YLM_ENOMEM, YLM_ELIMIT, YLM_ECANCELLED, and what the field returns
** Results  bit-identical whatever the number of threads
** Cost     the field at stats.points points; bookkeeping O(points + occupied)
** Source   Iwasaki & Dobashi 2025, Sec. 5.1
*/
YLM_API ylm_status ylm_grid_bake(const ylm_grid_form *form, const ylm_grid_source *source,
                                 ylm_grid **g, ylm_error *e);

/*
** ylm_grid_judges - the places that have judged a grid with sides in its bake: for another judge, such as paths.
**
**   rows  out  [n][6] places and normals, scene units; NULL: only their number is wanted
**
** Returns  their number, at most 2048; 0: none has, or the grid was loaded
*/
YLM_API size_t ylm_grid_judges(const ylm_grid *g, double (*rows)[6]);
/* The most failures among n of them with which fewer than 1 % of all fail, but for a chance of 1 % (Clopper & Pearson 1934); -1: n
   are too few. */
YLM_API int ylm_grid_allowed(size_t n);
/* The verdict of another judge becomes that of the grid's stats: of so many places, those above the tolerance, the error
   that is exceeded by at most 1 % of all, the largest. */
YLM_API void ylm_grid_verdict(ylm_grid *g, uint64_t verified, uint64_t failed, double error,
                              double largest);
YLM_API void ylm_grid_free(ylm_grid *g);
/* Makes g what another grid is, which is freed. */
YLM_API void ylm_grid_take(ylm_grid *g, ylm_grid *from);

/* -- surfaces: bake/surface.c, bake/occupancy_triangles.c ---------------------- */

/* Triangles with their areas within a box: where held-out points of surfaces are drawn. */
typedef struct ylm_grid_surface ylm_grid_surface;

/*
** ylm_grid_surface_create - the surface of meshes within bounds.
**
**   meshes, mesh  in   they are read as long as the surface lives
**   bounds        in   min x y z, max x y z
**
** Returns  YLM_OK; YLM_EINVAL, YLM_EDOMAIN, YLM_ERANGE (what is wrong stands in `e`), YLM_ENOMEM
** Cost     8 bytes per triangle; O(triangles)
*/
YLM_API ylm_status ylm_grid_surface_create(size_t meshes, const ylm_grid_mesh *mesh,
                                           const double bounds[6], int threads,
                                           ylm_grid_surface **s, ylm_error *e);
YLM_API void ylm_grid_surface_free(ylm_grid_surface *s);
/* The area within the bounds. */
YLM_API double ylm_grid_surface_area(const ylm_grid_surface *s);
/*
** ylm_grid_surface_draw - random point k of a seed, uniform by area.
**
** The triangles, one after the other, are cut into `strata` parts of equal area; draw k lies in
** part k modulo strata. Each part gives one of `strata` draws in a row, and each draw is
** independent of all others. Where the area is 0, all triangles are alike.
**
**   strata    in   1: none
**   position  out  [3] scene units
**   normal    out  [3] unit, to the side from which the triangle is counter-clockwise; (0, 0, 1)
**                  where it has no area
*/
YLM_API void ylm_grid_surface_draw(const ylm_grid_surface *s, uint64_t seed, uint64_t k,
                                   uint64_t strata, double position[3], double normal[3]);

/*
** ylm_grid_surface_voxels - the finest voxels of a grid that the triangles of a source meet.
**
** A voxel counts with its faces, enlarged by 2^-22 of the largest coordinate of the bounds, relative to
** the origin of the surfaces (at most a quarter of an edge): points of a triangle that were rounded to float are in marked voxels.
** Rounding in the test marks too much, never too little.
**
**   g        in   a grid in the making: its form is used
**   code     out  [n] of an octree Morton codes, of a uniform grid places in the lattice, x
**                 fastest; ascending, each once (ylm_free)
**   outside  out  triangles that are not wholly within the bounds are added
**
** Returns  YLM_OK; YLM_EDOMAIN (there are none), YLM_ELIMIT (more than 2^26), YLM_ENOMEM,
**          YLM_ECANCELLED
** Results  the same whatever the number of threads
** Cost     memory: 16 bytes per voxel, 1 bit per voxel of level 8 or of the lattice
*/
YLM_API ylm_status ylm_grid_surface_voxels(const ylm_grid *g, const ylm_grid_source *source,
                                           uint64_t **code, size_t *n, uint64_t *outside,
                                           ylm_error *e);

/* Numbers of points outside, and of points in voxels without data of their own. For such a voxel
   the nearest evaluated ancestor answers, in a uniform grid the nearest voxel that has data. */
typedef struct ylm_grid_report {
  uint64_t outside, unbaked;
  double seconds;
} ylm_grid_report;

/* -- moving lights ------------------------------------------------------------- */

typedef struct ylm_grid_change {
  const ylm_light_set *lights; /* all lights after the change */
  const ylm_field *field;      /* their field */
  double tolerance; /* changes of light below this, relative, are left out; 0: none are left out;
                       negative: an eighth of the grid's tolerance, 1e-3 if it has none */
  bool everywhere;  /* makes continuity anew everywhere, not only around points that came
                      or went: to compare */
  int threads;      /* 0: the default */
  const ylm_progress *progress; /* may be NULL */
} ylm_grid_change;

/*
** ylm_grid_update - bring a dynamic grid up to date after lights moved, appeared or vanished.
**
** Lights are compared with those of the last update: by place in the array, what then differs by
** content; the rest are pairs of before and after. A point remembers with which of its earlier
** states a light was summed. Bounds of value and gradient say how far interpolation may be off,
** relative to the smallest norm at the corners of the point's voxels. Beyond the tolerance the
** point is brought up to date: the earlier state is subtracted and the present one added. Points
** near a light that changed are evaluated with all lights. Then the octree is refined and merged
** from the root as the bake does it. Only new points are evaluated, and unneeded points are
** dropped. Where very many lights changed, everything is baked anew.
**
** Returns  YLM_OK; YLM_EINVAL (not dynamic), YLM_ENOMEM, YLM_ELIMIT, YLM_ECANCELLED, what the field
**          returns. The grid then is as it was; only where memory runs out in the very last step,
**          twice, it is spent: ylm_grid_spent. A grid that is spent gives YLM_EINVAL.
** Results  bit-identical whatever the number of threads
** Threads  the grid must not be read during the call
*/
YLM_API ylm_status ylm_grid_update(ylm_grid *g, const ylm_grid_change *change, ylm_error *e);
/* True while an update runs: the grid must not be used from its progress function. */
YLM_API bool ylm_grid_updating(const ylm_grid *g);
/* True if an update failed and could not be taken back: the grid is good for ylm_grid_free only. */
YLM_API bool ylm_grid_spent(const ylm_grid *g);

/* -- other light: follow/refresh.c ----------------------------------------------------------- */

/*
** ylm_grid_refresh - evaluate a grid's points anew, in another light field or in one that changed.
**
** Values, gradients and metrics of evaluated points are the field's, points in lights or bodies are
** filled from their neighbours, and interpolated ones follow. The octree is what it was: where the
** field is sharper than that of the bake, a promised tolerance is not kept. `met` is then false and
** `error` NaN, unless the bake's own field gave the bake's own values.
**
** Returns  YLM_OK; YLM_EINVAL (a dynamic grid, which has ylm_grid_update), YLM_ENOMEM,
**          YLM_ECANCELLED, what the field returns: the grid then is as it was
** Results  with the field of the bake, the grid is the same to the bit
** Threads  the grid must not be read during the call
** Cost     the field at stats.points points; memory: the evaluated points' rows once more
*/
YLM_API ylm_status ylm_grid_refresh(ylm_grid *g, const ylm_field *field, int threads,
                                    const ylm_progress *progress, ylm_error *e);

/* -- looking inside ---------------------------------------------------------- */

enum {
  YLM_GRID_LEAF = 1,     /* a leaf of the octree (it may have children for continuity only) */
  YLM_GRID_OCCUPIED = 2, /* holds shading points */
  YLM_GRID_BAKED = 4,    /* all eight corners were evaluated */
  YLM_GRID_CROSSED = 8,  /* meets a light's surface */
  YLM_GRID_ADDED = 16,   /* exists for continuity only */
  YLM_GRID_BRICK = 32,   /* of the top of a grid in bricks: a leaf that a brick continues */
  YLM_GRID_SIDED = 64    /* a leaf that surfaces cross: its corners are those of its first part */
};

/* A voxel. Parents stand before their children, the eight children in a row, x fastest. */
typedef struct ylm_grid_cell {
  uint32_t origin[3]; /* lattice coordinates of its lowest corner */
  uint32_t child;     /* index of the first child; 0: none */
  uint32_t source;    /* the cell whose corners are interpolated here: itself or an ancestor */
  uint32_t corner[8]; /* indices of points, x fastest; YLM_GRID_NONE: no data */
  float error;        /* the metric's estimate (mean of eight corners); NaN: unknown */
  float residual;     /* measured relative error at its centre; NaN: not measured */
  uint8_t level;      /* 0 is the root; always 0 in a uniform grid */
  uint8_t flags;
  uint16_t detail; /* no data: level to which sampling descends between evaluated points; 0: none */
} ylm_grid_cell;

enum {
  YLM_GRID_POINT_INVALID = 1,      /* in or on a light: filled from valid neighbours */
  YLM_GRID_POINT_INTERPOLATED = 2, /* from the parent's interpolant, for continuity */
  YLM_GRID_POINT_TESTED = 4,       /* evaluated at first for a residual */
  YLM_GRID_POINT_GHOST = 8         /* stands for a corner that its parts do not see */
};

/*
** Sides of a leaf that surfaces cross. Its box, and a quarter of its edge more on each side, is cut into 6 x 6 x 6 pieces, of
** which those in the middle are its own. A part is a set of pieces that are seen from one place: there light is one function.
*/
#define YLM_GRID_PIECES 216
#define YLM_GRID_PARTS 15 /* of a leaf, at most; as the number of a piece's part: none */
typedef struct ylm_grid_side {
  uint32_t cell, first;              /* the leaf; its first part among all */
  uint32_t parts;                    /* 0: nothing of it is free, and its light is 0 */
  uint8_t part[YLM_GRID_PIECES / 2]; /* of pieces, x fastest: 4 bits each, the lower ones first */
} ylm_grid_side;

/* Pieces along an axis: of the leaf itself, and with the margin. */
#define YLM_GRID_PIECES_OWN 4
#define YLM_GRID_PIECES_ALL 6

/* The part of a piece. */
static inline uint8_t ylm_grid_side_part(const ylm_grid_side *s, size_t piece) {
  return (uint8_t)(s->part[piece / 2] >> 4 * (piece & 1) & 15);
}
/* The part of the piece at a place in edges of the leaf; beyond the margin, of the outermost there. */
static inline uint8_t ylm_grid_side_part_at(const ylm_grid_side *s, const double place[3]) {
  size_t piece = 0;
  for (int a = 2; a >= 0; a--) {
    double at = floor(place[a] * YLM_GRID_PIECES_OWN) + 1, last = YLM_GRID_PIECES_ALL - 1;
    piece = piece * YLM_GRID_PIECES_ALL + (size_t)(at < 0 ? 0 : at > last ? last : at);
  }
  return ylm_grid_side_part(s, piece);
}

/* Where an interpolated point comes from: the interpolant of a cell, which its corners' levels
   precede, at place 0 .. 26 of its 3 x 3 x 3 half-edge lattice, x fastest. */
typedef struct ylm_grid_birth {
  uint32_t cell, place;
} ylm_grid_birth;

/* Everything a grid holds, read-only. */
typedef struct ylm_grid_contents {
  ylm_grid_form form;
  int count;              /* coefficients per channel, (lmax+1)^2 */
  uint32_t resolution[3]; /* lattice cells along each axis: 2^N, or form.cells */
  int root_level; /* of cell 0: 0, but in a brick (ylm_grid_bricks), which is the subtree of that */
  uint32_t root[3]; /* its origin */
  size_t cells;     /* octree cells 0 .. octree_cells-1, then those added for continuity */
  size_t octree_cells;
  const ylm_grid_cell *cell;
  size_t points; /* evaluated points 0 .. evaluated-1, then interpolated ones */
  size_t evaluated;
  const uint32_t *lattice; /* [points][3] lattice coordinates */
  size_t stride;           /* floats from one row of `data` to the next, >= channels*count */
  const float *data;   /* [points][rows][stride]: values [channels][count], then d/dx, d/dy, d/dz */
  size_t rows;         /* 4; 1 in a grid with sides: values alone */
  const float *lambda; /* [points]; NaN where interpolated */
  const float *norm;   /* [points] */
  const uint8_t *flags;        /* [points] YLM_GRID_POINT_* */
  const float *validity;       /* [evaluated] as of ylm_field_result; NULL: the field told none */
  const ylm_grid_birth *birth; /* [points - evaluated]; NULL where there are none */
  size_t sides, parts;         /* of a grid with sides */
  const ylm_grid_side *side;
  const uint32_t (*node)[8]; /* [parts] points at the corners, x fastest */
  const float (*asked)[3];   /* [evaluated] where ghosts' light is from, relative to `origin` */
  const double *origin;      /* [3] */
  const ylm_grid_stats *stats;
} ylm_grid_contents;

YLM_API const ylm_grid_contents *ylm_grid_look(const ylm_grid *g);
/* Scene coordinates of lattice coordinates [3]. */
YLM_API void ylm_grid_position(const ylm_grid *g, const uint32_t lattice[3], double out[3]);
/* Gradients [points][channels count][3] of a grid with sides, whose points are values alone: the means of the slopes of the
   voxels and parts around each. YLM_ENOMEM. */
YLM_API ylm_status ylm_grid_mean_slopes(const ylm_grid *g, float *gradient);
/* The box of a cell: min x y z, max x y z. */
YLM_API void ylm_grid_box(const ylm_grid *g, size_t cell, double out[6]);
/*
** The cell of the octree (or lattice) that holds p: half-open cells, the last ones closed.
** `finest` also descends into cells added for continuity. A point outside gives the cell of the
** nearest point of the bounds, and *outside (may be NULL) is set. YLM_GRID_NONE: a uniform grid
** has no data there.
*/
YLM_API uint32_t ylm_grid_locate(const ylm_grid *g, const double p[3], bool finest, bool *outside);

/* -- back ends: bake/backend.c ------------------------------------------------ */

/* A cell's interpolant (Hermite) at fractions t of its edges, and what it is compared with. */
typedef struct ylm_grid_probe {
  uint32_t corner[8], edge; /* points; lattice units */
  uint32_t point;           /* whose value is exact */
  float t[3];
} ylm_grid_probe;

/* Free places, and the light field there. */
typedef struct ylm_grid_held {
  const float *place; /* [n][3] */
  float *value;       /* [n][channels][count] */
  uint8_t *inside;    /* [n] 1: in or on a light */
} ylm_grid_held;

/* Where the cells and points of a grid in the making are written. */
typedef struct ylm_grid_parts {
  ylm_grid_cell *cell;
  uint32_t *lattice; /* [points][3] */
  size_t stride;     /* of `data` */
  float *data;       /* [points][4][stride]: value and gradient at the lattice position itself */
  float *lambda, *norm;
  uint8_t *flags; /* [points] YLM_GRID_POINT_* */
} ylm_grid_parts;

/* A grid in the making, as its back end sees it. */
typedef struct ylm_grid_making {
  const ylm_grid_source *source;
  ylm_grid *grid;               /* its form, resolution and positions hold */
  ylm_grid_parts parts;         /* as they are at the call */
  ylm_grid_stats *stats;        /* pairs, outside, field_seconds: the back end adds its own */
  const ylm_progress *progress; /* of the stage at hand; may be NULL */
  ylm_error *e;
} ylm_grid_making;

typedef enum ylm_grid_rows {
  YLM_GRID_ROWS_ALL,  /* of points 0 .. n-1, to `row` */
  YLM_GRID_ROWS_TAKE, /* of the points listed, to `row` */
  YLM_GRID_ROWS_PUT,  /* of the points listed, from `row` */
  YLM_GRID_ROWS_LEAVE /* as ALL; then the back end is asked for `shading` alone */
} ylm_grid_rows;

/*
** ylm_grid_backend - who finds, evaluates and keeps the points of a grid in the making.
**
** One loop makes every grid (bake/refine.c). Level by level it asks for the corners of the voxels,
** the light field at new points and the metric; with a tolerance, for residuals; for all rows at
** the end. The processor's back end is bake/processor.c, those of a device csrc/vulkan/grid. Back
** ends are of two kinds:
**
**   with corners and metric   keeps cells and points until `rows`
**   without (NULL)            cells are the processor's: it evaluates points and keeps their rows.
**                             Where its memory runs out (YLM_ENOMEM, YLM_ELIMIT), the bake takes
**                             the rows there are and goes on with the processor and the field alone
**
**   occupied   asked first: finds the voxels that hold shading points. A back end that keeps cells
**              says how many voxels level 0 has (*n). Another may write Morton codes of an octree's
**              finest voxels, sorted, each once, as many as *n (ylm_alloc); *code NULL: the
**              processor finds them
**   shading    shading points of n indices, in float, [n][3]; asked where the source has none
**   corners    of the voxels of a level, which `occupied` or `metric` of the level before has made;
**              *fresh of them are new points
**   evaluate   the n new points: of the processor's, the next behind those that were evaluated, at
**              parts.lattice; writes parts.lambda, norm (saturated as a field's) and the flag
**              YLM_GRID_POINT_INVALID of those in a light
**   metric     error of a level's voxels, and which of them lights' surfaces cross; by a threshold
**              those above it, and crossed ones, are split. The next level has *next voxels
**   residuals  relative distances [n] of interpolants from the values of their points; with `held`,
**              from those of the field at free places, which probe.point counts, and which it
**              writes
**   rows       of n points, [n][4][stride]; a back end that keeps cells is asked for
**              YLM_GRID_ROWS_ALL alone and writes all parts, for which ylm_grid_room makes room
*/
struct ylm_grid_backend {
  void *self;
  ylm_status (*occupied)(void *self, const ylm_grid_making *m, uint64_t **code, size_t *n);
  ylm_status (*shading)(void *self, const ylm_grid_making *m, size_t n, const size_t *index,
                        float *out);
  ylm_status (*corners)(void *self, const ylm_grid_making *m, int level, size_t *fresh);
  ylm_status (*evaluate)(void *self, const ylm_grid_making *m, size_t n);
  ylm_status (*metric)(void *self, const ylm_grid_making *m, int level, size_t *next);
  ylm_status (*residuals)(void *self, const ylm_grid_making *m, size_t n,
                          const ylm_grid_probe *probe, const ylm_grid_held *held, double *distance);
  ylm_status (*rows)(void *self, const ylm_grid_making *m, ylm_grid_rows which, size_t n,
                     const uint32_t *point, float *row);
};

/*
** ylm_grid_room - room for cells and points of a grid in the making whose back end keeps the cells.
**
** Of a cell it writes origin, level, child, error, corner and the flags LEAF, OCCUPIED, CROSSED;
** cells 0 .. n-1 are an octree: parents before their children. Corners are YLM_GRID_NONE where a
** cell is not occupied; the bake finds those that were evaluated for its neighbours. Of a uniform
** grid all cells are occupied, at level 0, in the order of the lattice, x fastest. Room may be
** asked for more than once: what was written is kept, at another address. In the end the grid has
** as many cells and points as were asked for.
**
** Returns  YLM_OK, YLM_ENOMEM, YLM_ELIMIT
*/
YLM_API ylm_status ylm_grid_room(ylm_grid *g, size_t cells, size_t points, ylm_grid_parts *parts,
                                 ylm_error *e);
YLM_API ylm_grid_stats *ylm_grid_stats_of(ylm_grid *g);
/* The voxel of the finest lattice that holds p, outside the nearest one; true if p was inside. */
YLM_API bool ylm_grid_voxel(const ylm_grid *g, const double p[3], uint32_t voxel[3]);

/* -- sampling ---------------------------------------------------------------- */

typedef enum ylm_grid_interpolation {
  YLM_GRID_HERMITE = 0, /* fourth order, symmetric, continuous */
  YLM_GRID_TAYLOR = 1,  /* trilinear mean of the corners' first-order expansions */
  YLM_GRID_LINEAR = 2   /* trilinear */
} ylm_grid_interpolation;

typedef struct ylm_grid_query {
  ylm_grid_interpolation interpolation;
  bool nan_outside;             /* points outside get NaN; else those of the nearest point inside */
  ylm_dtype point_dtype, dtype; /* of points, of results */
  int threads;                  /* 0: the default */
  const ylm_progress *progress; /* may be NULL */
  const double *origin;         /* [3] points are relative to it; NULL: to 0 */
  /* In a grid with sides: normals [n][3] of length 1 of the surfaces that the points lie on, to the side that is seen (NULL:
     they lie in free space). A point's part is one that it sees among walls; NULL: that of the piece in front of it. */
  const float (*normals)[3];
  const ylm_grid_walls *walls;
} ylm_grid_query;

/*
** ylm_grid_sample - interpolate coefficients at n points.
**
**   points    in   [n][3]                        any finite position
**   value     out  [n][channels][count]
**   gradient  out  [n][channels][count][3]       of the interpolant; NULL: not wanted
**   report    out  may be NULL
**
** Returns  YLM_OK, YLM_ENOMEM, YLM_ECANCELLED (results are then incomplete)
** Results  bit-identical whatever the number of threads and the order of points
** Cost     32 multiply-adds per coefficient; fastest where neighbours in the array share a cell
*/
YLM_API ylm_status ylm_grid_sample(const ylm_grid *g, const ylm_grid_query *q, size_t n,
                                   const void *points, void *value, void *gradient,
                                   ylm_grid_report *report, ylm_error *e);

enum {
  YLM_GRID_SAMPLE_OUTSIDE = 1, /* outside of the bounds */
  YLM_GRID_SAMPLE_UNBAKED = 2, /* in a voxel without data of its own */
  YLM_GRID_SAMPLE_BURIED = 4   /* in a body: dark where nothing of the voxel is free */
};

/*
** ylm_grid_flags - what ylm_grid_report counts, point by point.
**
**   dtype, points  in   [n][3] any finite position
**   type, flags    out  [n] YLM_GRID_SAMPLE_*, or 0, as numbers of that type
**
** Returns  YLM_OK
*/
YLM_API ylm_status ylm_grid_flags(const ylm_grid *g, size_t n, ylm_dtype dtype, const void *points,
                                  ylm_dtype type, void *flags, int threads);

/*
** Points that stay where they are while a dynamic grid changes. Their voxels are found once, as
** long as the octree there is what it was. Points are sampled only where samples may differ from
** those of the last time. Every cell of a dynamic grid has a signature of what its samples depend
** on; equal signatures mean equal samples, but for one chance in 2^64.
*/
typedef struct ylm_grid_track ylm_grid_track;

/*
** ylm_grid_track_create - n points to be followed.
**
**   points  in   [n][3]; read as long as the track lives
**   origin  in   [3] points are relative to it; NULL: to 0
**   order   in   [n] the points, neighbours near one another, or NULL: as they come. Each block of
**                YLM_GRID_TRACK in this order is sampled cell by cell
**
** Memory  16 bytes per point, 32 per cell and block
** Returns  YLM_OK, YLM_ENOMEM, YLM_ELIMIT (more than 2^32 points)
*/
#define YLM_GRID_TRACK 4096
YLM_API ylm_status ylm_grid_track_create(size_t n, const float *points, const double *origin,
                                         const uint32_t *order, ylm_grid_track **track);
YLM_API void ylm_grid_track_free(ylm_grid_track *track);

/*
** The receiver of samples, called on any of the threads, once for each point that is sampled.
**
**   announce  of the n <= 32 points `point`, whose samples come next: time to fetch what goes with
**             them; may be NULL
**   take      their coefficients [channels][count] begin every `row` floats
*/
typedef struct ylm_grid_taker {
  void (*announce)(void *user, size_t n, const uint32_t *point);
  void (*take)(void *user, size_t n, const uint32_t *point, size_t row, const float *value);
  void *user;
} ylm_grid_taker;

/*
** ylm_grid_track_sample - sample the points whose samples may have changed since the last time.
**
** Another grid, or another interpolation, is sampled everywhere where it is not the same; after a
** failure that is everything that was not handed over.
**
**   fresh   out  points that were handed over
**   report  out  outside and unbaked, of all points
**
** Returns  YLM_OK; YLM_EINVAL (the grid is not dynamic, or had no memory for signatures: nothing is
**          sampled, and the next time everything is), YLM_ENOMEM, YLM_ECANCELLED (stage "shading")
** Results  those of ylm_grid_sample
** Threads  one track is for one caller at a time
*/
YLM_API ylm_status ylm_grid_track_sample(ylm_grid_track *track, const ylm_grid *g,
                                         ylm_grid_interpolation how, int threads,
                                         const ylm_progress *progress, const ylm_grid_taker *taker,
                                         uint64_t *fresh, ylm_grid_report *report);

/* The grid as a light field (Hermite, clamped): value, gradient, and lambda and norm interpolated.
   The field has no Hessian, and no degree above the grid's. */
YLM_API const ylm_field *ylm_grid_field(const ylm_grid *g);

/* -- bricks: brick/ ------------------------------------------------------------- */

/*
** Grids that do not fit into memory. The octree below each cell of a level is a brick, which is baked
** alone and kept as a file of its own. A bake goes on where it was when it is called again.
*/
typedef struct ylm_grid_bricks {
  const char *folder; /* "name.ylmd", made where it is not there */
  int level;          /* of the bricks: 1 .. depth - 2; 0: 3, or as deep as may be */
  size_t points;      /* evaluated points of a brick before its children take its place; 0: 65536 */
  /* Of one thread: fewer points where they are foreseen to take longer, at 0.18 ns for each light, point and coefficient,
     counted in the top; 0: 30 if points is 0, else any time. */
  double brick_seconds;
  bool fresh; /* begins anew whatever is in the folder */
  bool alone; /* the light field is asked by one thread at a time */
  /* No brick is begun that would take longer than this since the call; 0: for ever. */
  double seconds;
} ylm_grid_bricks;

/*
** ylm_grid_bake_bricks - make a grid in bricks, or go on with it.
**
**   form    in  adaptive, not dynamic, without sides, with measure YLM_GRID_COEFFICIENTS
**   source  in  as of ylm_grid_bake, without back end; max_points is of the sum over bricks
**
** Returns  as ylm_grid_bake; YLM_EINVAL also where the folder is another bake's, YLM_EBUSY where another
**          process bakes into it, YLM_EIO; YLM_ELIMIT also where how->seconds are over: "not finished",
**          to be called again
** Teams    processes of source->team take bricks one after another; the folder's file system is theirs
**          in common. A file of another one is awaited for 60 seconds
** Results  the files are the same to the bit whatever the number of threads, and of interruptions. With a
**          threshold and a field that does not depend on blocks of points, samples are those of
**          ylm_grid_bake
** Memory   the source, the top (levels down to the bricks'), and for each thread a brick
*/
YLM_API ylm_status ylm_grid_bake_bricks(const ylm_grid_form *form, const ylm_grid_source *source,
                                        const ylm_grid_bricks *how, ylm_error *e);

/* A grid in bricks, some of which are in memory. */
typedef struct ylm_grid_set ylm_grid_set;

/*
** ylm_grid_set_open - a folder that a bake in bricks has finished.
**
**   cache  in  bytes of bricks that are kept in memory, of those used last; 0: 256 MB. A brick larger
**              than that is there alone
**
** Returns  YLM_OK; YLM_EIO (no such folder, or not finished), YLM_EFORMAT, YLM_ECHECKSUM, YLM_ENOMEM
*/
YLM_API ylm_status ylm_grid_set_open(const char *folder, size_t cache, ylm_grid_set **s,
                                     ylm_error *e);
YLM_API void ylm_grid_set_free(ylm_grid_set *s);
/* The levels above the bricks, whose cells that go on are flagged YLM_GRID_BRICK; stats are of all. */
YLM_API const ylm_grid_contents *ylm_grid_set_look(const ylm_grid_set *s);
typedef struct ylm_grid_set_stats {
  uint64_t bricks, level; /* the level that was asked for */
  uint64_t bytes;         /* of all files of bricks */
  uint64_t held, reads;   /* bytes in memory; files that were read so far */
} ylm_grid_set_stats;
YLM_API ylm_grid_set_stats ylm_grid_set_stats_of(const ylm_grid_set *s);
/* The file of brick 0 .. bricks-1, or, behind them, of the top; false where `room` bytes are too few, or there is none. */
YLM_API bool ylm_grid_set_file(const ylm_grid_set *s, size_t brick, char *path, size_t room);
/*
** ylm_grid_set_sample - as ylm_grid_sample. Points are taken brick by brick: a call reads each brick
** that it needs once at most, if that fits into the cache.
**
** Returns  also what reading a brick does; results are then incomplete
** Threads  one call at a time: others wait
*/
YLM_API ylm_status ylm_grid_set_sample(ylm_grid_set *s, const ylm_grid_query *q, size_t n,
                                       const void *points, void *value, void *gradient,
                                       ylm_grid_report *report, ylm_error *e);
/*
** ylm_grid_set_pack - all bricks as one grid in memory, which ylm_grid_write saves.
**
** Returns  YLM_OK; YLM_ENOMEM, YLM_ELIMIT (more than 2^32 points or cells), YLM_ECANCELLED (stage
**          "packing"), what reading a brick does
** Results  it samples as the set, to the bit
*/
YLM_API ylm_status ylm_grid_set_pack(ylm_grid_set *s, int threads, const ylm_progress *progress,
                                     ylm_grid **g, ylm_error *e);
/*
** ylm_grid_set_write - all bricks as one file: that of ylm_grid_set_pack and ylm_grid_write, with one brick in memory at a time.
**
** Returns  as ylm_grid_set_pack; YLM_EIO. `path` is as it was then
** Memory   the set's cache, and 16 to 64 bytes for each point on faces between bricks
*/
YLM_API ylm_status ylm_grid_set_write(ylm_grid_set *s, const char *path, int threads,
                                      const ylm_progress *progress, ylm_error *e);
/* The set as a light field, as ylm_grid_field. */
YLM_API const ylm_field *ylm_grid_set_field(const ylm_grid_set *s);

/* -- files ------------------------------------------------------------------- */

#define YLM_GRID_MAGIC "\x89YLMgrid" /* the first 8 bytes of a grid file */

/* Writes the file (version 2, docs/grids.md) whole or not at all. Equal grids give equal bytes:
   times are not in it. YLM_EIO, YLM_ENOMEM; YLM_EFORMAT where this machine is big-endian. */
YLM_API ylm_status ylm_grid_write(const ylm_grid *g, const char *path, ylm_error *e);
/* Encodes the file into memory; the caller frees *data with ylm_free. */
YLM_API ylm_status ylm_grid_encode(const ylm_grid *g, unsigned char **data, size_t *size,
                                   ylm_error *e);

/* -- numbers for engines: engine/ ------------------------------------------------ */

/*
** A lattice of equal cells, at whose middles an engine has numbers, and places of surfaces where it looks light up. It interpolates
** the numbers along the axes, beyond the outermost middles they stay; irradiance is the sum of `basis` and the numbers there.
*/
typedef struct ylm_grid_fit {
  uint32_t cells[3];
  int numbers, channels; /* of a probe; of the light */
  size_t places;
  const double (*at)[3]; /* [places] where the engine looks, in cells: middles are at 0.5, 1.5 .. */
  const float *basis;    /* [places][numbers] */
  const float *wanted;   /* [places][channels] irradiance; of ylm_grid_fit_look NULL */
  const float *weight;   /* [places] of squared errors; of ylm_grid_fit_look NULL */
  /* [probes], [numbers]: the product is the weight of the squared distance of a number from what it was; of ylm_grid_fit_look NULL */
  const float *hold, *norm;
  float *probe; /* [probes][channels][numbers], x fastest */
  /* In the place of `cells` and `at`: the probes around each place, and their shares. NULL: a lattice's. */
  size_t probes;
  const size_t *first;    /* [places + 1] rows of the next two */
  const uint32_t *around; /* [first[places]] */
  const float *share;     /* [first[places]] */
  bool quick;             /* few steps: to compare lattices */
  int threads;            /* 0: the default */
} ylm_grid_fit;

/*
** ylm_grid_fit_probes - the numbers with the least squared error at the places, in the place of those that there were.
**
** A place whose `wanted` is 0 has no error where less than 0 is read: engines show nothing below 0.
**
** Returns  YLM_OK, YLM_ENOMEM
** Results  the same whatever the number of threads
*/
YLM_API ylm_status ylm_grid_fit_probes(const ylm_grid_fit *f);
/* The irradiance that an engine reads at the places: out [places][channels], at least 0. YLM_ENOMEM. */
YLM_API ylm_status ylm_grid_fit_look(const ylm_grid_fit *f, float *out);

/* -- probes for engines: probes/ ------------------------------------------------ */

/*
** A grid's light as engines take it at run time: irradiance as polynomials of the normal, at the corners of bricks, between which
** it is interpolated along the axes. The bounds are cut into roots, each an octree. A leaf has a brick for each part of its free
** space. docs/engines.md describes the file.
*/
typedef struct ylm_grid_probes ylm_grid_probes;

/* The size of probes. */
typedef struct ylm_grid_probes_size {
  double bounds[6];
  uint32_t roots[3];
  int lmax;
  ylm_quantity quantity;
  size_t cells, leaves_of_several, bricks;
  size_t points; /* less those between others */
} ylm_grid_probes_size;

/* Bytes of the file of probes. */
typedef struct ylm_grid_probes_bytes {
  size_t all;
  size_t points, means; /* points in the file; those that are the mean of others */
  size_t names;         /* numbers of points in it */
  size_t rest;          /* bytes beside these */
} ylm_grid_probes_bytes;

/* Places of surfaces to which probes are fitted. */
typedef struct ylm_grid_probes_places {
  size_t n;
  const double (*point)[3]; /* [n] scene units */
  const float (*normal)[3]; /* [n] unit */
  const float (*wanted)[3]; /* [n] irradiance */
  const float *weight;      /* [n] of squared errors */
  /* Weights of the squared distance from what a point was; of points that no brick's part sees. */
  double hold, hold_ghosts;
  bool quick;  /* few steps */
  int threads; /* 0: the default */
} ylm_grid_probes_places;

/*
** ylm_grid_probes_make - the bricks and points of a grid.
**
**   lmax  in   1 or 2: degree of the polynomials
**   cuts  in   0 .. 3: how often leaves are halved whose points have slopes, which probes have not
**   walls, at  in  by which planes between the bricks of a leaf are found; NULL: by the pieces of the grid's leaves
**   p     out  ylm_grid_probes_free; NULL on failure
**
** Returns  YLM_OK, YLM_ERANGE (lmax, cuts), YLM_ENOMEM, YLM_ELIMIT (2^32 cells or points)
*/
YLM_API ylm_status ylm_grid_probes_make(const ylm_grid *g, int lmax, int cuts,
                                        const ylm_grid_walls *walls,
                                        const ylm_grid_probes_places *at, ylm_grid_probes **p,
                                        ylm_error *e);
YLM_API void ylm_grid_probes_free(ylm_grid_probes *p);
/* Another of the same; YLM_ENOMEM. */
YLM_API ylm_status ylm_grid_probes_copy(const ylm_grid_probes *p, ylm_grid_probes **copy);
YLM_API ylm_grid_probes_size ylm_grid_probes_look(const ylm_grid_probes *p);
/* Irradiance at places of surfaces, at least 0: out [n][3]. */
YLM_API void ylm_grid_probes_irradiance(const ylm_grid_probes *p, size_t n,
                                        const double (*points)[3], const float (*normals)[3],
                                        float (*out)[3]);

/*
** The numbers with the least squared error at the places. Points that hang on larger leaves are the mean of theirs then, so that
** light is continuous there. YLM_ENOMEM, YLM_ELIMIT (leaves of less than 2^-20 of the longest edge). Results: the same for any
** number of threads.
*/
YLM_API ylm_status ylm_grid_probes_fit(ylm_grid_probes *p, const ylm_grid_probes_places *at);
/* Joins points of a brick, those first that cost the least squared error at the places, until at most so many are left; bricks of a
   leaf that are then the same are one. YLM_ENOMEM. */
YLM_API ylm_status ylm_grid_probes_thin(ylm_grid_probes *p, const ylm_grid_probes_places *at,
                                        size_t points);

/*
** ylm_grid_probes_encode, ylm_grid_probes_decode - the file.
**
**   bits  in   6 .. 16 of a number
**
** Returns  YLM_OK, YLM_ERANGE (bits), YLM_ENOMEM; of decode also YLM_EFORMAT (no such file, or one that cannot be), YLM_ECHECKSUM (damaged),
**          YLM_EVERSION
*/
YLM_API ylm_status ylm_grid_probes_encode(const ylm_grid_probes *p, int bits, unsigned char **data,
                                          size_t *size, ylm_error *e);
YLM_API ylm_status ylm_grid_probes_decode(const unsigned char *data, size_t size, const char *name,
                                          ylm_grid_probes **p, ylm_error *e);
YLM_API ylm_status ylm_grid_probes_measure(const ylm_grid_probes *p, int bits,
                                           ylm_grid_probes_bytes *b);

/* -- few bytes: small/ --------------------------------------------------------- */

/* How few, or how exact: one of tolerance, bytes and step. */
typedef struct ylm_grid_small {
  double tolerance; /* of the light, as that of a bake: of what is decoded, in all; 0: none */
  uint64_t bytes;   /* of the file, at most; 0: none */
  double step;      /* of rounding, relative to the light's norm; 0: it is found */
  int threads;      /* 0: the default */
  const ylm_progress *progress; /* may be NULL; stage "rounding" */
} ylm_grid_small;

/* The promise of a small file. Errors are of the grid's measure. */
typedef struct ylm_grid_small_report {
  double error; /* in all: 99 % of all places err by less; NaN: the grid's own error is not known */
  double confidence; /* of that */
  double before;     /* what interpolation alone errs by: the grid's own error; NaN: not known */
  double rounding;   /* of decoded light against the grid's: 99 % of the places looked at */
  double largest;    /* of these */
  double middle;     /* the median of the total where a panel judged it, else of rounding */
  uint64_t places;   /* places looked at */
  /* 1: the bake's own held-out places, with exact light; 0: error is the sum of before and largest. */
  uint64_t judged;
  double step; /* relative to the light's norm */
} ylm_grid_small_report;

/*
** ylm_grid_encode_small - a grid as a file of few bytes, within a tolerance or within a number of bytes.
**
** Points are predicted from points before them, and what is left is turned, rounded and counted (docs/grids.md, "Few bytes").
** Decoded light is measured before the file is written: at the places that judged the bake where the grid is from one, else by
** the triangle inequality at 16,384 random ones.
**
**   data, size  out  the file (ylm_free); NULL on failure
**   report      out  may be NULL
**
** Returns  YLM_OK; YLM_EINVAL (a dynamic grid; not one of tolerance, bytes and step), YLM_EDOMAIN (one of these is out of
**          range; light that is not finite), YLM_ELIMIT (the grid itself errs by more than the tolerance; so few bytes do not
**          do), YLM_ENOMEM, YLM_ECANCELLED
** Results  decoded rows are the same on every machine, whatever the kernel set and number of threads
*/
YLM_API ylm_status ylm_grid_encode_small(const ylm_grid *g, const ylm_grid_small *how,
                                         unsigned char **data, size_t *size,
                                         ylm_grid_small_report *report, ylm_error *e);
/*
** ylm_grid_pack - the rows of a grid's points in words of one size, for devices and engines.
**
** A coefficient is a word: its value in the lowest YLM_PACKED_VALUE bits, its slopes by x, y, z in YLM_PACKED_SLOPE bits each
** above them, whole numbers with a sign. They count units of the point: one of values, one of slopes, as floats in two words
** behind the coefficients.
**
**   word     out  [points][width + 2], where width = channels * count
**   report   out  what rounding alone errs by, in the grid's measure
**
** Returns  YLM_OK; YLM_EINVAL (a grid with sides), YLM_EDOMAIN (light that is not finite), YLM_ENOMEM
** Cost     O(points width), and 16,384 samples of two grids
*/
#define YLM_PACKED_VALUE 11
#define YLM_PACKED_SLOPE 7
typedef struct ylm_grid_packing {
  double error;    /* the sum of the grid's own and of rounding; NaN: the grid's is not known */
  double rounding; /* 99 % of random places err by less */
  double largest;  /* of these */
  uint64_t places; /* looked at */
} ylm_grid_packing;
YLM_API ylm_status ylm_grid_pack(const ylm_grid *g, int threads, uint32_t *word,
                                 ylm_grid_packing *report, ylm_error *e);

/* Gives a file of a grid in memory, which holds it to the bit, the stats and the tolerance that the grid has by now: another
   judge may have spoken. YLM_EFORMAT: it is no file of such a grid. */
YLM_API ylm_status ylm_grid_restate(unsigned char *data, size_t size, const ylm_grid *g,
                                    ylm_error *e);
/* The places that judged a bake, with their light, become those of a grid that was decoded from it. */
YLM_API void ylm_grid_inherit(ylm_grid *to, ylm_grid *from);
/* The report that a small file has; false: the grid was not read from one. */
/* Constants of the format, for decoders in other languages (the viewer of pages). */
typedef struct ylm_grid_small_constant {
  const char *name;
  double value;
} ylm_grid_small_constant;
YLM_API const ylm_grid_small_constant *ylm_grid_small_constants(size_t *n);
YLM_API bool ylm_grid_small_of(const ylm_grid *g, ylm_grid_small_report *report);
/*
** ylm_grid_set_write_small - a grid in bricks as another folder, in few bytes (ylm_grid_encode_small), each brick read alone.
**
**   folder   in   new, or one that this function made, whose files are removed first
**   bytes    out  of its bricks, its top and its index
**   report   out  NULL: not asked for. The error is the sum of the grid's own and the largest rounding; nothing judges it
**
** Bricks are rounded by one step, one brick in memory at a time. Points on their borders are the same bits in each.
** Returns  YLM_OK; YLM_EINVAL, YLM_EDOMAIN (what is asked for; a folder of a bake), YLM_ELIMIT (cannot be had), YLM_EIO,
**          YLM_ENOMEM, YLM_ECANCELLED (stage "rounding"), what reading a brick does; the folder is removed then
*/
YLM_API ylm_status ylm_grid_set_write_small(ylm_grid_set *s, const char *folder,
                                            const ylm_grid_small *how, uint64_t *bytes,
                                            ylm_grid_small_report *report, ylm_error *e);
/* The report of a folder of few bytes; false: it is none. */
YLM_API bool ylm_grid_set_small_of(const ylm_grid_set *s, ylm_grid_small_report *report);

/* A part of a small file: where it stands in the file's bytes. */
typedef struct ylm_grid_small_part {
  const char *name;
  const unsigned char *data; /* [size] */
  size_t size;
} ylm_grid_small_part;
#define YLM_GRID_SMALL_PARTS 7
/* The parts that points are decoded from: head, tree, bases, tables, points, numbers, bits (docs/grids.md, "Few bytes").
   YLM_EFORMAT: it is no small file. */
YLM_API ylm_status ylm_grid_small_parts(const unsigned char *data, size_t size,
                                        ylm_grid_small_part part[YLM_GRID_SMALL_PARTS],
                                        ylm_error *e);

/*
** ylm_grid_read, ylm_grid_decode - a grid from a file, or from its bytes.
**
** Coefficients of evaluated points are those of the file, to the bit. Interpolated points are made
** again by the kernel set in use: where it is that of the writer, the grid samples as the one that
** was saved, to the bit. Times of stats are NaN.
**
** Returns  YLM_OK; YLM_EFORMAT (no grid file, or one that cannot be), YLM_ECHECKSUM (damaged),
**          YLM_EVERSION (another version, or a section that is required and not known), YLM_EIO,
**          YLM_ENOMEM, YLM_ELIMIT
** Memory   at most 105 times the file's rows, whatever the file says: at most 104 points are
**          interpolated for an evaluated one (in most grids about 1.5)
*/
YLM_API ylm_status ylm_grid_read(const char *path, ylm_grid **g, ylm_error *e);
YLM_API ylm_status ylm_grid_decode(const unsigned char *data, size_t size, const char *name,
                                   ylm_grid **g, ylm_error *e);

#define YLM_GRID_SECTION_NAME 24 /* bytes of a section's name, the last one 0 */

/* A part of a grid file. */
typedef struct ylm_grid_file_section {
  char name[YLM_GRID_SECTION_NAME];
  uint64_t offset, size; /* bytes */
  uint32_t record;       /* bytes of one of its records */
  bool required;         /* readers that do not know it refuse the file */
  bool known;            /* to this library */
} ylm_grid_file_section;

/* The description of a grid file. */
typedef struct ylm_grid_file_info {
  uint32_t version;
  uint64_t size; /* bytes of the file */
  ylm_grid_form form;
  ylm_grid_stats stats; /* as far as files have them */
  bool is_small;        /* it is of few bytes, and says how few: */
  ylm_grid_small_report small;
  size_t sections;
  ylm_grid_file_section *section;
} ylm_grid_file_info;

/*
** ylm_grid_file_look - what is in a grid file, from its header, table and first two sections alone.
** ylm_grid_file_forget frees it.
**
** Returns  as ylm_grid_read
*/
YLM_API ylm_status ylm_grid_file_look(const char *path, ylm_grid_file_info *info, ylm_error *e);
YLM_API void ylm_grid_file_forget(ylm_grid_file_info *info);

#ifdef __cplusplus
}
#endif
#endif
