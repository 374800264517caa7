/* levels.h - what the files of sums by levels share: merge.c, levels.c, levels.isa.c. Private to the folder. */
#ifndef YLM_LIGHT_VIRTUAL_LEVELS_H
#define YLM_LIGHT_VIRTUAL_LEVELS_H

#include "../virtual.h"

/* Lights of v, merged in cells of that edge, with radii below `core`: *m has v's profile, and no field. To be freed by
   the other. YLM_ENOMEM. */
ylm_status ylm__virtual_merge(const ylm_light_virtual *v, double cell, double core,
                              ylm_light_virtual *m);
void ylm__virtual_merged_free(ylm_light_virtual *m);

enum {
  YLM__LEVEL_PAD = 16
}; /* numbers that a row may be read beyond its end, which change nothing */

/* The rows of a cell's corners: corner i + 2j + 4k, its value, then its slopes by x, y, z. */
typedef struct ylm__level_cell {
  const float *row[8]; /* [4][stride] each */
  size_t stride;       /* numbers of a row, a multiple of 16; the last of them are 0 */
  float edge[3];
} ylm__level_cell;

/* Points of a cell, in runs that share a normal. */
typedef struct ylm__level_points {
  size_t n, count;       /* count: (lmax+1)^2 */
  const float *t[3];     /* [n] 0 .. 1 within the cell, and a vector more */
  const float *cosine;   /* [n][wide] the clamped cosine about their normals, 0 from `count` on */
  size_t wide;           /* a multiple of 16 */
  const uint32_t *which; /* [n] where their results go */
  const uint32_t *run;   /* [n] how many points from this on have its normal */
} ylm__level_points;

/* The value and its slopes at t of a cell: to [4][stride]. */
typedef void ylm__level_mix_fn(const ylm__level_cell *c, const float t[3], float *to);
/* Adds irradiance to out + 3 which[i]. */
typedef void ylm__level_shine_fn(const ylm__level_cell *c, const ylm__level_points *p, float *out);

#endif
