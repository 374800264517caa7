/* tolerance.h - refinement by a tolerance, shared by the files it takes. */
#ifndef YLM_GRID_TOLERANCE_H
#define YLM_GRID_TOLERANCE_H

#include "baker.h"

#define HELD_OUT 2048 /* points of one verification */
#define MAX_ROUNDS 16

/* A held-out point after comparison. */
typedef struct verdict {
  double error; /* relative */
  uint32_t leaf;
} verdict;

typedef struct refiner {
  baker *b;
  double tolerance, tight;
  ratios ratio;
  double median, high; /* of the ratios, once they are `trusted`: residual.c */
  bool trusted;
  cell_list tested, centre; /* cells to measure, and the points at their centres */
  float *row;               /* [width], for each worker */
  float *points;            /* [HELD_OUT][3] */
  float *exact;             /* [HELD_OUT][width] */
  uint8_t *inside;
  verdict *verdict;
  size_t held, verdicts;
  bool all;                        /* these are all the shading points there are */
  const ylm_grid_surface *surface; /* held-out points are drawn on; NULL: among shading points */
  ylm_grid_surface *own;           /* the same where nobody else frees it */
  /* An update: ratios and `tight` are those of the bake; voxels that failed lately stay split. */
  bool frozen;
  bool (*forced)(const ylm_grid *g, const ylm_grid_cell *c);
} refiner;

/* -- tolerance.c ------------------------------------------------------------------------ */

/* Memory for a refiner that has its baker; `end` frees it. */
ylm_status refiner_begin(refiner *r);
void refiner_end(refiner *r);
/* Tests and splits what the wave holds, then its children, until nothing is left. */
ylm_status refiner_refine(refiner *r);

/* Looks again at all leaves: those in which held-out points failed are split, and those that the
   tighter bound asks for. */
ylm_status refiner_again(refiner *r);

/* -- residual.c ------------------------------------------------------------------------- */

/* Relative distance of two rows; 0 where both vanish. */
double refiner_distance(const float *a, const float *exact, size_t width);
/* The error that a cell may have. */
double refiner_estimate(const refiner *r, const ylm_grid_cell *c);
/* True if a measurement may change what happens to a cell. */
bool refiner_wants_test(const refiner *r, const ylm_grid_cell *c);
/* Quantiles of the ratios there are. */
void refiner_learn(refiner *r);
/* Evaluates the centres of the cells in r->tested and keeps what the interpolant misses there. */
ylm_status refiner_measure(refiner *r);

/* -- verify.c --------------------------------------------------------------------------- */

/* One verification of the grid as it is. */
ylm_status refiner_verify(refiner *r, uint64_t round);
/* A random shading point, or any where every voxel is occupied; the leaf of the octree it is in. */
void refiner_draw(const refiner *r, ylm_rng *rng, float out[3]);
uint32_t refiner_leaf(const ylm_grid *g, const float x[3]);
/* Evaluates the r->held points, whose occupied leaves stand in r->verdict, and compares them with
   their leaves' interpolants. */
ylm_status refiner_compare(refiner *r);
/* Fractions of its edges at which a cell has a point. */
void refiner_fractions(const ylm_grid *g, const ylm_grid_cell *c, const float x[3], float t[3]);
/*
** True if refinement may stop. Else `tight` has grown so that the estimates of the voxels in which
** points failed (but for a few, which are split because of their points) exceed the tolerance.
** The margin below 1 % is for the next person's held-out points.
*/
bool refiner_satisfied(refiner *r, bool *limited);

/* -- held_surface.c ---------------------------------------------------------------------- */

/* Point k of a seed on the surface, in float; `strata` as of ylm_grid_surface_draw. */
void refiner_surface_point(const refiner *r, uint64_t seed, uint64_t k, uint64_t strata,
                           float out[3]);
/* Writes n held-out points of the surface: by area, in rounds of refinement a part by voxel and by
   triangle. */
ylm_status refiner_hold_surface(refiner *r, uint64_t round, size_t n);

/* -- panel.c ---------------------------------------------------------------------------- */

/* Judges the finished grid by fresh points, as many as it takes, and writes what they say to its
   stats. A dynamic grid keeps them. */
ylm_status refiner_judge(refiner *r, bool limited);

#endif
