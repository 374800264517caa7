/* virtual.c - voxels without data of their own, continued from their ancestor while sampling. */
#include "../grid.h"

#include <math.h>
#include <string.h>

/* Gives the virtual cell the corner at place n of its own half-edge lattice: an evaluated point's
   rows, or rows interpolated into `to`. */
static void virtual_corner(const ylm_grid *g, const virtual_cell *v, const uint32_t place[3],
                           float *to, const float *row[4]) {
  uint32_t half = v->edge / 2, at[3];
  int corner = 0, middle = 0;
  float t[3];
  for (int a = 0; a < 3; a++) {
    at[a] = v->origin[a] + place[a] * half;
    t[a] = 0.5f * (float)place[a];
    middle += place[a] == 1;
    corner |= (int)(place[a] / 2) << a;
  }
  uint32_t point = middle ? ylm__lattice_hash_find(&g->hash, lattice_key(at)) : YLM_GRID_NONE;
  for (int r = 0; r < 4; r++) {
    if (!middle) /* its rows may lie in the room that the next descent writes to */
      row[r] = memcpy(to + (size_t)r * g->stride, v->row[8 * r + corner], g->stride * sizeof *to);
    else if (point != YLM_GRID_NONE)
      row[r] = ylm__grid_row(g, point, r);
    else
      row[r] = to + (size_t)r * g->stride;
  }
  if (middle && point == YLM_GRID_NONE) ylm__grid_mix(g, v->row, v->edge, t, to, to + g->stride);
}

/* Replaces the virtual cell by its child number k; `to` is room for eight corners. */
static void virtual_descend(const ylm_grid *g, virtual_cell *v, uint32_t k, float *to) {
  const float *row[32];
  for (uint32_t i = 0; i < 8; i++) {
    uint32_t place[3];
    const float *corner[4];
    for (int a = 0; a < 3; a++) place[a] = (k >> a & 1) + (i >> a & 1);
    virtual_corner(g, v, place, to + i * 4 * g->stride, corner);
    for (uint32_t r = 0; r < 4; r++) row[8 * r + i] = corner[r];
  }
  memcpy(v->row, row, sizeof row);
  v->edge /= 2;
  for (int a = 0; a < 3; a++) v->origin[a] += k >> a & 1 ? v->edge : 0;
}

void ylm__grid_virtual(const ylm_grid *g, uint32_t leaf, const double at[3], virtual_cell *v,
                       float *scratch) {
  const ylm_grid_cell *c = &g->cell[leaf], *from = &g->cell[c->source];
  memcpy(v->origin, from->origin, sizeof v->origin);
  v->edge = ylm__grid_edge(g, from);
  for (int r = 0; r < 4; r++)
    for (int k = 0; k < 8; k++) v->row[8 * r + k] = ylm__grid_row(g, from->corner[k], r);
  uint32_t last = 1u << (g->contents.form.depth - c->detail);
  for (int level = 0; v->edge > last; level++) {
    uint32_t k = 0;
    for (int a = 0; a < 3; a++) k |= (uint32_t)(at[a] >= v->origin[a] + v->edge / 2) << a;
    /* Children interpolate from their parent: two rooms in turn. */
    virtual_descend(g, v, k, scratch + (size_t)(level & 1) * 32 * g->stride);
  }
}

void ylm__grid_set_virtual(const ylm_grid *g, uint32_t leaf, const float t[3], float *room,
                           sample_batch *b) {
  const ylm_grid_cell *c = &g->cell[leaf];
  uint32_t edge = ylm__grid_edge(g, c);
  virtual_cell v;
  double at[3];
  for (int a = 0; a < 3; a++) at[a] = c->origin[a] + (double)t[a] * edge;
  ylm__grid_virtual(g, leaf, at, &v, room);
  ylm__grid_set_edge(g, v.edge, b);
  memcpy(b->row, v.row, sizeof b->row);
  for (int a = 0; a < 3; a++) b->t[a][0] = (float)((at[a] - v.origin[a]) / v.edge);
  b->points = 1;
}
