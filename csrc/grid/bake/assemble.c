/* assemble.c - a grid of cells and points that a back end has kept: on a device. */
#include "baker.h"

#include <math.h>

/* Arrays are grown by what their users have declared: so all that was written is kept. */
ylm_status ylm_grid_room(ylm_grid *g, size_t cells, size_t points, ylm_grid_parts *parts,
                         ylm_error *e) {
  ylm_status s = YLM_OK;
  if (cells > g->cells) s = ylm__grid_reserve_cells(g, cells - g->cells);
  if (s == YLM_OK && points > g->points) s = ylm__grid_reserve_points(g, points - g->points);
  if (s != YLM_OK)
    return ylm_fail(e, s,
                    s == YLM_ENOMEM ? "the grid does not fit into memory"
                                    : "more cells or points than a grid can have");
  if (cells > g->cells) g->cells = cells;
  if (points > g->points) g->points = points;
  *parts = (ylm_grid_parts){g->cell, g->lattice, g->stride, g->data, g->lambda, g->norm, g->flags};
  return YLM_OK;
}

ylm_grid_stats *ylm_grid_stats_of(ylm_grid *g) { return &g->stats; }

bool ylm_grid_voxel(const ylm_grid *g, const double p[3], uint32_t voxel[3]) {
  double at[3];
  bool inside = ylm__grid_coordinates(g, p, at);
  for (int a = 0; a < 3; a++) {
    uint32_t last = g->contents.resolution[a] - 1, c = (uint32_t)at[a];
    voxel[a] = c > last ? last : c;
  }
  return inside;
}

/* -- checking ------------------------------------------------------------------------------ */

/* Corners of an occupied cell are points, and where they should be; others have none. */
static bool corners_hold(const ylm_grid *g, const ylm_grid_cell *c) {
  for (int k = 0; k < 8; k++) {
    uint32_t p = c->corner[k], at[3];
    if (!(c->flags & YLM_GRID_OCCUPIED)) {
      if (p != YLM_GRID_NONE) return false;
      continue;
    }
    if (p >= g->points) return false;
    ylm__grid_corner_at(g, c, k, at);
    if (memcmp(g->lattice + 3 * (size_t)p, at, sizeof at) != 0) return false;
  }
  return true;
}

/* The children of cell i follow those of all cells before it, and lie where they should. */
static bool children_hold(const ylm_grid *g, size_t i, size_t next) {
  const ylm_grid_cell *c = &g->cell[i];
  if (c->child != next || g->cells - next < 8 || c->level >= g->contents.form.depth) return false;
  uint32_t half = ylm__grid_edge(g, c) / 2;
  for (uint32_t k = 0; k < 8; k++) {
    const ylm_grid_cell *d = &g->cell[next + k];
    if (d->level != c->level + 1) return false;
    for (int a = 0; a < 3; a++)
      if (d->origin[a] != c->origin[a] + (k >> a & 1 ? half : 0)) return false;
  }
  return true;
}

static bool octree_holds(const ylm_grid *g) {
  const uint8_t known = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_CROSSED;
  size_t next = 1;
  if (!g->cells || !g->points) return false;
  const ylm_grid_cell *root = g->cell;
  if (root->level || root->origin[0] || root->origin[1] || root->origin[2]) return false;
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (i >= next || c->flags & ~known || !corners_hold(g, c)) return false;
    if (!(c->flags & YLM_GRID_LEAF) != (c->child != 0)) return false;
    if (!c->child) continue;
    if (!children_hold(g, i, next)) return false;
    next += 8;
  }
  return next == g->cells;
}

/* Voxels of a lattice stand in its order, each once. */
static bool lattice_holds(const ylm_grid *g) {
  const uint32_t *r = g->contents.resolution;
  uint64_t next = 0;
  if (!g->cells || !g->points) return false;
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    uint64_t at = ((uint64_t)c->origin[2] * r[1] + c->origin[1]) * r[0] + c->origin[0];
    for (int a = 0; a < 3; a++)
      if (c->origin[a] >= r[a]) return false;
    if (at < next || c->level || c->child || !corners_hold(g, c)) return false;
    if (c->flags != (YLM_GRID_LEAF | YLM_GRID_OCCUPIED)) return false;
    next = at + 1;
  }
  return true;
}

/* -- finishing ----------------------------------------------------------------------------- */

/* Fields of a cell that the caller has not written. */
static void complete_cells(ylm_grid *g) {
  for (size_t i = 0; i < g->cells; i++) {
    g->cell[i].residual = NAN;
    g->cell[i].source = g->cell[i].detail = 0;
  }
}

ylm_status ylm__assemble(baker *b) {
  ylm_grid *g = b->g;
  bool uniform = g->contents.form.kind == YLM_GRID_UNIFORM;
  g->evaluated = g->points;
  if (!(uniform ? lattice_holds(g) : octree_holds(g)))
    return ylm_fail(b->e, YLM_EINVAL, "the cells are no octree");
  complete_cells(g);
  double t = ylm_seconds();
  ylm_status s = ylm__lattice_hash_reserve(&g->hash, g->points);
  for (size_t i = 0; s == YLM_OK && i < g->points; i++)
    *ylm__lattice_hash_at(&g->hash, lattice_key(g->lattice + 3 * i)) = (uint32_t)i;
  g->stats.lattice_seconds += ylm_seconds() - t;
  return s;
}
