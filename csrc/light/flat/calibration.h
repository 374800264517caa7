/*
** calibration.h - the tuned constants of flat lights. Private to csrc/light.
**
** `make bench BENCH=flat` prints microseconds for each pair of a light and a point, by kernels and by the reference;
** spec/light_polygon_spec.lua holds the errors.
*/
#ifndef YLM_LIGHT_FLAT_CALIBRATION_H
#define YLM_LIGHT_FLAT_CALIBRATION_H

/* Lights from which on the maps from sums to results pay. */
#define YLM__MERGED_LEAST 4
/* Points of a block of work. */
#define YLM__POLYGON_BLOCK 256
/* Nodes at which the reference evaluates the basis at once. */
#define YLM__BATCH 16
/* Nodes of a rim that the kernels add at once. */
#define AT_ONCE 4
/* The most equal steps around a rim: panels are faster where it needs more. */
#define YLM__STEPS 96
/* Rims are integrated in panels of at most 1/YLM__RIM_RATIO of twice their distance, by 24 nodes or
   more: the integrand's nearest singularity then lies where they leave 1e-17. YLM__RIM_PANELS have
   room. */
#define YLM__RIM_RATIO 1.5
#define YLM__RIM_PANELS 256
/* Relative to the distance: nearer to its plane than this, a flat light is taken as seen
   edge-on. */
#define YLM__EDGE_ON 1e-15
/* (lmax + 4) times its reach over its distance: smaller than this, a light is seen from far. Moved
   by: errors of both formulas there. */
#define YLM__FAR 0.02
/* In reaches: nearer to an exact flat light that changed, all lights are summed. */
#define YLM__NEAR_FLAT 0.5

#endif
