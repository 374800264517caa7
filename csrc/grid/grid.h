/* grid.h - the inside of a grid, shared by the files of this folder. */
#ifndef YLM_GRID_PRIVATE_H
#define YLM_GRID_PRIVATE_H

#include <math.h>

#include "gen/cells.h"
#include "ylm_grid.h"
#include "ylm_sets.h"

#define ROWS 32 /* what a voxel's interpolant is made of: 8 corners x (value, 3 derivatives) */

/* Points by lattice coordinates: open addressing, a key beside its value. */
typedef struct lattice_entry {
  uint64_t key;
  uint32_t value; /* YLM_GRID_NONE: free */
} lattice_entry;
typedef struct lattice_hash {
  lattice_entry *entry;
  size_t size, used; /* size is a power of two */
} lattice_hash;

/* The leaves that surfaces cross, of a grid with sides: sides/. */
typedef struct grid_sides {
  ylm_grid_side *side; /* in the order of their leaves, once the grid is finished */
  size_t n, room;
  uint32_t (*node)[8]; /* [parts] */
  size_t parts, part_room;
  uint32_t *leaf; /* [parts] the cell that a part is of */
  uint32_t *
      of; /* [cells] the row of side[], YLM_GRID_NONE: uncrossed; NULL until the grid can be sampled */
  float (*asked)
      [3]; /* [points] as long as point_room: of ylm_grid_contents; NULL: the grid has no sides */
  float *dark; /* [stride + ROW_PADDING] zeros */
} grid_sides;

struct ylm_grid {
  ylm_grid_contents contents; /* its pointers are the arrays below */
  ylm_grid_stats stats;
  ylm_field field;

  ylm_grid_cell *cell;
  size_t cells, cell_room;

  uint32_t *lattice; /* [points][3] */
  float *data;       /* [points][rows][stride], and some floats of padding behind the last */
  size_t data_bytes;
  float *lambda, *norm;
  uint8_t *flags;
  float *validity; /* [evaluated], as long as point_room in a bake; NULL: none is told */
  size_t points, point_room, evaluated, stride, rows;
  grid_sides sides;

  /* Where interpolated points come from, in their order: [points - evaluated]. */
  ylm_grid_birth *birth;
  size_t birth_room;

  lattice_hash hash; /* evaluated points */
  uint32_t width;    /* channels * count */
  /* Cells by coarse lattice coordinates: [top[2]][top[1]][top[0]], to begin a descent. */
  uint32_t *table, top[3];
  int top_shift;      /* lattice coordinate >> top_shift is a coordinate of the table */
  size_t table_first; /* of a brick: where the table would begin in one of the whole bounds */
  uint32_t last[3];   /* the last lattice cell along each axis, of a brick that of its cell */
  double scale[3];    /* lattice cells per scene unit */
  double origin[3]; /* ylm_origin of the bounds: points that are kept in float are relative to it */

  float (*judge)
      [6]; /* [judges] places and normals of the first points that judged the bake, relative to `origin` */
  size_t judges;
  /* Judged the bake, with exact light (bake/panel.h); NULL: nobody knows. */
  struct grid_panel *panel;
  ylm_grid_small_report small; /* of a grid that was read from a file of few bytes */
  bool is_small;
  struct frames *frames; /* for bakes like this one (promise/go_on.c); NULL: it knows none */
  const struct follower *follower; /* NULL: the grid follows no lights */
  struct grid_dynamic *dynamic;    /* what the follower keeps (follow/follow.h) */
  bool updating;
  bool spent; /* memory ran out where an update could not be taken back: the root voxel is left */
};

/* -- who follows moving lights: follow/follow.c ------------------------------------ */

struct field_block;
struct learnt;

/*
** Hooks of a bake for what keeps the grid up to date afterwards. Without a follower none is called.
**
**   begin    before the bake. *surface is that of the source's meshes, which the follower owns, or
**            NULL
**   reserve  room for all points of the grid
**   store    keeps row i of a block: point `point` was evaluated with all lights
**   filled   the rows of an evaluated point were written otherwise
**   births   room for what is kept of interpolated points; false: nothing is. *all: of all of them,
**            not only of those that are computed
**   born     n interpolated points of cell `c` have their rows
**   failed   a voxel was split because held-out points failed in it
**   end      after the bake: what it has learnt, whose arrays may be taken
**   free, bytes  of what is kept
*/
typedef struct follower {
  ylm_status (*begin)(ylm_grid *g, const ylm_grid_source *source, const ylm_grid_surface **surface,
                      ylm_error *e);
  ylm_status (*reserve)(ylm_grid *g);
  void (*store)(ylm_grid *g, uint32_t point, const struct field_block *k, size_t i);
  void (*filled)(ylm_grid *g, uint32_t point);
  bool (*births)(ylm_grid *g, bool *all);
  void (*born)(ylm_grid *g, const ylm_grid_cell *c, size_t n, const uint32_t *birth);
  ylm_status (*failed)(ylm_grid *g, const ylm_grid_cell *c);
  ylm_status (*end)(ylm_grid *g, struct learnt *learnt);
  void (*free)(ylm_grid *g);
  size_t (*bytes)(const ylm_grid *g);
} follower;
extern const follower ylm__follower;

/* -- store.c: cells and points ------------------------------------------------- */

ylm_grid *ylm__grid_new(const ylm_grid_form *form);
/* Makes an empty octree a brick: the subtree of a cell of level > 0. */
void ylm__grid_set_root(ylm_grid *g, int level, const uint32_t origin[3]);
/* Checks what can be checked of a form; the sentence names the field. */
ylm_status ylm__grid_check_form(const ylm_grid_form *form, ylm_error *e);
/* Checks what can be checked of a source; the sentence names the field. */
ylm_status ylm__grid_check_source(const ylm_grid_source *s, bool dynamic, ylm_error *e);
/* Room for `more` cells or points beyond those there are. */
ylm_status ylm__grid_reserve_cells(ylm_grid *g, size_t more);
ylm_status ylm__grid_reserve_points(ylm_grid *g, size_t more);
void ylm__grid_free_points(ylm_grid *g);
/* Gives back the room that growing has left over. */
void ylm__grid_trim(ylm_grid *g);
/* Eight children of a cell, with origins and levels; the index of the first through *first. */
ylm_status ylm__grid_split(ylm_grid *g, uint32_t cell, uint32_t *first);
/* Edge of a cell in lattice units. */
static inline uint32_t ylm__grid_edge(const ylm_grid *g, const ylm_grid_cell *c) {
  return g->contents.form.kind == YLM_GRID_UNIFORM ? 1u : 1u << (g->contents.form.depth - c->level);
}
/* Lattice coordinates of corner k of a cell. */
static inline void ylm__grid_corner_at(const ylm_grid *g, const ylm_grid_cell *c, int k,
                                       uint32_t at[3]) {
  uint32_t edge = ylm__grid_edge(g, c);
  for (int a = 0; a < 3; a++) at[a] = c->origin[a] + (k >> a & 1 ? edge : 0);
}
/* Does a cell have all its corners? */
static inline bool ylm__grid_is_complete(const ylm_grid_cell *c) {
  for (int k = 0; k < 8; k++)
    if (c->corner[k] == YLM_GRID_NONE) return false;
  return true;
}
/* Floats of a point's rows. */
static inline size_t ylm__grid_record(const ylm_grid *g) { return g->rows * g->stride; }
/* A row of a point: its value, then its slopes. Where there are no slopes, the value stands for them, with weight 0. */
static inline const float *ylm__grid_row(const ylm_grid *g, uint32_t point, int row) {
  size_t r = (size_t)row < g->rows ? (size_t)row : 0;
  return g->data + ((size_t)point * g->rows + r) * g->stride;
}
/* How cells are interpolated: along the axes where points have no slopes. */
static inline ylm_grid_interpolation ylm__grid_interpolation(const ylm_grid *g,
                                                             ylm_grid_interpolation wanted) {
  return g->rows == 1 ? YLM_GRID_LINEAR : wanted;
}
/* Brings the rows of a cell's corners towards the cache. */
static inline void ylm__grid_fetch(const ylm_grid *g, const ylm_grid_cell *c) {
  for (int k = 0; k < 8; k++) {
    const char *row = (const char *)ylm__grid_row(g, c->corner[k], 0);
    for (size_t i = 0; i < 4 * ylm__grid_record(g); i += 64) __builtin_prefetch(row + i, 0, 2);
  }
}
/* Flags the octree's cells whose corners were all evaluated. */
void ylm__grid_find_baked(ylm_grid *g);
/* Brings the contents up to date; counts cells and points into the stats. */
void ylm__grid_sync(ylm_grid *g);
void ylm__grid_count(ylm_grid *g);
/* Finds each leaf's source of data, counts, builds the table: what sampling needs. */
ylm_status ylm__grid_finish(ylm_grid *g);
/* Lattice coordinates (with fractions, clamped into the bounds) of a point; true if it was
   inside. */
bool ylm__grid_coordinates(const ylm_grid *g, const double p[3], double out[3]);
/* The leaf under clamped lattice coordinates; the box moves the coordinates where a uniform grid
   has no data. */
uint32_t ylm__grid_leaf(const ylm_grid *g, const double at[3]);
/* Cells by coarse coordinates, as a beginning for the next; it stays good while leaves are
   split. */
ylm_status ylm__grid_build_table(ylm_grid *g);
static inline size_t ylm__grid_table_index(const ylm_grid *g, uint32_t x, uint32_t y, uint32_t z) {
  return ((size_t)z * g->top[1] + y) * g->top[0] + x;
}
/* The leaf that holds the finest lattice cell `at`, cells added for continuity included. */
static inline uint32_t ylm__grid_finest(const ylm_grid *g, const uint32_t at[3]) {
  int top = g->top_shift;
  size_t place = ylm__grid_table_index(g, at[0] >> top, at[1] >> top, at[2] >> top);
  uint32_t cell = g->table[place - g->table_first];
  for (const ylm_grid_cell *c = &g->cell[cell]; c->child; c = &g->cell[cell]) {
    int shift = g->contents.form.depth - c->level - 1;
    cell = c->child + octant_of(at[0], at[1], at[2], (uint32_t)shift);
  }
  return cell;
}

/* A position of the scene, of a point that is kept relative to the grid's origin. */
static inline void ylm__grid_outward(const ylm_grid *g, const float x[3], double out[3]) {
  for (int a = 0; a < 3; a++) out[a] = (double)x[a] + g->origin[a];
}
/* The origin for queries; NULL where it is 0. */
static inline const double *ylm__grid_origin(const ylm_grid *g) {
  return g->origin[0] != 0 || g->origin[1] != 0 || g->origin[2] != 0 ? g->origin : NULL;
}
/* A position of the scene as it is kept. */
static inline void ylm__grid_inward(const ylm_grid *g, const double p[3], float out[3]) {
  for (int a = 0; a < 3; a++) out[a] = (float)(p[a] - g->origin[a]);
}

/* The leaf that was found last, and its box in lattice coordinates: neighbours often share it. */
typedef struct leaf_cursor {
  uint32_t leaf; /* YLM_GRID_NONE: none */
  double low[3], high[3];
} leaf_cursor;
static inline uint32_t ylm__grid_leaf_again(const ylm_grid *g, leaf_cursor *c, const double at[3]) {
  bool same = c->leaf != YLM_GRID_NONE;
  for (int a = 0; a < 3; a++) same &= at[a] >= c->low[a] && at[a] < c->high[a];
  if (same) return c->leaf;
  c->leaf = ylm__grid_leaf(g, at);
  const ylm_grid_cell *leaf = &g->cell[c->leaf];
  uint32_t edge = ylm__grid_edge(g, leaf);
  for (int a = 0; a < 3; a++) {
    c->low[a] = leaf->origin[a];
    c->high[a] = leaf->origin[a] + edge;
  }
  return c->leaf;
}

/* Fractions of a cell's edges at lattice coordinates; true if they had to be clamped. */
static inline bool ylm__grid_fractions(const ylm_grid *g, const ylm_grid_cell *c,
                                       const double at[3], float t[3]) {
  double inverse = 1 / (double)ylm__grid_edge(g, c);
  bool moved = false;
  for (int a = 0; a < 3; a++) {
    double x = edge_fraction(at[a], c->origin[a], inverse);
    moved |= !(x >= 0 && x <= 1);
    t[a] = (float)(x < 0 ? 0 : x > 1 ? 1 : x);
  }
  return moved;
}

/* -- lattice.c: Morton codes and the hash of points ------------------------------ */

static inline uint64_t lattice_key(const uint32_t at[3]) {
  return (uint64_t)at[0] | (uint64_t)at[1] << 21 | (uint64_t)at[2] << 42;
}
ylm_status ylm__lattice_hash_reserve(lattice_hash *h, size_t entries);
/* The value's place: *value is YLM_GRID_NONE where the key is new. Room must have been reserved. */
uint32_t *ylm__lattice_hash_at(lattice_hash *h, uint64_t key);
/* The value of a key, YLM_GRID_NONE if there is none. */
uint32_t ylm__lattice_hash_find(const lattice_hash *h, uint64_t key);
/* Brings the place of a key that will be looked for into the cache. */
void ylm__lattice_hash_prefetch(const lattice_hash *h, uint64_t key);
/* Forgets a key, if it is there. */
void ylm__lattice_hash_remove(lattice_hash *h, uint64_t key);
void ylm__lattice_hash_free(lattice_hash *h);

/* -- bake/occupancy.c: which voxels hold shading points --------------------------- */

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
ylm_status ylm__occupancy_build(occupancy *o, const ylm_grid *g, const ylm_grid_source *s,
                                uint64_t *outside);
/* Occupancy from the triangles of the source, which `e` is about. */
ylm_status ylm__occupancy_from_surfaces(occupancy *o, const ylm_grid *g, const ylm_grid_source *s,
                                        uint64_t *outside, ylm_error *e);
/* Marks a node of a level of at most o->dense; marks the ancestors of all that are marked. */
void ylm__occupancy_mark(occupancy *o, int level, uint64_t code);
void ylm__occupancy_mark_parents(occupancy *o);
/* Occupancy from Morton codes of the finest nodes, sorted, each once, which it takes. */
ylm_status ylm__occupancy_take(occupancy *o, const ylm_grid *g, uint64_t *code, size_t n);
/* Uniform grids: one byte per voxel. */
void ylm__occupancy_mark_uniform(const ylm_grid *g, const ylm_grid_source *s, uint8_t *mark,
                                 uint64_t *outside);
/* Which of the eight children of a voxel that is not of the finest level are occupied, as bits;
   `origin` in lattice coordinates. */
uint8_t ylm__occupancy_children(const occupancy *o, int level, const uint32_t origin[3]);
void ylm__occupancy_free(occupancy *o);

/* -- bake/invalid.c ----------------------------------------------------------------- */

/* First-order values for points in lights, from valid corners of the cells they belong to; for those
   with filled[point] == 0, since others have theirs. */
ylm_status ylm__grid_fill_invalid(ylm_grid *g);
ylm_status ylm__grid_fill_others(ylm_grid *g, const uint8_t *filled);

/* -- bake/continuity.c -------------------------------------------------------------- */

/* Splits leaves that have data until every evaluated point is a corner of all of them that it
   touches; leaves without data note how far sampling has to descend (cell.detail). progress: may be NULL. */
ylm_status ylm__grid_make_continuous(ylm_grid *g, int threads, const ylm_progress *progress);
/* Continuity of one leaf of the octree; points that it adds are not computed. */
ylm_status ylm__grid_continue_leaf(ylm_grid *g, uint32_t cell);
/* The finest lattice cell on side 0 .. 7 of a point; false if that is outside of the grid. */
bool ylm__grid_side(const ylm_grid *g, const uint32_t at[3], int side, uint32_t beside[3]);
/* Computes interpolated points: all, or those that are marked by changed[point] != 0 or depend on
   points that are, which are then marked themselves. All that one cell gave birth to are alike. */
ylm_status ylm__grid_interpolate_points(ylm_grid *g, uint8_t *changed, int threads,
                                        const ylm_progress *progress);

/* -- sides/index.c, sides/look.c ------------------------------------------------------ */

void ylm__sides_free(grid_sides *s);
/* Finds sides by their cells, and cells by their parts; YLM_ENOMEM. */
ylm_status ylm__sides_index(ylm_grid *g);
/* The hash of evaluated points that are no ghosts; YLM_ENOMEM. */
ylm_status ylm__sides_hash(ylm_grid *g);
ylm_status ylm__sides_hash_to(const ylm_grid *g, lattice_hash *h);
/* The side of an octree's leaf, or NULL: no surface crosses it. */
static inline const ylm_grid_side *ylm__grid_side_of(const ylm_grid *g, uint32_t leaf) {
  return g->cell[leaf].flags & YLM_GRID_SIDED ? &g->sides.side[g->sides.of[leaf]] : NULL;
}
/* Whether a place in free space, a position of the scene, is in a piece with a part. */
bool ylm__side_is_free(const ylm_grid *g, const ylm_grid_side *s, const double x[3]);
/* The part of a side that a place is in, a position of the scene; normal NULL: in free space; walls NULL: by pieces alone.
   The side has parts. */
uint32_t ylm__side_look(const ylm_grid *g, const ylm_grid_side *s, const double x[3],
                        const float normal[3], const ylm_grid_walls *walls);

/* The part of a piece, or, where it has none, of the nearest piece that has one. */
uint8_t ylm__side_part_near(const ylm_grid *g, const ylm_grid_side *s, size_t piece);

/* -- sample/virtual.c --------------------------------------------------------------- */

/* A cell that exists only while a leaf without data is sampled. */
typedef struct virtual_cell {
  uint32_t origin[3], edge;
  const float *row[ROWS];
} virtual_cell;
#define VIRTUAL_ROWS 64 /* room that it needs, in rows of g->stride floats */
/* The virtual cell that holds lattice coordinates `at` of a leaf with `detail`. */
void ylm__grid_virtual(const ylm_grid *g, uint32_t leaf, const double at[3], virtual_cell *v,
                       float *scratch);

/* -- sample/sample.c ---------------------------------------------------------------- */

/* A cell's interpolant at fractions t of its edges, float; row r is [width]. Hermite. */
void ylm__grid_interpolate(const ylm_grid *g, const ylm_grid_cell *c, const float t[3],
                           float *value, float *gradient /* [3][stride], may be NULL */);
/* An interpolant from 32 rows and an edge in lattice units. */
void ylm__grid_mix(const ylm_grid *g, const float *const row[ROWS], uint32_t edge, const float t[3],
                   float *value, float *gradient);

/* Samples the grid that is f->self: see ylm_grid_field. */
ylm_status ylm__grid_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                              const void *points, ylm_field_result *r, ylm_error *e);

/* Work of a sampling kernel: up to BATCH points of one cell. */
#define BATCH 32
typedef struct sample_batch {
  int points, width, derivatives; /* derivatives: 0, or 1: gradients too */
  ylm_grid_interpolation interpolation;
  bool sparse;               /* points are at halves of edges, where most weights are 0 */
  float edge[3];             /* of the cell, scene units */
  float t[3][BATCH];         /* fractions of the edges */
  const float *row[ROWS];    /* value of the 8 corners, d/dx of them, d/dy, d/dz */
  float *value[BATCH];       /* [width] each */
  float *gradient[3][BATCH]; /* [width] each, by axis */
} sample_batch;
typedef void sample_kernel(const sample_batch *b);
sample_kernel *ylm__grid_kernel(void);
/* The batch becomes the one point at fractions t of a leaf without data that has `detail`; `room`
   is that of ylm__grid_virtual. sample/virtual.c */
void ylm__grid_set_virtual(const ylm_grid *g, uint32_t leaf, const float t[3], float *room,
                           sample_batch *b);
/* Gives the batch the edges of cells of a size in lattice units, or edges and rows of a cell. */
void ylm__grid_set_edge(const ylm_grid *g, uint32_t edge, sample_batch *b);
void ylm__grid_set_cell(const ylm_grid *g, const ylm_grid_cell *c, sample_batch *b);
sample_kernel ylm_k_grid_sample_reference;
YLM_SETS_DECLARE(sample_kernel, ylm_k_grid_sample)
/* Kernels read up to this many floats past a row's end. */
#define ROW_PADDING 16

#endif
