/*
** calibration.h - the tuned constants of the light field of what surfaces send back. Private to csrc/transfer.
**
** `make bench BENCH=gather` prints microseconds of a point beside bare rays; spec/gather_spec.lua holds the errors.
*/
#ifndef YLM_TRANSFER_GATHER_CALIBRATION_H
#define YLM_TRANSFER_GATHER_CALIBRATION_H

/* -- cells: cells.c, lattice.c ------------------------------------------------------------------- */

/* In a round of splits at most this many rays for each ray of the base; contrasts count for less
   beyond. */
#define CELLS_ROUND 1.5
/* Rays that are traced at once. */
#define CELLS_RAYS 256

/* -- sums: sums.c -------------------------------------------------------------------------------- */

/* Borders of l (l+1) length^2 above this have two Gauss points. */
#define SUMS_LONG 0.4f
/* Borders of lmax times their length below this are taken as one. */
#define SUMS_GROUPED 0.15
/* Surfaces seen at a lower cosine count as seen at this one where hit points move. */
#define SUMS_GRAZING 0.1f
/* Directions that are summed at once. */
#define GATHER_BATCH 64

/* -- direct light with shadows: direct.c, lamps.c ------------------------------------------------ */

/* The most groups of a point, its shadow rays, those of a group, and rays of a group to begin
   with. */
#define GATHER_GROUPS 64
#define GATHER_SHADOWS 256
#define GATHER_OF_GROUP 64
#define GATHER_FIRST 4
/* Nodes below this share of the light, or seen under this angle, need not be opened. */
#define SMALL_SHARE 1e-4
#define SMALL_ANGLE 0.02

#endif
