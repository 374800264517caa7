/* occupy.c - the voxels that a bake begins with: the root of an octree whose occupied voxels are
   known, or a lattice's. */
#include "baker.h"
#include "surface.h"

#include <math.h>
#include <string.h>

/* -- lattices ------------------------------------------------------------------------------- */

/* Room for what is known before: voxels, and where all are occupied their points. */
static ylm_status reserve_uniform(baker *b, const uint8_t *mark, size_t n) {
  ylm_grid *g = b->g;
  const uint32_t *r = g->contents.resolution;
  size_t cells = 0, points = (size_t)(r[0] + 1) * (r[1] + 1) * (r[2] + 1);
  for (size_t i = 0; i < n; i++) cells += mark[i];
  ylm_status s = ylm__grid_reserve_cells(g, cells);
  bool all = cells == n && (!b->source->max_points || points <= b->source->max_points);
  return s == YLM_OK && all ? ylm__grid_reserve_points(g, points) : s;
}

/* Marks the voxels of a lattice that are occupied: all, those that hold shading points, or those
   that surfaces meet. */
static ylm_status mark_uniform(baker *b, uint8_t *mark, size_t n) {
  ylm_grid_stats *stats = &b->g->stats;
  uint64_t *voxel;
  size_t voxels;
  if (!b->source->meshes) {
    if (!b->source->occupied_points)
      memset(mark, 1, n);
    else
      ylm__occupancy_mark_uniform(b->g, b->source, mark, &stats->outside);
    return YLM_OK;
  }
  ylm_status s = ylm_grid_surface_voxels(b->g, b->source, &voxel, &voxels, &stats->outside, b->e);
  b->told = s != YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < voxels; i++) mark[voxel[i]] = 1;
  if (s == YLM_OK) ylm_free(voxel);
  return s;
}

/* Voxels of a lattice, all or those that are occupied. */
static ylm_status list_lattice(baker *b) {
  ylm_grid *g = b->g;
  const uint32_t *r = g->contents.resolution;
  size_t n = (size_t)r[0] * r[1] * r[2];
  uint8_t *mark = ylm_alloc_zero(n, 1);
  if (!mark) return YLM_ENOMEM;
  double t = ylm_seconds();
  ylm_status s = mark_uniform(b, mark, n);
  g->stats.occupancy_seconds += ylm_seconds() - t;
  if (s == YLM_OK) s = reserve_uniform(b, mark, n);
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    if (!mark[i]) continue;
    s = ylm__cell_list_push(&b->wave, (uint32_t)g->cells);
    if (s != YLM_OK) break;
    ylm_grid_cell c = {.error = NAN, .residual = NAN, .flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED};
    c.origin[0] = (uint32_t)(i % r[0]);
    c.origin[1] = (uint32_t)(i / r[0] % r[1]);
    c.origin[2] = (uint32_t)(i / r[0] / r[1]);
    for (int k = 0; k < 8; k++) c.corner[k] = YLM_GRID_NONE;
    g->cell[g->cells++] = c;
  }
  ylm_free(mark);
  return s;
}

/* -- octrees -------------------------------------------------------------------------------- */

/* Which voxels of an octree hold shading points: those of n codes, which it takes, if there are. */
static ylm_status find_occupied(baker *b, uint64_t *code, size_t n) {
  occupancy *o = &b->learnt.occupied;
  uint64_t *outside = &b->g->stats.outside;
  if (code) return ylm__occupancy_take(o, b->g, code, n);
  if (!b->source->meshes) return ylm__occupancy_build(o, b->g, b->source, outside);
  ylm_status s = ylm__occupancy_from_surfaces(o, b->g, b->source, outside, b->e);
  b->told = s != YLM_OK && s != YLM_ENOMEM;
  return s;
}

ylm_status ylm__occupy_voxels(baker *b, uint64_t *code, size_t n) {
  if (b->g->contents.form.kind == YLM_GRID_UNIFORM) return list_lattice(b);
  double t = ylm_seconds();
  ylm_status s = find_occupied(b, code, n);
  b->g->stats.occupancy_seconds += ylm_seconds() - t;
  return s == YLM_OK ? ylm__cells_root(b) : s;
}
