/* grid.h - the inside of a grid, shared by the files of this folder. */
#ifndef YLM_GRID_PRIVATE_H
#define YLM_GRID_PRIVATE_H

#include "ylm_grid.h"

#define ROWS 32 /* what a voxel's interpolant is made of: 8 corners x (value, 3 derivatives) */

/* Points by lattice coordinates. */
typedef struct lattice_hash {
  uint64_t *key;
  uint32_t *value;
  size_t size, used; /* size is a power of two */
} lattice_hash;

struct ylm_grid {
  ylm_grid_view view; /* its pointers are the arrays below */
  ylm_grid_stats stats;
  ylm_field field;

  ylm_grid_cell *cell;
  size_t cells, cell_room;

  uint32_t *lattice; /* [points][3] */
  float *data;       /* [points][4][stride], and some floats of padding behind the last */
  float *lambda, *norm;
  uint8_t *flags;
  size_t points, point_room, evaluated, stride;

  /* Where interpolated points come from, in their order: [points - evaluated]. */
  struct grid_birth *birth;
  size_t birth_room;

  lattice_hash hash; /* evaluated points */
  uint32_t width;    /* channels * count */
  /* Cells by coarse lattice coordinates: [top[2]][top[1]][top[0]], to begin a descent. */
  uint32_t *table, top[3];
  int top_shift;   /* lattice coordinate >> top_shift is a coordinate of the table */
  double scale[3]; /* lattice cells per scene unit */

  struct grid_dynamic *dynamic; /* what updates need (dynamic.h); NULL: the grid stays as it is */
  bool updating;
};

/* An interpolated point is the interpolant of a cell at place 0 .. 26 of its 3 x 3 x 3 half-edge
   lattice. */
typedef struct grid_birth {
  uint32_t cell, place;
} grid_birth;

/* -- store.c: cells and points ------------------------------------------------- */

ylm_grid *ylm__grid_new(const ylm_grid_form *form);
/* Checks what can be checked of a form; the sentence names the field. */
ylm_status ylm__grid_check_form(const ylm_grid_form *form, ylm_error *e);
/* The same of a source. */
ylm_status ylm__grid_check_source(const ylm_grid_source *s, bool dynamic, ylm_error *e);
/* Room for `more` cells or points beyond those there are. */
ylm_status ylm__grid_reserve_cells(ylm_grid *g, size_t more);
ylm_status ylm__grid_reserve_points(ylm_grid *g, size_t more);
/* Eight children of a cell, with origins and levels; the index of the first through *first. */
ylm_status ylm__grid_split(ylm_grid *g, uint32_t cell, uint32_t *first);
/* Edge of a cell in lattice units. */
static inline uint32_t ylm__grid_edge(const ylm_grid *g, const ylm_grid_cell *c) {
  return g->view.form.kind == YLM_GRID_UNIFORM ? 1u : 1u << (g->view.form.depth - c->level);
}
static inline const float *ylm__grid_row(const ylm_grid *g, uint32_t point, int row) {
  return g->data + ((size_t)point * 4 + (size_t)row) * g->stride;
}
/* Flags the octree's cells whose corners were all evaluated. */
void ylm__grid_find_baked(ylm_grid *g);
/* Brings the view up to date; counts cells and points into the stats. */
void ylm__grid_sync(ylm_grid *g);
void ylm__grid_count(ylm_grid *g);
/* Finds each leaf's source of data, counts, builds the table: what sampling needs. */
ylm_status ylm__grid_finish(ylm_grid *g);
/* Lattice coordinates (with fractions, clamped into the bounds) of a point; true if it was inside.
 */
bool ylm__grid_coordinates(const ylm_grid *g, const double p[3], double out[3]);
/* The leaf under clamped lattice coordinates; the box moves the coordinates where a uniform grid
   has no data. */
uint32_t ylm__grid_leaf(const ylm_grid *g, const double at[3]);

/* -- lattice.c: Morton codes and the hash of points ------------------------------ */

/* Interleaves 16 bits of each coordinate, x lowest. */
uint64_t ylm__morton(uint32_t x, uint32_t y, uint32_t z);

static inline uint64_t lattice_key(const uint32_t at[3]) {
  return (uint64_t)at[0] | (uint64_t)at[1] << 21 | (uint64_t)at[2] << 42;
}
ylm_status lattice_hash_reserve(lattice_hash *h, size_t entries);
/* The value's place: *value is YLM_GRID_NONE where the key is new. Room must have been reserved. */
uint32_t *lattice_hash_at(lattice_hash *h, uint64_t key);
/* The value of a key, YLM_GRID_NONE if there is none. */
uint32_t lattice_hash_find(const lattice_hash *h, uint64_t key);
/* Forgets a key, if it is there. */
void lattice_hash_remove(lattice_hash *h, uint64_t key);
void lattice_hash_free(lattice_hash *h);

/* -- occupancy.c: which voxels hold shading points -------------------------------- */

/*
** An occupancy octree. Down to DENSE levels it is one bit per node, bottom-up; deeper levels are
** sorted Morton codes of the finest nodes, whose prefixes are the ancestors.
*/
typedef struct occupancy {
  bool all;         /* every voxel is occupied */
  int depth;        /* of the finest level */
  int dense;        /* bits are kept for levels 0 .. dense */
  uint8_t *bits[9]; /* by level, in Morton order */
  uint64_t *code;   /* depth > dense: sorted, unique */
  size_t codes;
} occupancy;
ylm_status occupancy_build(occupancy *o, const ylm_grid *g, const ylm_grid_source *s,
                           uint64_t *outside);
/* Uniform grids: one byte per voxel. */
ylm_status occupancy_mark_uniform(const ylm_grid *g, const ylm_grid_source *s, uint8_t *mark,
                                  uint64_t *outside);
bool occupancy_test(const occupancy *o, int level, const uint32_t node[3]);
void occupancy_free(occupancy *o);

/* -- bake.c ------------------------------------------------------------------------ */

/* A list of cells. */
typedef struct cell_list {
  uint32_t *cell;
  size_t n, room;
} cell_list;
ylm_status cell_list_push(cell_list *list, uint32_t cell);

/* What the field writes for a block of points. */
typedef struct field_block {
  float *position, *value, *gradient, *lambda, *norm;
  float *hessian; /* [n][hessian_channels][count][6]; NULL where the grid is not dynamic */
  int hessian_channels;
  uint8_t *inside;
  size_t room; /* points */
} field_block;

/* A bake under way. */
typedef struct baker {
  ylm_grid *g;
  const ylm_grid_source *source;
  ylm_error *e;
  occupancy occupied;
  cell_list wave, next; /* cells to decide about, their children that come next */
  field_block block;
  const char *stage; /* for progress */
  char stage_text[48];
  uint8_t *used; /* updates: by point, whether a cell or a test wants it; else NULL */
  size_t used_room;
  /* Updates: the cells before, which new cells in the same place (cell.source, while baking) take
     corners, residuals and crossings from, as far as these cannot have changed; else NULL. */
  const ylm_grid_cell *before;
  const uint8_t *changed;  /* by point that was there */
  const double *unsettled; /* [unsettleds][6] boxes around lights that changed */
  size_t unsettleds;
} baker;

/* The root alone, occupied, is the wave. */
ylm_status baker_root(baker *b);
/* Splits by the threshold until nothing is above it. */
ylm_status baker_refine_threshold(baker *b);
/* Frees what a baker holds, the grid and the occupancy excepted. */
void baker_free(baker *b);
/* Returns s; says in `e` what ran out, if s is YLM_ENOMEM or YLM_ELIMIT. */
ylm_status ylm__grid_no_room(ylm_status s, const ylm_grid_source *source, ylm_error *e);

/* The index of the point at lattice coordinates; a new one waits for baker_evaluate. */
ylm_status baker_point(baker *b, const uint32_t at[3], uint8_t flags, uint32_t *index);
/* Evaluates all points that wait, in blocks through the field. */
ylm_status baker_evaluate(baker *b);
/* Evaluates the n points `list` anew. */
ylm_status baker_evaluate_list(baker *b, size_t n, const uint32_t *list);
/* Asks a field for the block's results at its first n positions. */
ylm_status baker_ask(baker *b, const ylm_field *field, size_t n, field_block *k);
/* The same for few lights: no metric, and Hessians only of the channels that the metric is of. */
ylm_status baker_ask_few(baker *b, const ylm_field *field, size_t n, field_block *k);
/* Room in a block for the results of n points. */
ylm_status baker_reserve_block(baker *b, field_block *k, size_t n);
/* The float position that the field is asked at for a point. */
void ylm__grid_asked(const ylm_grid *g, uint32_t point, float out[3]);
/* Values alone at n free points. */
ylm_status baker_values(baker *b, size_t n, const float *points, float *value, uint8_t *inside);
/* Evaluates what the cells of the wave lack at their corners, computes their metric, and finds
   which of them a light's surface crosses. */
ylm_status baker_corners(baker *b);
/* The cell in the same place before an update; NULL: none, or no update. */
static inline const ylm_grid_cell *baker_before(const baker *b, const ylm_grid_cell *c) {
  return b->before && c->source != YLM_GRID_NONE ? &b->before[c->source] : NULL;
}
/* Splits a cell; its occupied children come next. */
ylm_status baker_split(baker *b, uint32_t cell);
/* The children that came next become the wave. */
void baker_advance(baker *b);
/* Fills points in lights and finishes: then the grid can be sampled. `last`: makes it continuous,
   if that is asked for; nothing may be refined after that. */
ylm_status baker_finish(baker *b, bool last);
/* The metric of a cell that has its corners: mean over the valid ones of lambda D^2/2, or of that
   over the norm. */
float baker_metric(const baker *b, const ylm_grid_cell *c, ylm_grid_metric metric);

/* -- tolerance.c -------------------------------------------------------------------- */

/* Ratios of measured error to the square of the metric, counted by powers of sqrt 2. */
typedef struct ratios {
  uint64_t count[256], n;
} ratios;

ylm_status ylm__grid_bake_tolerance(baker *b);
/* Refines from the root by what the bake has learnt, then compares held-out points of voxels with
   changed corners (changed: by point; points from `known` on are new). Fills `verified`, `error`
   and `met` of the dynamic state's stats. */
ylm_status ylm__grid_update_tolerance(baker *b, const uint8_t *changed, size_t known);

/* -- continuity.c ------------------------------------------------------------------- */

/* First-order values for points in lights, from valid corners of the cells they belong to. */
ylm_status ylm__grid_fill_invalid(ylm_grid *g);
/* Splits leaves that have data until every evaluated point is a corner of all of them that it
   touches; leaves without data note how far sampling has to descend (cell.detail). */
ylm_status ylm__grid_make_continuous(ylm_grid *g, int threads);
/* Computes interpolated points: all, or those that depend on points with changed[point] != 0, which
   are then marked themselves. */
ylm_status ylm__grid_interpolate_points(ylm_grid *g, uint8_t *changed, int threads);

/* A cell that exists only while a leaf without data is sampled. */
typedef struct virtual_cell {
  uint32_t origin[3], edge;
  const float *row[ROWS];
} virtual_cell;
#define VIRTUAL_ROWS 64 /* room that it needs, in rows of g->stride floats */
/* The virtual cell that holds lattice coordinates `at` of a leaf with `detail`. */
void ylm__grid_virtual(const ylm_grid *g, uint32_t leaf, const double at[3], virtual_cell *v,
                       float *scratch);

/* -- sample.c ----------------------------------------------------------------------- */

/* A cell's interpolant at fractions t of its edges, float; row r is [width]. Hermite. */
void ylm__grid_interpolate(const ylm_grid *g, const ylm_grid_cell *c, const float t[3],
                           float *value, float *gradient /* [3][stride], may be NULL */);
/* The same from 32 rows and an edge in lattice units. */
void ylm__grid_mix(const ylm_grid *g, const float *const row[ROWS], uint32_t edge, const float t[3],
                   float *value, float *gradient);

/* Samples the grid that is f->self: see ylm_grid_field. */
ylm_status ylm__grid_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                              const void *points, ylm_field_result *r, ylm_error *e);

/* What a sampling kernel works on: up to BATCH points of one cell. */
#define BATCH 32
typedef struct sample_batch {
  int points, width, derivatives; /* derivatives: 0, or 1: gradients too */
  ylm_grid_interpolation interpolation;
  float edge[3];             /* of the cell, scene units */
  float t[3][BATCH];         /* fractions of the edges */
  const float *row[ROWS];    /* value of the 8 corners, d/dx of them, d/dy, d/dz */
  float *value[BATCH];       /* [width] each */
  float *gradient[3][BATCH]; /* [width] each, by axis */
} sample_batch;
typedef void sample_kernel(const sample_batch *b);
sample_kernel *ylm__grid_kernel(void);
sample_kernel ylm_k_grid_sample_reference, ylm_k_grid_sample_sse2, ylm_k_grid_sample_neon,
    ylm_k_grid_sample_avx2, ylm_k_grid_sample_avx512;
/* Kernels read up to this many floats past a row's end. */
#define ROW_PADDING 16

#endif
