/*
** calibration.h - the tuned constants of spherical harmonics. Private to csrc/sh; rotate/rotate.h has those of rotations.
**
** `make bench BENCH=sh` prints nanoseconds of a direction, `make bench BENCH=products` those of a product, both by method and
** degree.
*/
#ifndef YLM_SH_CALIBRATION_H
#define YLM_SH_CALIBRATION_H

/* -- values: eval/ ------------------------------------------------------------------------------- */

/* Directions of a block of work. */
#define SH_EVAL_GRAIN 512
/* Coefficients of degrees up to this stand in a table (gen/sh_table.h); those of higher ones are
   computed by each call. */
#define SH_TABLE_LMAX 24
/* Above this degree float loses Y near the poles, where sin^m underflows too early: double is
   computed. */
#define SH_FLOAT_LMAX 128
/* Columns that wait for a whole block; they are flushed when there are this many. */
#define SH_WAITING 96

/* -- products: product/ -------------------------------------------------------------------------- */

/* Products by Gaunt coefficients have code of their own up to this lmax (gen/gaunt_low.h). */
#define PRODUCT_GAUNT_LOW 3
/* More integrals than this are refused: the method pays for far fewer only. */
#define GAUNT_MOST 20000000

/* -- projection: project/ ------------------------------------------------------------------------ */

/* Samples of a partial sum, and of one evaluation of the basis within it. */
#define PROJECT_GRAIN 4096
#define PROJECT_BLOCK 128
/* Directions that are evaluated at a time: their basis functions stay in the cache. */
#define RECONSTRUCT_BLOCK 64

#endif
