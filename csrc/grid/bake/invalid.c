/* invalid.c - values for points inside lights, where the field jumps: from valid neighbours. */
#include "baker.h"

#include <math.h>
#include <string.h>

/* Per point, while filling. */
typedef struct filling {
  double *weight;  /* [invalid] */
  uint32_t *point; /* [invalid] */
  uint32_t *slot;  /* [points] place among the invalid ones, YLM_GRID_NONE: valid or filled */
  float *sum;      /* [invalid][4][stride] */
  cell_list cell;  /* those with corners in lights */
} filling;

/* Adds the first-order expansion about point q to the sums of point p. */
static void add_neighbour(const ylm_grid *g, filling *f, uint32_t p, uint32_t q) {
  double a[3], b[3], d2 = 0;
  ylm_grid_position(g, g->lattice + 3 * (size_t)p, a);
  ylm_grid_position(g, g->lattice + 3 * (size_t)q, b);
  for (int i = 0; i < 3; i++) d2 += (a[i] - b[i]) * (a[i] - b[i]);
  float w = (float)(1 / d2), dx[3];
  for (int i = 0; i < 3; i++) dx[i] = (float)(a[i] - b[i]);
  const float *row[4];
  for (int r = 0; r < 4; r++) row[r] = ylm__grid_row(g, q, r);
  float *to = f->sum + (size_t)f->slot[p] * 4 * g->stride;
  for (size_t j = 0; j < g->width; j++) {
    to[j] += w * (row[0][j] + dx[0] * row[1][j] + dx[1] * row[2][j] + dx[2] * row[3][j]);
    for (size_t r = 1; r < 4; r++) to[r * g->stride + j] += w * row[r][j];
  }
  f->weight[f->slot[p]] += (double)w;
}

/* Sums over the cells of one level; returns whether anything was added. */
static bool gather(const ylm_grid *g, filling *f, int level) {
  bool any = false;
  for (size_t i = 0; i < f->cell.n; i++) {
    const ylm_grid_cell *c = &g->cell[f->cell.cell[i]];
    if (c->level != level) continue;
    for (int k = 0; k < 8; k++) {
      uint32_t p = c->corner[k];
      if (p == YLM_GRID_NONE || f->slot[p] == YLM_GRID_NONE) continue;
      for (int m = 0; m < 8; m++) {
        uint32_t q = c->corner[m];
        if (q == YLM_GRID_NONE || f->slot[q] != YLM_GRID_NONE) continue;
        add_neighbour(g, f, p, q);
        any = true;
      }
    }
  }
  return any;
}

/* Means from the sums. Points that have one then count as valid. */
static void settle(ylm_grid *g, filling *f, uint32_t invalid) {
  for (uint32_t slot = 0; slot < invalid; slot++) {
    uint32_t p = f->point[slot];
    if (f->slot[p] == YLM_GRID_NONE || !(f->weight[slot] > 0)) continue;
    float scale = (float)(1 / f->weight[slot]), *to = g->data + (size_t)p * 4 * g->stride;
    const float *from = f->sum + (size_t)slot * 4 * g->stride;
    for (size_t j = 0; j < 4 * g->stride; j++) to[j] = scale * from[j];
    f->slot[p] = YLM_GRID_NONE;
  }
}

/* The cells of the octree that have corners in lights. */
static ylm_status list_cells(const ylm_grid *g, filling *f) {
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < g->cells && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    bool any = false;
    if (c->flags & YLM_GRID_ADDED) continue;
    for (int k = 0; k < 8; k++)
      any |= c->corner[k] != YLM_GRID_NONE && f->slot[c->corner[k]] != YLM_GRID_NONE;
    if (any) s = ylm__cell_list_push(&f->cell, (uint32_t)i);
  }
  return s;
}

/* Does a point lie in a light, and lack a value? */
static bool lacks_value(const ylm_grid *g, const uint8_t *filled, size_t p) {
  return g->flags[p] & YLM_GRID_POINT_INVALID && !(filled && filled[p]);
}

ylm_status ylm__grid_fill_others(ylm_grid *g, const uint8_t *filled) {
  uint32_t invalid = 0;
  for (size_t p = 0; p < g->evaluated; p++) invalid += lacks_value(g, filled, p);
  if (!invalid) return YLM_OK;
  filling f = {.weight = ylm_alloc_zero(invalid, sizeof *f.weight),
               .point = ylm_alloc(invalid, sizeof *f.point),
               .slot = ylm_alloc(g->evaluated, sizeof *f.slot),
               .sum = ylm_alloc_zero(invalid, 4 * g->stride * sizeof *f.sum)};
  ylm_status s = f.weight && f.point && f.slot && f.sum ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    uint32_t next = 0;
    for (uint32_t p = 0; p < g->evaluated; p++) {
      f.slot[p] = lacks_value(g, filled, p) ? next : YLM_GRID_NONE;
      if (f.slot[p] != YLM_GRID_NONE) f.point[next++] = p;
    }
    s = list_cells(g, &f);
    /* Finest cells first; what is deeper inside follows from what has been filled. */
    int depth = g->contents.form.kind == YLM_GRID_UNIFORM ? 0 : g->contents.form.depth;
    for (int level = depth; level >= 0 && s == YLM_OK; level--)
      while (gather(g, &f, level)) settle(g, &f, invalid);
  }
  for (uint32_t i = 0; s == YLM_OK && g->follower && i < invalid; i++)
    g->follower->filled(g, f.point[i]);
  ylm_free(f.weight);
  ylm_free(f.point);
  ylm_free(f.slot);
  ylm_free(f.sum);
  ylm_free(f.cell.cell);
  return s;
}

ylm_status ylm__grid_fill_invalid(ylm_grid *g) { return ylm__grid_fill_others(g, NULL); }
