/* learnt.h - what a bake finds out beside the grid: its follower goes on with it. */
#ifndef YLM_GRID_LEARNT_H
#define YLM_GRID_LEARNT_H

#include "panel.h"

/* Ratios of measured error to the square of the metric, counted by powers of sqrt 2. */
typedef struct ratios {
  uint64_t count[256], n;
} ratios;

typedef struct learnt {
  occupancy occupied; /* which voxels hold shading points */
  /* Of a tolerance: */
  ratios ratio;
  double tight; /* the factor of estimates: tolerance.c */
  panel panel;  /* points that judge the grid */
} learnt;

#endif
