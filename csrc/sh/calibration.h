/*
** calibration.h - the tuned constants of spherical harmonics. Private to csrc/sh.
**
** `make bench BENCH=sh` prints nanoseconds of a direction, BENCH=products those of a product, BENCH=rotate those of a
** rotated vector, all by method and degree. BENCH=glossy has rows that are turned and multiplied in one pass.
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
/* Products, rows of a matrix of products, and rows times stacked matrices, that a thread takes at a time. */
#define PRODUCT_GRAIN 64
#define TRANSFER_GRAIN 64
#define STACK_GRAIN 256
/* Nodes whose rings are there at once, of factors that several rows share. */
#define PRODUCT_CHUNK 8
/* Sums that share what they read, as many as registers hold. Batches (product_batch.h): nodes, azimuths and orders at
   a time. Factors that rows share (product_shared.h): nodes, azimuths, orders and sums. Matrices of products
   (transfer_kernel.h): rows. Rotations of batches (rotate_batch.h): rows of a quarter turn. */
#define BATCH_NODES 4
#if YLM_VECTOR_BYTES == 64
#define BATCH_AZIMUTHS 3
#define BATCH_ORDERS 4
#define SHARED_NODES 4
#define SHARED_AZIMUTHS 3
#define SHARED_ORDERS 5
#define SHARED_SUMS 8
#define TRANSFER_ROWS 8
#define ROTATE_PANEL 8
#else
#define BATCH_AZIMUTHS 1
#define BATCH_ORDERS 2
#define SHARED_NODES 3
#define SHARED_AZIMUTHS 1
#define SHARED_ORDERS 3
#define SHARED_SUMS 4
#define TRANSFER_ROWS 4
#define ROTATE_PANEL 4
#endif

/* -- rotations: rotate/ -------------------------------------------------------------------------- */

/* Degrees from here on are rotated in tiles of rows. Up to ROTATE_BLOCKS there are blocks too, for a few rows. Moved
   by: vectors of 1000 a second, and the time of making a rotation. */
#define ROTATE_TILED 8
#define ROTATE_BLOCKS 20
/* The highest degree of rows that are turned and multiplied in one pass. */
#define ROTATE_TIMES_LMAX 14
/* By how much columns of rotations that are given for rows may depart from orthonormal ones. */
#define ROTATE_NEAR 1e-3

/* -- projection, conversion: project/, convert.c ------------------------------------------------- */

/* Groups of rows that a thread converts at a time (convert.c). */
#define CONVERT_GRAIN 256
/* Samples of a partial sum, and of one evaluation of the basis within it. */
#define PROJECT_GRAIN 4096
#define PROJECT_BLOCK 128
/* Directions that are evaluated at a time: their basis functions stay in the cache. */
#define RECONSTRUCT_BLOCK 64

#endif
