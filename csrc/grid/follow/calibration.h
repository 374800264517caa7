/*
** calibration.h - the tuned constants of grids that follow moving lights. Private to csrc/grid.
**
** spec/bench/moving.lua prints times of updates, spec/bench/updates.lua how often random updates break the promise
** of a tolerance.
*/
#ifndef YLM_GRID_FOLLOW_CALIBRATION_H
#define YLM_GRID_FOLLOW_CALIBRATION_H

/* -- what is remembered: follow.h ---------------------------------------------------------------- */

/* States of a mover that are remembered. */
#define STATES 64
/* Movers that are remembered. Beyond, the one that has rested longest is brought up to date. */
#define MANY_MOVERS 64
/* Changes of one update. Beyond, all is baked anew. */
#define MOST_CHANGES 256
/* Rounding of an update of a point, relative: of sums, and of the change itself. */
#define ROUNDING 5e-7
/* A voxel that failed verification stays split for so many updates; so many of these are
   remembered. */
#define FORCED_UPDATES 32
#define MOST_FORCED 4096

/* -- work: shift.c, stale.c, undo.c, signature.c, update.c --------------------------------------------------------------------- */

/* Points that a thread takes at a time. */
#define SHIFT_CHUNK 512
/* Points that a thread judges, points that it logs, and cells that it signs, at a time. */
#define STALE_GRAIN 512
#define UNDO_GRAIN 64
#define SIGN_GRAIN 4096
/* The change, relative, that points may miss where the caller says nothing. */
#define DEFAULT_TOLERANCE 1e-3

/* -- the promise: tolerance.c -------------------------------------------------------------------- */

/* Held-out points that are compared first; then twice as many a round. */
#define UPDATE_HELD 512
/* Tries to find half as many in voxels that changed. */
#define UPDATE_DRAWN 16384
/* Rounds at most. */
#define UPDATE_ROUNDS 8
/* By what the factor of estimates is multiplied in an update that passes at once. */
#define RELAX 0.98

#endif
