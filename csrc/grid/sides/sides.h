/*
** sides.h - leaves that surfaces cross: their parts, the points at their corners, and which part a place is in.
**
** A voxel that a wall crosses holds light that is two functions, and one interpolant cannot be both. Such a leaf is cut into
** parts, each of which is seen from one place. The parts around a corner that see it share its point. Others have a ghost:
** light at the nearest place that they see, carried to the corner by its gradient.
*/
#ifndef YLM_GRID_SIDES_H
#define YLM_GRID_SIDES_H

#include "../bake/baker.h"
#include "calibration.h"
#include "ylm_keys.h"

#define SUB YLM_GRID_PIECES_OWN
#define MORE YLM_GRID_PIECES_ALL

static inline void side_set_part(ylm_grid_side *s, size_t piece, uint8_t part) {
  int shift = 4 * (int)(piece & 1);
  s->part[piece / 2] = (uint8_t)((s->part[piece / 2] & ~(15 << shift)) | part << shift);
}
/* Places of the piece along an axis, -1 .. 4, and whether it lies outside of the leaf. */
static inline int piece_at(size_t piece, int axis) {
  static const int step[3] = {1, MORE, MORE * MORE};
  return (int)piece / step[axis] % MORE - 1;
}
/* Where a piece's middle is, in edges of the leaf. Middles are a little off: walls of scenes like to be at round parts of a
   voxel. */
static inline double piece_middle(size_t piece, int axis) {
  static const double askew[3] = {0.0137, -0.0211, 0.0173};
  return (piece_at(piece, axis) + 0.5 + askew[axis]) / SUB;
}
static inline bool piece_outer(size_t piece) {
  for (int a = 0; a < 3; a++)
    if (piece_at(piece, a) < 0 || piece_at(piece, a) >= SUB) return true;
  return false;
}

/* The middle of a piece of a leaf, scene units relative to `origin`. parts.c */
void ylm__side_place(const ylm_grid *g, const ylm_grid_cell *c, size_t piece,
                     const double origin[3], float out[3]);

/* -- parts.c ------------------------------------------------------------------------------------ */

/* How a part sees the corners of its leaf. */
typedef struct part_view {
  uint8_t piece[8]; /* its piece nearest to the corner */
  float share[8];   /* of the way from there before a surface; 1: it sees the corner */
} part_view;

/* Cuts a leaf; views [YLM_GRID_PARTS]. Returns the number of parts that were joined to others. */
uint64_t ylm__side_cut(const ylm_grid *g, const ylm_grid_walls *walls, uint32_t cell,
                       ylm_grid_side *side, part_view *views);

/* -- bake.c -------------------------------------------------------------------------------------- */

/* A bake of a grid with sides. */
typedef struct side_baker {
  baker *b;
  part_view *view; /* [parts] */
  size_t view_room;
  uint32_t *row; /* [cells] of a leaf that surfaces cross; ROW_OPEN: they do not, ROW_UNKNOWN */
  size_t rows, row_room;
  ylm_keys ghosts;       /* of ghost_key */
  uint32_t *ghost_point; /* [ghosts.room] */
  size_t ghost_room;
} side_baker;
enum { ROW_UNKNOWN = YLM_GRID_NONE, ROW_OPEN = YLM_GRID_NONE - 1 };

/* A ghost is known by its corner and by the place where the field is asked. */
typedef struct ghost_key {
  uint32_t lattice[3];
  float asked[3];
} ghost_key;

/* Sides of new leaves, their points, and these evaluated. */
ylm_status ylm__sides_renew(side_baker *k);
/* Splits a leaf; its occupied children come next. */
ylm_status ylm__sides_split(side_baker *k, uint32_t cell);
/* Finishes: then the grid can be sampled. Nothing may be refined after that. */
ylm_status ylm__sides_finish(side_baker *k);

/* -- nodes.c -------------------------------------------------------------------------------------- */

/* Gives all leaves the points at their corners: new ones wait to be evaluated. */
ylm_status ylm__sides_find_nodes(side_baker *k);

/* -- compact.c ------------------------------------------------------------------------------------ */

/* Points that leaves have; YLM_ENOMEM. */
ylm_status ylm__sides_count(const ylm_grid *g, size_t *points);
/* Drops the points that no leaf has, and sides that are no leaves any more; ghosts stand last. */
ylm_status ylm__sides_compact(side_baker *k);

/* -- ../promise/pool.c ---------------------------------------------------------------------------- */

/* A bake by a tolerance. */
ylm_status ylm__pool_bake(side_baker *k);

#endif
