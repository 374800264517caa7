/*
** follow.h - what a grid keeps so that it can follow moving lights.
**
** The invariant: the data of a point are the sum of all lights, each in one of the states it has
** been in: a light that never moved in its only one, a mover in state seen[point]. The changes that a point lacks are known
** exactly, however many small ones it has sat out. Nothing drifts but rounding, whose bound is kept too.
*/
#ifndef YLM_GRID_DYNAMIC_H
#define YLM_GRID_DYNAMIC_H

#include "../promise/tolerance.h"
#include "calibration.h"
#include "ylm_light.h"

#define EVICT_ALL STATES /* every state but the present one */

/* A light that has changed since some point was evaluated. */
typedef struct mover {
  ylm_light state[STATES];
  bool taken[STATES];
  bool slides[STATES]; /* the state differs from the present one as ylm_light_slides says */
  int current;
  int evict;      /* the state that no point may keep in the next update; -1: none */
  uint64_t moved; /* the update of its last change */
  uint8_t *seen;  /* [room] the state that each point's data have it in */
} mover;

typedef struct grid_dynamic {
  ylm_light *light; /* as of the last update */
  int32_t *mover_of;
  size_t lights;
  ylm_light_shapes shapes; /* of these lights, and of the movers' states */
  mover *mover;
  size_t movers;

  size_t room, hessians; /* points; floats of Hessians per point */
  float *hessian;        /* [room][metric channels][6][count] */
  float *size;           /* [room] norm of a point's values, all channels */
  float *drift;          /* [room] bound of what rounding has added up to */

  void *log; /* rows as they were before the last update: kept, so that its pages are there */
  size_t log_bytes;
  ylm_grid_cell *spare; /* [spare_room] cells of the update before, for the same reason */
  size_t spare_room;

  /* Signatures: of evaluated points [room], of interpolated ones, of cells. signature.c */
  uint64_t *sign, *born_sign, *cell_sign, form_sign;
  size_t born_room, cell_room;
  bool is_signed;

  occupancy occupied;
  ylm_grid_source source; /* of the bake, with copies of what is lit; no field, no lights */
  void *occupied_points;
  ylm_grid_surface *surface; /* of the source's meshes, with a copy of these; NULL: it has points */

  /* The state of refinement by a tolerance: promise/tolerance.c */
  ratios ratio;
  double tight, loosest; /* now; by the bake */
  lattice_hash forced;   /* voxels that failed: update by cell_key */
  panel panel;           /* points that judge updates; none without a tolerance */

  ylm_light_bounds bounds;
} grid_dynamic;

/* The key of a cell: coordinates use 17 of 21 bits. */
static inline uint64_t cell_key(const ylm_grid_cell *c) {
  return lattice_key(c->origin) | (uint64_t)(c->level & 15) << 17 | (uint64_t)(c->level >> 4) << 38;
}

/* True if a voxel failed lately: it stays split. */
bool ylm__dynamic_forced(const ylm_grid *g, const ylm_grid_cell *c);
/* Forgets shapes that neither lights nor movers have. */
void ylm__dynamic_sweep(grid_dynamic *d);
/* Room for all points of the grid. point.c */
ylm_status ylm__dynamic_reserve(ylm_grid *g);
/* Keeps what belongs to point p, evaluated with all lights: row i of the block. */
void ylm__dynamic_store(ylm_grid *g, uint32_t p, const field_block *k, size_t i);
/* The difference of two states of a light at a point: a field of one channel, and its colour. */
typedef struct point_change {
  const float *value, *gradient, *hessian; /* [count], [count][3], [count][6] */
  const float *position;                   /* [3] where it was asked for */
  const double *colour;                    /* [3] */
} point_change;
/* Adds a change to point p; the metric comes later. `room` is for 10 count floats. */
void ylm__dynamic_add(ylm_grid *g, uint32_t p, const point_change *x, float *room);
/* Lambda, norm, size and signature of point p from its data. */
void ylm__dynamic_measure(ylm_grid *g, uint32_t p, ylm_light_lambda2_fn *lambda2);
/* Signs an evaluated point's data. */
void ylm__dynamic_sign(ylm_grid *g, uint32_t p);
/* Room for the signatures of interpolated points; false, and the grid has none, without memory.
 *all: the others have none yet. */
bool ylm__dynamic_room_births(ylm_grid *g, bool *all);
/* Signs n interpolated points that were born of a cell whose corners are signed. */
void ylm__dynamic_sign_births(ylm_grid *g, const ylm_grid_cell *c, size_t n, const uint32_t *birth);
/* Signs cells, once all points are signed. */
void ylm__dynamic_sign_all(ylm_grid *g, int threads);
/* Moves everything of point `from` to `to`. */
void ylm__dynamic_move(ylm_grid *g, uint32_t from, uint32_t to);

/* -- match.c: which lights changed -------------------------------------------------- */

/* A light before and after; an index of -1: it was not there, it is no more. */
typedef struct light_change {
  int64_t before, after;
} light_change;

/*
** Finds what differs between d->light and n lights. origin[j] (room for n) becomes the earlier
** index of light j, -1 if it is new or changed; *changes is freed by the caller.
*/
ylm_status ylm__lights_match(const grid_dynamic *d, size_t n, const ylm_light *now, int64_t *origin,
                             light_change **changes, size_t *count);

/* -- stale.c: points that have to be brought up to date --------------------------------- */

enum { STALE_NOT, STALE_SKIPPED, STALE_SHIFT, STALE_EXACT };

/*
** Writes STALE_* for every evaluated point. A point's bound is that of the error of interpolating
** between points like it: values are mixed with weights whose absolute sum is at most 1.58,
** gradients with 0.43 edges.
*/
ylm_status ylm__grid_find_stale(ylm_grid *g, double tolerance, int threads, uint8_t *what);
/* True if the bound on rounding is more than so many sixteenths of the tolerance, beside what light
   there is: then all lights are to be summed. */
bool ylm__grid_is_worn(const ylm_grid *g, size_t p, double tolerance, double sixteenths);

#endif
