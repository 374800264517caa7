/*
** held_surface.c - held-out points of surfaces.
**
** A promise is about surfaces by area, and so are the points that judge it. While a grid is
** refined, one point in EXTRA is of a voxel chosen among all that surfaces meet. One in EXTRA is of
** a triangle chosen among all. Such points look at voxels and triangles that are small, and seldom
** met by area.
*/
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../bake/surface.h"
#include "tolerance.h"

typedef struct candidate {
  float x[3];
  uint32_t leaf;
  uint64_t draw;
} candidate;

static int by_leaf(const void *a, const void *b) {
  const candidate *x = a, *y = b;
  return x->leaf != y->leaf ? (x->leaf < y->leaf ? -1 : 1) : memcmp(x->x, y->x, sizeof x->x);
}

/* Writes one point of each of n random voxels among those of the candidates; of fewer, if there are
   not as many, how many is returned. */
static size_t choose_voxels(candidate *c, size_t candidates, ylm_rng *rng, size_t n, float *out) {
  size_t voxels = 0;
  qsort(c, candidates, sizeof *c, by_leaf);
  for (size_t i = 0; i < candidates; i++)
    if (!voxels || c[i].leaf != c[voxels - 1].leaf) c[voxels++] = c[i];
  if (n > voxels) n = voxels;
  for (size_t i = 0; i < n; i++) {
    size_t k = i + (size_t)(ylm_rng_double(rng) * (double)(voxels - i));
    candidate chosen = c[k];
    c[k] = c[i];
    c[i] = chosen;
    memcpy(out + 3 * i, chosen.x, sizeof chosen.x);
  }
  return n;
}

/* Points of n random voxels; of fewer, if there are not as many. */
static ylm_status hold_voxels(refiner *r, uint64_t round, size_t *n, float *out) {
  uint64_t seed = ~r->b->source->seed;
  size_t candidates = CANDIDATES * *n;
  candidate *c = ylm_alloc(candidates, sizeof *c);
  ylm_rng rng;
  if (!c) return YLM_ENOMEM;
  ylm_rng_seed(&rng, seed, round);
  for (size_t i = 0; i < candidates; i++) {
    ylm__held_surface_point(r, seed, round * candidates + i, candidates, c[i].x);
    c[i].leaf = ylm__held_leaf(r->b->g, c[i].x);
    c[i].draw = round * candidates + i;
  }
  *n = choose_voxels(c, candidates, &rng, *n, out);
  for (size_t i = 0; r->side && i < *n; i++)
    ylm__held_surface_side(r->surface, seed, c[i].draw, candidates, r->side + 3 * i);
  ylm_free(c);
  return YLM_OK;
}

/* Points of up to n random triangles; how many are within the bounds. */
static size_t hold_triangles(const refiner *r, uint64_t round, size_t n, float *out, float *side) {
  size_t held = 0;
  for (size_t i = 0; i < n; i++) {
    double p[3], normal[3];
    uint64_t k = ~(round * n + i);
    if (!ylm__surface_draw_alike(r->surface, r->b->source->seed, k, p, normal)) continue;
    for (size_t a = 0; side && a < 3; a++)
      side[3 * held + a] = (float)(k & 1 ? -normal[a] : normal[a]);
    ylm__grid_inward(r->b->g, p, out + 3 * held);
    held++;
  }
  return held;
}

ylm_status ylm__held_surface(refiner *r, uint64_t round, size_t n) {
  size_t voxels = n / EXTRA, aside = 0;
  ylm_status s = YLM_OK;
  if (round <= MAX_ROUNDS) {
    s = hold_voxels(r, round, &voxels, r->points);
    aside = voxels + hold_triangles(r, round, n / EXTRA, r->points + 3 * voxels,
                                    r->side ? r->side + 3 * voxels : NULL);
  }
  size_t area = n - aside;
  for (size_t i = 0; s == YLM_OK && r->side && i < area; i++)
    ylm__held_surface_side(r->surface, r->b->source->seed, round * n + i, area,
                           r->side + 3 * (aside + i));
  for (size_t i = 0; s == YLM_OK && i < area; i++)
    ylm__held_surface_point(r, r->b->source->seed, round * n + i, area,
                            r->points + 3 * (aside + i));
  return s;
}
