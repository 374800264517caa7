/* tolerance.h - refinement by a tolerance, shared by the files it takes. */
#ifndef YLM_GRID_TOLERANCE_H
#define YLM_GRID_TOLERANCE_H

#include "../bake/baker.h"

/* A held-out point after comparison. */
typedef struct verdict {
  double error; /* by the grid's measure */
  uint32_t leaf;
} verdict;

typedef struct refiner {
  baker *b;
  double tolerance, tight;
  ratios ratio;
  double median, high; /* of the ratios, once they are `trusted`: residual.c */
  bool trusted;
  cell_list tested, centre; /* cells to measure, and the points at their centres */
  float *points;            /* [HELD_OUT][3] relative to the grid's origin */
  float *exact;             /* [HELD_OUT][width] */
  uint8_t *inside;
  float *side; /* [HELD_OUT][3] normals; NULL: none are asked for */
  verdict *verdict;
  size_t held, verdicts;
  size_t most;                     /* held-out points of a round, HELD_OUT at best */
  bool all;                        /* these are all the shading points there are */
  const ylm_grid_surface *surface; /* held-out points are drawn on; NULL: among shading points */
  ylm_grid_surface *own;           /* that surface where it is to be freed here */
  /* An update: ratios and `tight` are those of the bake; voxels that failed lately stay split. */
  bool frozen;
  bool (*forced)(const ylm_grid *g, const ylm_grid_cell *c);
  /* Of a grid in bricks: its samples at n points, by which it is judged; NULL: the baker's grid is sampled. */
  ylm_status (*sample)(void *sampled, const ylm_grid_query *q, size_t n, const float *points,
                       float *value, ylm_error *e);
  void *sampled;
} refiner;

/* -- tolerance.c ------------------------------------------------------------------------ */

/* Memory for a refiner that has its baker; `end` frees it. */
ylm_status ylm__tolerance_begin(refiner *r);
void ylm__tolerance_end(refiner *r);
/* Measures and splits what the wave holds, then its children, until nothing is left. */
ylm_status ylm__tolerance_refine(refiner *r);
/* Looks again at all leaves: those in which held-out points failed are split, and those that the
   tighter bound asks for. */
ylm_status ylm__tolerance_again(refiner *r);

/* -- residual.c ------------------------------------------------------------------------- */

/* The error that a cell may have. */
double ylm__residual_estimate(const refiner *r, const ylm_grid_cell *c);
/* True if a measurement may change what happens to a cell. */
bool ylm__residual_wanted(const refiner *r, const ylm_grid_cell *c);
/* Quantiles of the ratios there are. */
void ylm__residual_learn(refiner *r);
/* Evaluates the centres of the cells in r->tested and keeps what the interpolant misses there. */
ylm_status ylm__residual_measure(refiner *r);

/* -- held_lookups.c ---------------------------------------------------------------------- */

/* True if held-out points have normals that count. */
bool ylm__sides_wanted(const baker *b);
/* The light at the points that are held. */
ylm_status ylm__sides_ask(refiner *r);
/* ylm__verify_compare of points with sides. */
ylm_status ylm__sides_compare(refiner *r);
/* ylm__panel_errors of points with sides. */
ylm_status ylm__sides_errors(const refiner *r, const panel *p, double *error);

/* -- verify.c --------------------------------------------------------------------------- */

/* One verification of the grid as it is. */
ylm_status ylm__verify(refiner *r, uint64_t round);
/* Evaluates the r->held points, whose occupied leaves stand in r->verdict, and compares them with
   their leaves' interpolants. */
ylm_status ylm__verify_compare(refiner *r);
/* Draws points of a round, and asks for their light. */
ylm_status ylm__verify_draw(refiner *r, uint64_t round);
/* As ylm__verify_draw, of a surface, in the leaves that `wanted` [cells] marks: at most two points in each, one a side. */
ylm_status ylm__verify_draw_in(refiner *r, uint64_t round, const uint8_t *wanted);
/*
** True if refinement may stop. Else `tight` has grown so that the estimates of the voxels in which points failed exceed the
** tolerance. A few are left out: they are split because of their points.
*/
bool ylm__verify_satisfied(refiner *r, bool *limited);

/* -- held.c ----------------------------------------------------------------------------- */

/* Point k of a seed on the surface, in float; `strata` as of ylm_grid_surface_draw. */
void ylm__held_surface_point(const refiner *r, uint64_t seed, uint64_t k, uint64_t strata,
                             float out[3]);
/* Its normal, of one of its two sides. */
void ylm__held_surface_side(const ylm_grid_surface *surface, uint64_t seed, uint64_t k,
                            uint64_t strata, float out[3]);
/* A random shading point, or any where every voxel is occupied; the leaf of the octree it is in. */
void ylm__held_draw(const refiner *r, ylm_rng *rng, float out[3]);
uint32_t ylm__held_leaf(const ylm_grid *g, const float x[3]);
/* n shading points, all there are or random ones, or free places where there are none. */
ylm_status ylm__held_points(refiner *r, ylm_rng *rng, bool all, size_t n);
/* Fractions of its edges at which a cell has a point. */
void ylm__held_fractions(const ylm_grid *g, const ylm_grid_cell *c, const float x[3], float t[3]);
/* The cell's interpolant at fractions t of its edges, to be compared with a point's value. */
ylm_grid_probe ylm__held_probe(const ylm_grid *g, const ylm_grid_cell *c, const float t[3],
                               uint32_t point);

/* -- held_surface.c ---------------------------------------------------------------------- */

/* Writes n held-out points of the surface: by area, in rounds of refinement a part by voxel and by
   triangle. */
ylm_status ylm__held_surface(refiner *r, uint64_t round, size_t n);

/* -- means.c ---------------------------------------------------------------------------- */

/* Means over held-out points, which the errors of darker light are relative to. */
ylm_status ylm__sides_scale(refiner *r);

/* -- panel.c ---------------------------------------------------------------------------- */

/* The points that the refiner holds join the panel. */
ylm_status ylm__panel_take(const refiner *r, panel *p);
/* Errors of a panel's points in the finished grid; negative: left out. `walls` (or NULL): surfaces, of points without normals. */
ylm_status ylm__panel_errors(const refiner *r, const panel *p, const ylm_grid_walls *walls,
                             double *error);

/* Judges the finished grid by fresh points, as many as it takes, and writes what they say to its
   stats. A dynamic grid keeps them. */
ylm_status ylm__panel_judge(refiner *r, bool limited);

#endif
