/*
** calibration.h - the tuned constants of light on surfaces. Private to csrc/surface.
**
** Lengths are parts of the root of the scene's area. `build/ylm run spec/bench/rooms.lua` prints errors and numbers of
** eight scenes beside paths, which moved them.
*/
#ifndef YLM_SURFACE_CALIBRATION_H
#define YLM_SURFACE_CALIBRATION_H

/* -- charts: charts.c ---------------------------------------------------------------------------- */

/* Planes of a mesh with less than this part of the area are round: one chart each would cost more than it holds. */
#define PLANE_LEAST 5e-5
/* Triangles are of one plane where normals, and distances over the root of the area, agree to about this. */
#define PLANE_NORMAL 5e-4
#define PLANE_DISTANCE 2e-5
/* The least component of a normal by which a chart of a round mesh counts. */
#define ROUND_LEAST 0.55

/* -- rectangles: tree.c, refine.c ---------------------------------------------------------------- */

/* Edges of the first rectangles at most, and of the last at least. */
#define WIDEST 0.125
#define NARROWEST 0.001
/* Rectangles with less than this part of all places are not too wide. */
#define WIDE_PLACES 5e-4
/* Sites that a rectangle gets more where it has too few, and the square of its error, over the aim's, from which it does. */
#define DENSER 96
#define DENSER_ERROR 0.1
/* The least component, along the axis of a rectangle, of the normal of a plane that gets these. */
#define FLAT_LEAST 0.1
/* Random places from which all others are chosen; of a budget, as many for each of its corners, and at least. */
#define PLACES 1000000
#define PLACES_CORNER 2000
#define PLACES_BUDGET 200000
#define SITE_BLOCK 4000
/* A rectangle with fewer is not halved. */
#define PLACES_LEAST 22
/* One of so many is for judges alone. */
#define JUDGES_SHARE 8
/* Places of a rectangle whose light is asked for, and of the whole surface. */
#define SAMPLES 16
#define SAMPLES_ALL 12000
/* Where places turn out to be buried others are asked, twice as many on each pass. */
#define SAMPLE_PASSES 6
/* Each is the farthest of so many from those before. */
#define SPREAD 6
/* The part of rectangles that a round halves, and the least score that counts, over the largest. */
#define ROUND_SPLIT 0.3
#define SCORE_LEAST 0.002
#define ROUNDS 48
/* Unknowns that a rectangle has of its own, about: corners are shared. */
#define FREEDOM 1.5

/* -- fits: fit.c --------------------------------------------------------------------------------- */

/* Weights of a rectangle's twist and of the differences along its edges, beside those of places. */
#define TWIST 0.1
#define SLOPE 0.003
/* Weight of a place that another surface covers: no promise is about it, and its darkness is not that beside the cover. */
#define COVERED_WEIGHT 0.01
/* Where the noise of places exceeds this part of the aim, their rays are as many more, and at most so many times as many. */
#define FIT_NOISE 0.6
#define FIT_MOST 8
#define FIT_STEPS 150
#define FIT_SMALL 1e-12

/* -- corners: corners.c -------------------------------------------------------------------------- */

/* Places beside a corner are looked for among so many. */
#define CORNER_PLACES 128
/* Where the nearest turns out to be buried so often, only places that have light count. */
#define NEAREST_PASSES 4
/* Surfaces join where they lie off each other's plane by less than this part of their distance, and a bit. */
#define JOIN_SLOPE 0.4
#define JOIN_BIT 2e-4
/* Sight between two places of one plane passes this far above it; over others it goes up by a part of the distance. */
#define SIGHT_OFF 1e-5
#define SIGHT_UP 0.25

/* -- cuts: cut.c --------------------------------------------------------------------------------- */

/* Places by which parts are told apart, lines that are tried (so many times as many where places are many), and the part of
   places that may lie wrong. */
#define CUT_PLACES 48
#define CUT_LINES 32
#define CUT_DENSE 8
#define CUT_WRONG 0.12
/* Places beside corners are looked for among so many; a part has the light of so many places at least, and is cut off where
   that leaves less than this part of the error. */
#define CUT_CORNERS 1024
#define CUT_SIDE 6
#define CUT_GAIN 0.5
/* Then the line is moved and turned by so many places near it, by as many as a leaf that something crosses is looked at with;
   this many times, within so many gaps, by so many parts of the angle before. */
#define CUT_NEAR 1024
#define CUT_TURNS 3
#define CUT_BAND 4
#define CUT_FINER 8
/* A wall that leans hides places this many heights of sight away from where it meets the surface. */
#define CUT_SLANT 4

/* -- the end of refinement: refine.c ------------------------------------------------------------- */

/* Fresh places at most and at least, so many a rectangle, and rays of each half of their light: so many that their noise
   is this part of the tolerance. */
#define JUDGES (8 * 1024)
#define JUDGES_FEW (2 * 1024)
#define JUDGES_EACH 0.5
#define JUDGE_NOISE 0.3
#define JUDGE_LEAST 64
#define JUDGE_MOST 2048
/* The part of them that may fail where refinement ends: where another judge follows, and else, since there are JUDGED_MOST looks:
   of 2,048 places 6, and a surface of which 1 % fails passes one of them with a chance of 2e-4. */
#define ENOUGH 0.006
#define ENOUGH_SURE 0.003
/* They are asked where about so few places are expected to fail, or where corners have grown by so much. Refinement also ends
   after so many looks, and where so many in a row find no fewer failures than one before. */
#define HOPE 0.02
#define GROWN 1.5
#define JUDGED_MOST 6
#define JUDGED_IDLE 3
/* Fits of other light on the same rectangles: places that judged one become places of the next. */
#define REFITS 6
/* Covered: another surface is nearer than this. */
#define COVERED 2e-3

/* Work of a thread at a time. */
#define SURFACE_GRAIN 256

#endif
