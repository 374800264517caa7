/*
** calibration.h - the tuned constants of sets of lights. Private to csrc/light; moments/, tree/ and flat/ have their own.
**
** `make bench BENCH=light` prints nanoseconds for each pair of a light and a point, spec/bench/updates.lua what
** random updates of grids cost and miss.
*/
#ifndef YLM_LIGHT_CALIBRATION_H
#define YLM_LIGHT_CALIBRATION_H

/* Lights of a leaf, and pairs of box and light from which on a tree is worth its making. */
#define CROSSES_LEAF 8
#define CROSSES_FEW 65536
/* Boxes, and points of sampled light, that a thread takes at a time. */
#define CROSSES_GRAIN 256
#define SAMPLED_GRAIN 64
/* Points of one step of a sum of fields: results of a part are kept for as many. */
#define YLM__SUM_POINTS 256
/* In radii: nearer to a sphere that changed, all lights are summed. Moved by: errors of updates
   beside lamps that move. */
#define YLM__NEAR 3.0

#endif
