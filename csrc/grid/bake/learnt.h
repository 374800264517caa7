/* learnt.h - what a bake finds out beside the grid: its follower goes on with it. */
#ifndef YLM_GRID_LEARNT_H
#define YLM_GRID_LEARNT_H

#include "panel.h"

/* Ratios of measured error to the square of the metric, counted by powers of sqrt 2. */
typedef struct ratios {
  uint64_t count[256], n;
} ratios;

/* Knowledge of a bake that bakes like it go on with. */
typedef struct frames {
  ratios ratio;
  double tight;
  uint64_t bakes; /* in a row */
  size_t n, next; /* errors that are known; the place of the oldest once there are HELD_OUT */
  float error[HELD_OUT]; /* of the last held-out points */
} frames;

typedef struct learnt {
  occupancy occupied; /* which voxels hold shading points */
  /* Of a tolerance: */
  ratios ratio;
  double tight; /* the factor of estimates: tolerance.c */
  panel panel;  /* points that judge the grid */
} learnt;

#endif
