/*
** calibration.h - the tuned constants of materials. Private to csrc/material.
**
** `make bench BENCH=material` prints nanoseconds of a direction by kind and kernel set, `make bench BENCH=tables` seconds of
** a table, its size and its errors between rows.
*/
#ifndef YLM_MATERIAL_CALIBRATION_H
#define YLM_MATERIAL_CALIBRATION_H

/* -- kinds: ggx.c, abc.c, merl.c, rgl.c ------------------------------------------------------------ */

/* Places of GGX's albedo curve over sqrt(cosine), linear between them. */
#define GGX_CURVE 512
/* The part of a density below which directions that were mirrored in the surface add nothing (visible.h). */
#define MATERIAL_FOLDED 1e-7
/* Directions whose places in MERL's bins are found at once. */
#define MERL_BLOCK 64
/* Directions that a warp of RGL's files samples at once. */
#define WARP_BLOCK 16

/* -- albedos: albedo.c ----------------------------------------------------------------------------- */

/* Samples of a mean albedo, of one direction's, and of one call. Moved by: errors beside closed forms. */
#define ALBEDO_MEAN_SAMPLES ((size_t)1 << 15)
#define ALBEDO_SAMPLES ((size_t)1 << 14)
#define ALBEDO_BATCH 256

/* Cosines of eyes at which a material knows its excess, and samples at each. */
#define MATERIAL_EYES 16
#define EXCESS_SAMPLES 1024

/* -- degrees that a slice needs: degree.c ---------------------------------------------------------- */

/* Rows of directions: doubled from the least to the most until a slice's square settles. */
#define DEGREE_LEAST_ROWS 128
#define DEGREE_MOST_ROWS 1024

/* -- slices: slice.c ------------------------------------------------------------------------------- */

/* Half planes at once. */
#define SLICE_WIDE 8
/* Nodes in angle from the mirror direction: doubled from the least to the most, SLICE_RULES numbers of them. Twice as many
   stand in azimuth. */
#define SLICE_LEAST_NODES 24
#define SLICE_MOST_NODES 192
#define SLICE_RULES 4
/* The change of coefficients, relative to the slice's norm, at which they are enough. */
#define SLICE_SETTLED 1e-4
/* Nodes crowd towards the mirror direction as sinh(SLICE_CROWD u): the first tenth of them lies within a fiftieth of
   the angle. Moved by: errors of slices of small roughness, with as many nodes. */
#define SLICE_CROWD 6.0

/* -- tables: table.c, table_kept.c, fit.c ---------------------------------------------------------- */

/* Angles beyond this count as grazing: `error` is not about them. */
#define TABLE_LAST_TOLD (84.0 / 180 * YLM_PI)
/* Functions that are a smaller part of all slices than this are left out. */
#define TABLE_FAINT 1e-3
/* Columns at which rows are judged, and rows at which columns are. */
#define TABLE_JUDGES 4
/* Tables that a material keeps: rows and columns at first, and the largest error between them. */
#define KEPT_ROWS 32
#define KEPT_COLUMNS 64
#define KEPT_ERROR 0.002
/* The ridge of a fit, in parts of each diagonal element. Moved by: coefficients of narrow slices, which grow
   without it. */
#define FIT_RIDGE 1e-4

#endif
