/*
** calibration.h - the tuned constants of sides. Private to csrc/grid.
**
** `make bench BENCH=rooms` prints errors and points of grids in rooms: what a change of theirs does.
*/
#ifndef YLM_GRID_SIDES_CALIBRATION_H
#define YLM_GRID_SIDES_CALIBRATION_H

/* A surface crosses a leaf where it meets its box, larger by this part of its edges. */
#define SIDES_MARGIN 1e-3
/* Poles of a connected set of pieces, at most; the last one takes the rest. */
#define SIDES_POLES 6
/* Pieces of a connected set by which it is found to lie in a body. */
#define SIDES_TRIED 4
/* A ghost's light is that of a place this part of the way before the surface. */
#define GHOST_BEFORE 0.35
/* A corner is seen where the way to it is free for this part more: one on a surface is not. */
#define LOOK_BEYOND 0.02
/* How far off its surface a point is looked up, in edges; pieces are sought around the place this many edges in front. */
#define LOOK_OFF 1e-3
#define LOOK_FRONT 0.125
/* Pieces that a look-up by rays asks, at most. */
#define LOOK_PIECES 40
/* Leaves that a thread cuts at a time. */
#define SIDES_GRAIN 4

/* -- refinement: pool.c --------------------------------------------------------------------------- */

/* Leaves wider than this part of the bounds are split in any case. */
#define POOL_WIDEST 0.125
/* An error below this part of the tolerance counts for nothing; its square, over the tolerance's, counts for at most CLIP,
   or FAR where squares are asked for. */
#define POOL_SLIGHT 0.5
#define POOL_CLIP 4
/* Refinement also ends where at most this part of the places fails in leaves that may be split. */
#define POOL_OPEN 0.002
/* Of an error over the tolerance, in what tells whether a split has helped, at most. */
#define POOL_FAR 1e4
/* Errors of so many times the tolerance are gross: leaves are split for one of them alone. */
#define POOL_GROSS 5
/* Leaves whose corners' light differs by more than this part of its norm are suspect: a place in them is looked at. */
#define POOL_SUSPECT 0.5f
/* Places at most. */
#define POOL_MOST ((size_t)1 << 14)
/* The part of all leaves that a round splits at most. */
#define POOL_SPLIT (1.0 / 16)
/* Points that a split costs, for budgets. */
#define POOL_COST 12
/* A split that leaves more than this part of a leaf's score to its children has not helped; twice in a row is enough. */
#define POOL_HELPS 0.6
#define POOL_STRIKES 2
/* Strikes where errors are gross. */
#define POOL_STRIKES_GROSS 5
/* Rounds of draws begin here: away from those of panels. */
#define POOL_FROM 1024
/* Rounds at most. */
#define POOL_ROUNDS 48

#endif
