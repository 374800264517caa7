/* planes.h - planes that cut a leaf apart, so that the sides of them that a place is on name what it is in. Private to csrc/grid. */
#ifndef YLM_GRID_SIDES_PLANES_H
#define YLM_GRID_SIDES_PLANES_H

#include "ylm_grid.h"

#define PLANES_MOST 4
/* Sides of them: bit k is whether normal[k] . place >= offset[k]. */
#define PLANES_SIDES (1 << PLANES_MOST)

/* In edges of the leaf. */
typedef struct side_plane {
  double normal[3], offset;
} side_plane;

/* A place whose part is known. */
typedef struct side_sample {
  float at[3], weight;
  uint8_t part;
} side_sample;

static inline double plane_height(const side_plane *p, const float at[3]) {
  double h = -p->offset;
  for (int a = 0; a < 3; a++) h += p->normal[a] * (double)at[a];
  return h;
}

/*
** ylm__planes_choose - which of some planes tell parts apart: the one that leaves the least weight of samples in the wrong part,
** then the next, until none gains more than `gain` of the weight.
**
**   sample  in   [n] of `parts` parts, at most YLM_GRID_PARTS
**   side    out  [n] the sides that samples are on; zeros before
**   chosen  out  [PLANES_MOST] the planes
**   part    out  [PLANES_SIDES] the part of each of their sides
**   left    out  the weight that stays in the wrong part
**
** Returns how many were chosen.
*/
size_t ylm__planes_choose(size_t n, const side_sample *sample, uint8_t parts, size_t planes,
                          const side_plane *plane, double gain, uint8_t *side,
                          size_t chosen[PLANES_MOST], uint8_t part[PLANES_SIDES], double *left);

#endif
