/* baker.h - a bake under way: cells to decide about, points that wait for the light field. */
#ifndef YLM_GRID_BAKER_H
#define YLM_GRID_BAKER_H

#include "calibration.h"
#include "learnt.h"

/* A list of cells. */
typedef struct cell_list {
  uint32_t *cell;
  size_t n, room;
} cell_list;
ylm_status ylm__cell_list_push(cell_list *list, uint32_t cell);

/* Results of the field for a block of points. */
typedef struct field_block {
  float *position, *value, *gradient, *lambda, *norm;
  float *hessian; /* [n][channels][count][6]; NULL where they are not kept */
  uint8_t *inside;
  float *validity; /* NULL where the grid has none */
  size_t room;     /* points */
} field_block;

/* A bake under way. */
typedef struct baker {
  ylm_grid *g;
  const ylm_grid_source *source;
  ylm_error *e;
  bool told;                      /* it says what ran out */
  bool agreed;                    /* the team knows that the bake has failed */
  const ylm_grid_backend *remote; /* NULL: the processor */
  ylm_grid_backend own;           /* the processor */
  ylm_grid_making making;
  learnt learnt;
  const frames *before_this; /* of the bake that this one is like; NULL: of none */
  measure measure;
  const ylm_grid_surface *surface; /* of the source's meshes, where it is kept; or NULL */
  cell_list wave, next;            /* cells to decide about, their children that come next */
  cell_list parent;                /* of cells 1 .. 8, 9 .. 16, and so on */
  /* Splits cells of the wave once their metric is known; NULL: the threshold has done so. */
  ylm_status (*choose)(void *chooser);
  void *chooser;
  field_block block;
  float *row;        /* [workers][stride + ROW_PADDING], for residuals */
  const char *stage; /* for progress */
  char stage_text[48];
  ylm_progress progress; /* of some work as the bake's */
  uint8_t *used;         /* updates: by point, whether a cell or a test wants it; else NULL */
  size_t used_room;
  /* Updates: the cells before, which new cells in the same place (cell.source, while baking) take
     corners, residuals and crossings from, as far as these cannot have changed; else NULL. */
  const ylm_grid_cell *before;
  const uint8_t *changed;  /* by point that was there */
  const double *unsettled; /* [unsettleds][6] boxes around lights that changed */
  size_t unsettleds;
} baker;

/* -- bake.c: begin and end --------------------------------------------------------------- */

void ylm__baker_begin(baker *b, ylm_grid *g, const ylm_grid_source *source, ylm_error *e);
/* Frees what a baker holds, the grid and what it has learnt excepted. */
void ylm__baker_free(baker *b);

/* -- bake.c --------------------------------------------------------------------------------- */

/* Returns s; says in `e` what ran out, if s is YLM_ENOMEM or YLM_ELIMIT. */
ylm_status ylm__grid_no_room(ylm_status s, const ylm_grid_source *source, ylm_error *e);

/* -- occupy.c ------------------------------------------------------------------------------- */

/* The wave becomes a lattice's occupied voxels, or the root of an octree: its occupied voxels are
   those of n codes, which it takes; NULL: it finds them. */
ylm_status ylm__occupy_voxels(baker *b, uint64_t *code, size_t n);

/* -- refine.c ------------------------------------------------------------------------------- */

/* Makes level after level, the first of which has so many voxels, until nothing is split. */
ylm_status ylm__refine(baker *b, size_t voxels);

/* -- finish.c ------------------------------------------------------------------------------- */

/* Fills points in lights, makes the grid continuous, if that is asked for, and finishes: then it
   can be sampled. Nothing may be refined after that. */
ylm_status ylm__finish(baker *b);

/* -- assemble.c ----------------------------------------------------------------------------- */

/* Checks and completes cells and points that a back end has kept. */
ylm_status ylm__assemble(baker *b);

/* -- backend.c ------------------------------------------------------------------------------ */

/* Are cells kept elsewhere? */
static inline bool backend_keeps_cells(const baker *b) { return b->remote && b->remote->corners; }
/* Occupied voxels, and values at n shading points, as far as a back end keeps them. */
ylm_status ylm__backend_occupied(baker *b, uint64_t **code, size_t *n);
ylm_status ylm__backend_shading(baker *b, size_t n, const size_t *index, float *out);
/* Evaluates the n points that wait. */
ylm_status ylm__backend_evaluate(baker *b, size_t n);
ylm_status ylm__backend_residuals(baker *b, size_t n, const ylm_grid_probe *probe,
                                  const ylm_grid_held *held, double *distance);
/* Fills points in lights from valid neighbours, wherever rows are. */
ylm_status ylm__backend_fill_invalid(baker *b);
/* All that is kept elsewhere, here too. */
ylm_status ylm__backend_fetch(baker *b);
/* Does a source have shading points? Else surfaces or every voxel are occupied. */
static inline bool backend_has_shading(const ylm_grid_source *s) {
  return s->occupied_points || (s->backend && s->occupied);
}

/* -- processor.c ---------------------------------------------------------------------------- */

ylm_grid_backend ylm__processor_backend(baker *b);

/* -- corners.c ------------------------------------------------------------------------------ */

/* The index of the point at lattice coordinates; a new one waits for ylm__backend_evaluate. */
ylm_status ylm__corners_point(baker *b, const uint32_t at[3], uint8_t flags, uint32_t *index);
/* Room for one more point. YLM_ELIMIT: there are as many as may be. */
ylm_status ylm__corners_room(baker *b);
/* Finds the corners of the wave's cells; new points wait, in the order of cells. */
ylm_status ylm__corners_find(baker *b);
/* b->parent, of cells that the caller has made. */
ylm_status ylm__corners_find_parents(baker *b);
/* Corners that unoccupied cells share with others: of cells with only[cell] != 0. */
void ylm__corners_find_shared(baker *b, const uint8_t *only);

/* -- divide.c ------------------------------------------------------------------------------- */

/* Whether all processes of a team were called alike. */
ylm_status ylm__divide_same(ylm_team *t, const ylm_grid_form *f, const ylm_grid_source *source,
                            ylm_error *e);
/* ylm__divide_same for the source's team, if it has one. */
ylm_status ylm__divide_begin(baker *b);
/* Of n points that are evaluated together, the parts of one process after another. n: this process does them all. */
size_t ylm__divide_part(const baker *b, size_t n);
/* Points that are evaluated together, at most. */
size_t ylm__divide_round(const baker *b);
/* Status s of this process, or that of the first where it is bad. */
ylm_status ylm__divide_agree(baker *b, ylm_status s);
/* Every process's part of an array of n rows of `size` bytes to every process. */
ylm_status ylm__divide_share(baker *b, size_t n, size_t part, size_t size, void *rows);
/* Adds what all processes have counted since `before` to the stats, where this one has counted. */
ylm_status ylm__divide_count(baker *b, uint64_t before, uint64_t *count);
/* Refuses processes that were given other light fields: compares numbers that each has of its own. */
ylm_status ylm__divide_compare(baker *b, const float *numbers, size_t n);

/* -- evaluate.c ----------------------------------------------------------------------------- */

/* Evaluates the n points of `list`, or from `first` on, in blocks through the field. */
ylm_status ylm__evaluate_points(baker *b, size_t n, const uint32_t *list, size_t first);
/* Values alone at n free points. */
ylm_status ylm__evaluate_values(baker *b, size_t n, const float *points, float *value,
                                uint8_t *inside);
/* Asks a field for the block's results at its first n positions. */
ylm_status ylm__evaluate_ask(baker *b, const ylm_field *field, size_t n, field_block *k);
/* Room in a block for the results of n points; what frees it. */
ylm_status ylm__evaluate_reserve_block(baker *b, field_block *k, size_t n);
void ylm__evaluate_free_block(field_block *k);
/* The float position, relative to the grid's origin, that the field is asked at for a point. */
void ylm__grid_asked(const ylm_grid *g, uint32_t point, float out[3]);

/* -- metric.c ------------------------------------------------------------------------------- */

/* The metric of a cell that has its corners: mean over the valid ones of lambda D^2/2, or of that
   over the norm. */
float ylm__metric_of(const baker *b, const ylm_grid_cell *c, ylm_grid_metric metric);
/* The relative metric where norms are at least `least`. */
double ylm__metric_above(const baker *b, const ylm_grid_cell *c, double least);
/* The metric of the wave's cells; finds which of them a light's surface crosses. */
ylm_status ylm__metric_find(baker *b);

/* -- cells.c -------------------------------------------------------------------------------- */

/* The root alone, occupied, is the wave. */
ylm_status ylm__cells_root(baker *b);
/* Splits a cell; its occupied children come next. */
ylm_status ylm__cells_split(baker *b, uint32_t cell);
/* The children that came next become the wave. */
void ylm__cells_advance(baker *b);
/* The cell in the same place before an update; NULL: none, or no update. */
static inline const ylm_grid_cell *cells_before(const baker *b, const ylm_grid_cell *c) {
  return b->before && c->source != YLM_GRID_NONE ? &b->before[c->source] : NULL;
}

/* -- sides/bake.c ------------------------------------------------------------------------------ */

/* A grid with sides, of the voxels that the wave holds. */
ylm_status ylm__sides_bake(baker *b);

/* Is a place, relative to the walls' origin, in a body? Of indirect light also behind surfaces whose other sides alone are used:
   nothing sends light there. Other light may come from where no surface is. */
static inline bool place_buried(const ylm_grid *g, const ylm_grid_walls *w, const float x[3]) {
  double open, share = w->buried ? w->buried(w->self, x, &open) : 0;
  if (!w->buried) return false;
  bool indirect = g->contents.form.quantity == YLM_QUANTITY_indirect;
  return (indirect ? share : share * (1 - open)) > SIDES_BURIED;
}

/* -- measure.c ---------------------------------------------------------------------------------- */

/* Relative distance of two rows; 0 where both vanish. A norm below `floor` counts as that. */
double ylm__row_distance(const float *a, const float *exact, size_t width, double floor);

/* -- go_on.c -------------------------------------------------------------------------------- */

ylm_status ylm__tolerance_bake(baker *b);

#endif
