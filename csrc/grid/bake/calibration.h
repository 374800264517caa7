/*
** calibration.h - the tuned constants of bakes. Private to csrc/grid.
**
** Numbers of refinement by a tolerance were found by trying. They move how many points a grid has and how often it misses
** its tolerance. The judgement whether it keeps the tolerance is panel.c's alone, by points that have no part in
** refinement. Sizes of work move time alone.
**
** Bench: `make bench` (spec/bench/grid.c) prints points and time of a bake to 0.01, `make demo` the
** points and the judged error of one scene. "The lamps" below are 12 lamps over a floor and a ball
** at tolerances 0.1, 0.03, 0.01, 0.003: 2532, 4914, 8037, 15076 points, judged errors of 0.64,
** 0.65, 0.65, 0.56 of the tolerance.
*/
#ifndef YLM_GRID_CALIBRATION_H
#define YLM_GRID_CALIBRATION_H

/* -- estimates: residual.c, tolerance.c --------------------------------------------------- */

/* Factor of a voxel's estimate at first; it only grows. With 0.5, and LET_GO 0.001, STEP 2, the
   lamps took 2977, 5386, 8948, 16613 points. */
#define FIRST_TIGHT 0.35
/* Ratios of residual to squared metric before their quantiles are trusted; before, the metric alone
   is the estimate. */
#define FEW_RATIOS 32
/* Quantiles of these ratios: an estimate, and what may have to be measured. */
#define MEDIAN_RATIO 0.5
#define HIGH_RATIO 0.98

/* -- verification: verify.c ---------------------------------------------------------------- */

/* Points of the surface among which some are looked for in leaves that are wanted. */
#define IN_LEAVES ((uint64_t)1 << 16)
/* Held-out points of one round; rounds at most. */
#define HELD_OUT 2048
#define MAX_ROUNDS 16
/* Refinement ends where at most this part of the points fails: less than PROMISED, so that the
   promise also holds for points that are drawn with another seed. */
#define ENOUGH 0.006
/* Refinement also ends where at most this part fails in voxels that could be split. */
#define ENOUGH_REFINABLE 0.001
/* The part that may fail where more than PROMISED fail at the finest level: splitting others cannot keep the promise. */
#define ENOUGH_BESIDE_STUCK 0.005
/* Part of the points whose voxels the factor does not have to reach: they are split because of
   their points. With 0.001 one outlier tightened all of the grid (FIRST_TIGHT has the numbers). */
#define LET_GO 0.004
/* By how much the estimate that decides is to exceed the tolerance, and the most that the factor
   grows in a round. */
#define BEYOND 1.001
#define STEP 1.5

/* -- frames: go_on.c ------------------------------------------------------------------------- */

/* Held-out points of a bake like another, and the part of them that may fail without a round of refinement. */
#define FRAME_HELD 256
#define FRAME_FAILS 0.02
/* Ratios of which a bake in a row forgets half. */
#define FRAME_RATIOS 8192
/* Where more than ENOUGH of the last HELD_OUT points fail, the factor of estimates grows by the first for the next
   bake; where fewer than FRAME_FEW do, it shrinks by the second. */
#define FRAME_FEW 0.003
#define FRAME_TIGHTER 1.05
#define FRAME_LOOSER 0.98

/* -- surfaces: held_surface.c -------------------------------------------------------------- */

/* One held-out point in EXTRA is of a voxel, one of a triangle, of any area. Without triangles, a
   torus with 1/2500 of the area, a lamp beside it, missed a tolerance of 0.05 at 89 % of its
   points; with them at 0.5 %. The grid of the demo went from 62829 to 60947 points. */
#define EXTRA 8
/* Points by area that are drawn for each of these, to find voxels. */
#define CANDIDATES 16

/* -- judgement: panel.c --------------------------------------------------------------------- */

/* The part of the points that may fail, and the chance that a grid in which more fail is called good: the promise of
   docs/grids.md. */
#define PROMISED 0.01
#define DOUBT 0.01
/* Points that judge the updates of a grid. */
#define PANEL 4096
/* Degrees of irradiance that are compared: beyond, A(l) is below A(0)/1000. */
#define IRRADIANCE_MOST 32
/* Looks of a bake: at HELD_OUT points, then at twice as many, while chance decides. Each look has
   its part of DOUBT. */
#define LOOKS 4

/* -- the two sides of surfaces: held_lookups.c ---------------------------------------------- */

/* How far off a surface the field is asked, in parts of the thickness of a finest voxel; and at least, in parts of the
   largest coordinate relative to the scene's origin. */
#define SIDES_OFF 0x1p-10
#define SIDES_ROUNDING 0x1p-20

/* A place is buried where more of the directions that see surfaces see sides that are not used. */
#define SIDES_BURIED 0.5
/* The part of a ghost's norm that its way to the corner may change. */
#define GHOST_MOST 0.5
/* A place with less air above it than this part of the longest edge is covered; rays start so far off. */
#define COVERED 0x1p-8
#define COVERED_OFF 0x1p-14
/* Draws for the places of a round, where most are left out. */
#define HELD_TRIES 16
/* Rays by which a place finds that it sees no surface. */
#define SKYWARD 32

/* -- occupied voxels: occupancy.c, occupancy_triangles.c, surface.c ------------------------- */

/* The finest level that has one bit per voxel: 2 MiB. Triangles are marked in passes of OCCUPIED_STEP levels below. */
#define OCCUPIED_DENSE 8
#define OCCUPIED_STEP 2
/* Occupied voxels at most. */
#define OCCUPIED_MOST ((size_t)1 << 26)
/* Marks that a thread counts before it tells. */
#define OCCUPIED_TOLD 4096
/* Fewer triangles than this are shared among threads by parts of the lattice, OCCUPIED_PARTS along each axis. */
#define OCCUPIED_FEW 1024
#define OCCUPIED_PARTS 4
/* Triangles that a thread takes at a time. */
#define SURFACE_GRAIN 4096
/* Points of a block of the radix sort, and bits of one of its passes. */
#define SORT_BLOCK 16384
#define SORT_BITS 11

/* -- work: continuity.c, corners.c, evaluate.c, metric.c, processor.c, held_lookups.c ------- */

/* Points that a thread takes at a time where their numbers are computed; points and voxels where they are looked up
   or measured; cells whose corners are found. */
#define BAKE_GRAIN 64
#define BAKE_LOOK_GRAIN 512
#define BAKE_CELLS_GRAIN 1024

/* -- teams: divide.c --------------------------------------------------------------------------- */

/* A process evaluates whole multiples of so many points, where results are each point's own; a query of no more is everybody's. */
#define DIVIDE_GRAIN 64
/* Points whose results are exchanged at a time, at most: some 1.2 kB each. */
#define DIVIDE_ROUND ((size_t)1 << 18)
/* Points at which processes compare their light fields. */
#define DIVIDE_PROBES 8

/* -- back ends: bake.c -------------------------------------------------------------------------- */

/* The part of the tolerance times the shortest edge of the bounds that rounding of positions may be. */
#define REMOTE_ROUNDING 0.01
/* The part of the shortest edge of a finest voxel that it may be. */
#define REMOTE_VOXEL 0.1

#endif
