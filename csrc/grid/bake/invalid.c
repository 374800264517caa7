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
  float *to = f->sum + (size_t)f->slot[p] * ylm__grid_record(g);
  for (size_t j = 0; j < g->width; j++) {
    float way = g->rows == 1 ? 0 : dx[0] * row[1][j] + dx[1] * row[2][j] + dx[2] * row[3][j];
    to[j] += w * (row[0][j] + way);
    for (size_t r = 1; r < g->rows; r++) to[r * g->stride + j] += w * row[r][j];
  }
  f->weight[f->slot[p]] += (double)w;
}

/* A cell, or behind all cells a part of a leaf that surfaces cross: its corners, and its level. */
static const uint32_t *corners_of(const ylm_grid *g, size_t i, int *level) {
  size_t part = i - g->cells;
  *level = g->cell[i < g->cells ? i : g->sides.leaf[part]].level;
  return i < g->cells ? g->cell[i].corner : g->sides.node[part];
}

/* Sums over the cells of one level; returns whether anything was added. */
static bool gather(const ylm_grid *g, filling *f, int level) {
  bool any = false;
  for (size_t i = 0; i < f->cell.n; i++) {
    int own;
    const uint32_t *corner = corners_of(g, f->cell.cell[i], &own);
    if (own != level) continue;
    for (int k = 0; k < 8; k++) {
      uint32_t p = corner[k];
      if (p == YLM_GRID_NONE || f->slot[p] == YLM_GRID_NONE) continue;
      for (int m = 0; m < 8; m++) {
        uint32_t q = corner[m];
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
    float scale = (float)(1 / f->weight[slot]), *to = g->data + (size_t)p * ylm__grid_record(g);
    const float *from = f->sum + (size_t)slot * ylm__grid_record(g);
    for (size_t j = 0; j < ylm__grid_record(g); j++) to[j] = scale * from[j];
    f->slot[p] = YLM_GRID_NONE;
  }
}

/* The cells of the octree that have corners in lights. */
static ylm_status list_cells(const ylm_grid *g, filling *f) {
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < g->cells + g->sides.parts && s == YLM_OK; i++) {
    int level;
    const uint32_t *corner = corners_of(g, i, &level);
    bool any = false;
    if (i < g->cells && g->cell[i].flags & (YLM_GRID_ADDED | YLM_GRID_SIDED)) continue;
    for (int k = 0; k < 8; k++)
      any |= corner[k] != YLM_GRID_NONE && f->slot[corner[k]] != YLM_GRID_NONE;
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
               .sum = ylm_alloc_zero(invalid, ylm__grid_record(g) * sizeof *f.sum)};
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
