/* baker.h - a bake under way: cells to decide about, points that wait for the light field. */
#ifndef YLM_GRID_BAKER_H
#define YLM_GRID_BAKER_H

#include "learnt.h"

/* A list of cells. */
typedef struct cell_list {
  uint32_t *cell;
  size_t n, room;
} cell_list;
ylm_status cell_list_push(cell_list *list, uint32_t cell);

/* What the field writes for a block of points. */
typedef struct field_block {
  float *position, *value, *gradient, *lambda, *norm;
  float *hessian; /* [n][channels][count][6]; NULL where nobody keeps them */
  uint8_t *inside;
  size_t room; /* points */
} field_block;

/* A bake under way. */
typedef struct baker {
  ylm_grid *g;
  const ylm_grid_source *source;
  const ylm_grid_keeper *keeper; /* NULL: rows are the grid's own */
  ylm_error *e;
  bool told; /* it says what ran out */
  learnt learnt;
  const ylm_grid_surface *surface; /* of the source's meshes, where somebody keeps it; or NULL */
  cell_list wave, next;            /* cells to decide about, their children that come next */
  cell_list parent;                /* of cells 1 .. 8, 9 .. 16, and so on */
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
/* The bake's progress as that of some work: valid as long as the baker. */
ylm_progress baker_progress(const baker *b);
/* Evaluates the n points `list` anew. */
ylm_status baker_evaluate_list(baker *b, size_t n, const uint32_t *list);
/* Asks a field for the block's results at its first n positions. */
ylm_status baker_ask(baker *b, const ylm_field *field, size_t n, field_block *k);
/* Room in a block for the results of n points; what frees it. */
ylm_status baker_reserve_block(baker *b, field_block *k, size_t n);
void baker_free_block(field_block *k);
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
/* The cell's interpolant at fractions t of its edges, to be compared with a point's value. */
ylm_grid_probe baker_probe(const baker *b, const ylm_grid_cell *c, const float t[3],
                           uint32_t point);
/* Splits a cell; its occupied children come next. */
ylm_status baker_split(baker *b, uint32_t cell);
/* The children that came next become the wave. */
void baker_advance(baker *b);
/* Finds the corners of the wave's cells; new points wait, in the order of cells. */
ylm_status baker_find_corners(baker *b);
/* b->parent, of cells that somebody else has made. */
ylm_status baker_find_parents(baker *b);
/* Corners that unoccupied cells share with others: of cells with only[cell] != 0. */
void baker_find_shared(baker *b, const uint8_t *only);
/* Fills points in lights, makes the grid continuous, if that is asked for, and finishes: then it
   can be sampled. Nothing may be refined after that. */
ylm_status baker_finish(baker *b);
/* The metric of a cell that has its corners: mean over the valid ones of lambda D^2/2, or of that
   over the norm. */
float baker_metric(const baker *b, const ylm_grid_cell *c, ylm_grid_metric metric);

/* Does a source have shading points? Else surfaces or every voxel are occupied. */
static inline bool baker_has_shading(const ylm_grid_source *s) {
  return s->occupied_points || (s->keeper && s->occupied);
}

/* -- remote.c: where rows are kept elsewhere ----------------------------------------------
** After each of these b->keeper may be NULL: memory ran out, and all rows are here; what was asked
** for is then not done. */

ylm_status keeper_begin(baker *b);
/* Which voxels hold shading points, from who keeps these or finds voxels faster; *found is false
   where the bake is to find them. */
ylm_status keeper_occupancy(baker *b, bool *found);
/* Points that wait for the light field. */
ylm_status keeper_evaluate(baker *b);
ylm_status keeper_residuals(baker *b, size_t n, const ylm_grid_probe *probe, float *distance);
ylm_status keeper_compare(baker *b, size_t n, const float *places, const ylm_grid_probe *probe,
                          float *distance, uint8_t *inside);
/* Fills points in lights from valid neighbours, wherever rows are. */
ylm_status baker_fill_invalid(baker *b);
/* All rows, here too. */
ylm_status baker_fetch(baker *b);

/* -- tolerance.c -------------------------------------------------------------------- */

ylm_status ylm__grid_bake_tolerance(baker *b);

#endif
