/*
** warp.h - functions over the unit square in slices, and maps of the square by their densities.
** Private to csrc/material.
**
** A function is given at the nodes of a raster that covers the square with its border, and is
** bilinear between them. A slice belongs to a value of the parameters; slices are blended.
*/
#ifndef YLM_MATERIAL_WARP_H
#define YLM_MATERIAL_WARP_H

#include "calibration.h"
#include "ylm_base.h"

/* Slices by their shares, which add up to 1. */
typedef struct blend {
  int n; /* 2 or 4 */
  size_t slice[4];
  float share[4];
} blend;

/* A function of one slice. */
typedef struct raster {
  int width, height;
  float *value; /* [height][width] */
} raster;

/* Densities; those of a blend are blended before they are inverted, and so are their integrals. */
typedef struct warp {
  int width, height;  /* at least 2 */
  float *density;     /* [slices][height][width]  over the integral of the slice, in cells */
  float *conditional; /* [slices][height][width]  integral along a row up to x */
  float *marginal;    /* [slices][height]         of all rows up to y */
} warp;

/* The value at u, which is clamped to the square. */
float ylm__raster_at(const raster *r, const float u[2]);

/* Three values at u, of [slices][height][width][4]. */
void ylm__colours_at(int width, int height, const float *value, const blend *b, const float u[2],
                     float out[3]);

/* Fills a slice from its densities, where negative ones count as 0; false: next to nothing is left. */
bool ylm__warp_fill(warp *w, size_t slice, const float *density);

/* The density at a place. */
float ylm__warp_density(const warp *w, const blend *b, const float at[2]);

/* At most WARP_BLOCK places at a time. */

/* Of each of n places u the place out before which that share of the density lies, and the density
   there. */
void ylm__warp_sample(const warp *w, size_t n, const blend *b, const float (*u)[2], float (*out)[2],
                      float *density);

/* Its inverse: u of the place at; returns the density there. */
float ylm__warp_invert(const warp *w, const blend *b, const float at[2], float u[2]);

#endif
