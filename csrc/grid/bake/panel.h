/* panel.h - random occupied points with their exact light: they judge a promised tolerance. */
#ifndef YLM_GRID_PANEL_H
#define YLM_GRID_PANEL_H

#include "../grid.h"
#include "calibration.h"
#include "measure.h"

/* Points that have no part in refinement: what they say of a grid holds for all occupied points. */
typedef struct panel {
  size_t n;
  bool all;        /* they are all the occupied points there are */
  float *point;    /* [n][3] relative to the grid's origin */
  float *exact;    /* [n][width] */
  float *drift;    /* [n] bound of what rounding has added up to; 0 where all lights were summed */
  uint8_t *inside; /* [n] in or on a light: left out */
  float *side;     /* [n][3] normals; NULL: none are known */
  /* Of a dynamic grid, from its first update on: */
  ylm_grid_track *track; /* finds the points whose samples changed */
  float *sampled;        /* [n][width] samples of the grid as it was after the last update */
  bool known;            /* these are there */
} panel;

/* A panel that a grid keeps of its bake, and the measure of its errors. */
typedef struct grid_panel {
  panel points;
  measure measure;
} grid_panel;

/* The verdict of a panel about a grid. */
typedef struct ruling {
  size_t points, failed;
  size_t stuck; /* of those that failed, in voxels of the finest level */
  double
      error; /* a bound of the 99 % quantile of all points' errors, but for the chance of DOUBT */
  double largest;
  bool met; /* error <= tolerance */
} ruling;

/* -- what random points say of all: panel.c ---------------------------------------------- */

/*
** The most failures among n random points at which less than `share` of all points are said to
** fail. The number is the largest k for which this has a chance of at least 1 - doubt: where
** `share` or more fail, more than k of n do. -1: n points are too few.
*/
int ylm__confidence_allowed(size_t n, double share, double doubt);

/* -- panel.c ---------------------------------------------------------------------------- */

void ylm__panel_free(panel *p);
/* The grid has no panel any more: its light is another's. */
void ylm__grid_forget_panel(ylm_grid *g);
/* A panel of the same points with light of its own, a copy; what frees it; two that change it. */
ylm_status ylm__panel_copy_light(panel *to, const panel *from, size_t width);
void ylm__panel_forget_light(panel *p);
void ylm__panel_exchange(panel *a, panel *b);
/* Bytes of n points. */
size_t ylm__panel_bytes(const panel *p, size_t width);
/* The error of a sample at point i; negative: left out; what is no number fails. */
double ylm__panel_error(const panel *p, size_t i, const float *sample, size_t width, double floor);
/* Judges the errors of all points. */
ylm_status ylm__panel_rule(const panel *p, const double *error, double tolerance, double doubt,
                           ruling *out);
/* Judges samples of a finished grid. */
ylm_status ylm__panel_rule_samples(const ylm_grid *g, const panel *p, const float *sampled,
                                   double doubt, ruling *out);
/* The grid's stats say what the ruling does. */
void ylm__panel_report(ylm_grid_stats *s, const panel *p, const ruling *r, bool limited);

#endif
