/* update.h - an update under way, shared by the files it takes. */
#ifndef YLM_GRID_UPDATE_H
#define YLM_GRID_UPDATE_H

#include "follow.h"

/* The grid before the update, to be restored. Points are all that it had, interpolated ones too. */
typedef struct undo {
  size_t points, evaluated, cells, cell_room, movers;
  double tight;
  lattice_hash forced;
  ylm_grid_cell *cell; /* the old cells, while new ones are made; else NULL */
  uint8_t *flags;
  float *lambda, *norm, *size, *drift;
  uint64_t *sign;
  mover *mover;          /* [movers], with copies of `seen` */
  uint32_t *logged;      /* [logs] points whose rows follow; YLM_GRID_NONE: to come */
  float *data, *hessian; /* in the grid's log */
  size_t logs;
} undo;

typedef struct update {
  ylm_grid *g;
  grid_dynamic *d;
  baker b;
  ylm_grid_source source;
  double tolerance;
  ylm_light_list now;
  int64_t *origin; /* [lights of `now`] */
  light_change *change;
  size_t changes;
  uint32_t *exact, *shift; /* points to evaluate with all lights, with what changed */
  size_t exacts, shifts;
  uint8_t *changed; /* [points at the beginning] data are not what they were */
  double *boxes;    /* [2 changes][6] around lights that changed */
  undo old;
  panel panel; /* what judges the grid, after this update */
  bool over;   /* nothing can be taken back */
  bool whole;  /* continuity is made anew everywhere */
  ylm_grid_update_stats stats;
} update;

/* -- undo.c ----------------------------------------------------------------------------- */

/* Keeps everything but rows of data. */
ylm_status ylm__update_remember(update *u);
/* Keeps the rows of the points that will be written; those of u->shift, the last of the log, when
   their turn comes. */
ylm_status ylm__update_log_rows(update *u);
void ylm__update_log_row(update *u, size_t log, uint32_t point);
/* Takes everything back. */
void ylm__update_restore(update *u);
/* Frees what only taking back needs. */
void ylm__update_forget_rows(update *u);
/* Frees what an update holds, the grid excepted. */
void ylm__update_forget(update *u);

/* -- movers.c --------------------------------------------------------------------------- */

/* Enters the new light set: lights that changed become movers. Arrays are changed only after
   everything that can fail. `of` is the new mover_of. */
ylm_status ylm__update_enter_changes(update *u, int32_t *of);
/* Forgets movers that all points have in their present state. */
void ylm__update_retire(grid_dynamic *d, size_t points);

/* -- shift.c ---------------------------------------------------------------------------- */

/* Which points are to be evaluated anew, and which get the difference. */
ylm_status ylm__update_choose_points(update *u);
/* Brings the points that are listed in u->shift up to date with all movers. */
ylm_status ylm__update_shift_all(update *u);

/* -- panel.c ---------------------------------------------------------------------------- */

/* The exact light of the panel's points, with the new lights. */
ylm_status ylm__update_panel(update *u);

/* -- judge.c ---------------------------------------------------------------------------- */

/* Judges a grid that is being updated by its panel, in the leaves of the octree; changed [old] by
   point that was there. */
ylm_status ylm__judge_leaves(const refiner *r, const panel *p, const uint8_t *changed, size_t old,
                             ruling *out);
/* Judges a dynamic grid after an update, by its samples; those that did not change are known. Where
   it fails, nothing is known. */
ylm_status ylm__judge_samples(const ylm_grid *g, panel *p, int threads, ruling *out);

/* -- tolerance.c ------------------------------------------------------------------------ */

/* Refines from the root by the ratios that the bake has learnt, then further while the panel says
   that the tolerance is not kept. Half of the held-out points are in voxels with changed corners.
   changed: by point; points from `known` on are new. */
ylm_status ylm__update_tolerance(baker *b, const uint8_t *changed, size_t known, const panel *p);

/* -- octree.c --------------------------------------------------------------------------- */

ylm_status ylm__update_octree(update *u);
ylm_status ylm__update_uniform(update *u);

/* -- repair.c --------------------------------------------------------------------------- */

/* Drops points and makes the new octree continuous: around points that came or went, or everywhere.
   Where it fails with u->over, only the octree and its evaluated points are good. */
ylm_status ylm__update_repair(update *u, bool everywhere);

#endif
