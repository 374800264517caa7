/* remote.c - bakes whose points are evaluated and kept elsewhere: ylm_grid_keeper. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "baker.h"

ylm_grid_probe baker_probe(const baker *b, const ylm_grid_cell *c, const float t[3],
                           uint32_t point) {
  ylm_grid_probe p = {.edge = ylm__grid_edge(b->g, c), .point = point, .t = {t[0], t[1], t[2]}};
  memcpy(p.corner, c->corner, sizeof p.corner);
  return p;
}

/* Where memory has run out, goes on without the keeper: its rows come here. */
static ylm_status or_leave(baker *b, ylm_status s) {
  const ylm_grid_keeper *k = b->keeper;
  if (s != YLM_ENOMEM && s != YLM_ELIMIT) return s;
  b->keeper = NULL;
  return k->rows(k->self, b->g->evaluated, b->g->data, true, b->e);
}

ylm_status keeper_begin(baker *b) {
  const ylm_grid_keeper *k = b->source->keeper;
  if (!k || b->g->view.form.dynamic) return YLM_OK;
  ylm_status s = k->begin(k->self, b->g, b->e);
  if (s == YLM_OK) b->keeper = k;
  return s == YLM_ENOMEM || s == YLM_ELIMIT ? YLM_OK : s;
}

ylm_status keeper_occupancy(baker *b, bool *found) {
  const ylm_grid_keeper *k = b->source->keeper;
  const char *stage = b->stage;
  uint64_t *code = NULL;
  size_t n;
  *found = false;
  if (!k || b->g->view.form.dynamic || !baker_has_shading(b->source)) return YLM_OK;
  ylm_progress progress = baker_progress(b);
  b->stage = "occupancy";
  ylm_status s = k->codes(k->self, b->g, &code, &n, &b->g->stats.outside,
                          b->source->progress ? &progress : NULL, b->e);
  b->stage = stage;
  if ((s == YLM_ENOMEM || s == YLM_ELIMIT) && b->source->occupied_points) return YLM_OK;
  *found = true;
  b->told = s != YLM_OK;
  return s == YLM_OK ? occupancy_take(&b->learnt.occupied, b->g, code, n) : s;
}

/* The metric ends at the largest number, as a light field's does here. */
static float saturated(float x) { return isinf(x) ? FLT_MAX : x; }

ylm_status keeper_evaluate(baker *b) {
  ylm_grid *g = b->g;
  size_t first = g->evaluated, n = g->points - first;
  ylm_progress progress = baker_progress(b);
  if (!n) return YLM_OK;
  uint8_t *inside = ylm_alloc_zero(n, 1);
  if (!inside) return YLM_ENOMEM;
  double t = ylm_seconds();
  ylm_status s = b->keeper->evaluate(b->keeper->self, first, n, g->lattice + 3 * first,
                                     g->lambda + first, g->norm + first, inside, &g->stats.pairs,
                                     b->source->progress ? &progress : NULL, b->e);
  g->stats.field_seconds += ylm_seconds() - t;
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    if (inside[i]) g->flags[first + i] |= YLM_GRID_POINT_INVALID;
    g->lambda[first + i] = saturated(g->lambda[first + i]);
    g->norm[first + i] = saturated(g->norm[first + i]);
  }
  ylm_free(inside);
  return or_leave(b, s);
}

ylm_status keeper_residuals(baker *b, size_t n, const ylm_grid_probe *probe, float *distance) {
  return or_leave(b, b->keeper->residuals(b->keeper->self, n, probe, distance, b->e));
}

ylm_status keeper_compare(baker *b, size_t n, const float *places, const ylm_grid_probe *probe,
                          float *distance, uint8_t *inside) {
  ylm_progress progress = baker_progress(b);
  double t = ylm_seconds();
  ylm_status s =
      b->keeper->compare(b->keeper->self, n, places, probe, distance, inside, &b->g->stats.pairs,
                         b->source->progress ? &progress : NULL, b->e);
  b->g->stats.field_seconds += ylm_seconds() - t;
  return or_leave(b, s);
}

ylm_status baker_fetch(baker *b) {
  const ylm_grid_keeper *k = b->keeper;
  return k ? k->rows(k->self, b->g->evaluated, b->g->data, false, b->e) : YLM_OK;
}

/* -- points in lights ---------------------------------------------------------------------- */

static bool invalid(const ylm_grid *g, uint32_t p) {
  return p < g->evaluated && g->flags[p] & YLM_GRID_POINT_INVALID;
}

/* Marks the corners of cells that have some in lights: 1, those themselves 2. How many. */
static size_t mark_corners(const ylm_grid *g, uint8_t *mark) {
  size_t n = 0;
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    bool any = false;
    for (int k = 0; k < 8; k++) any |= invalid(g, c->corner[k]);
    for (int k = 0; any && k < 8; k++) {
      uint32_t p = c->corner[k];
      if (p >= g->evaluated || mark[p]) continue;
      mark[p] = invalid(g, p) ? 2 : 1;
      n++;
    }
  }
  return n;
}

/* Copies rows of the marked points to or from a list: those with marks of `which`. */
static size_t list_rows(ylm_grid *g, const uint8_t *mark, uint8_t which, uint32_t *point,
                        float *row, bool back) {
  size_t n = 0, width = 4 * g->stride;
  for (size_t p = 0; p < g->evaluated; p++) {
    if (!(mark[p] & which)) continue;
    float *here = g->data + p * width, *there = row + n * width;
    memcpy(back ? here : there, back ? there : here, width * sizeof *row);
    point[n++] = (uint32_t)p;
  }
  return n;
}

static ylm_status fill_kept(baker *b, const uint8_t *mark, uint32_t *point, float *row) {
  const ylm_grid_keeper *k = b->keeper;
  size_t n = 0;
  for (size_t p = 0; p < b->g->evaluated; p++)
    if (mark[p]) point[n++] = (uint32_t)p;
  ylm_status s = k->take(k->self, n, point, row, b->e);
  if (s == YLM_OK) {
    list_rows(b->g, mark, 3, point, row, true);
    s = ylm__grid_fill_invalid(b->g);
  }
  if (s != YLM_OK) return s;
  n = list_rows(b->g, mark, 2, point, row, false);
  return k->put(k->self, n, point, row, b->e);
}

ylm_status baker_fill_invalid(baker *b) {
  ylm_grid *g = b->g;
  if (!b->keeper) return ylm__grid_fill_invalid(g);
  uint8_t *mark = ylm_alloc_zero(g->evaluated, 1);
  if (!mark) return YLM_ENOMEM;
  size_t n = mark_corners(g, mark);
  uint32_t *point = ylm_alloc(n, sizeof *point);
  float *row = ylm_alloc(n * 4, g->stride * sizeof *row);
  ylm_status s = point && row ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && n) s = or_leave(b, fill_kept(b, mark, point, row));
  ylm_free(mark);
  ylm_free(point);
  ylm_free(row);
  return s == YLM_OK && !b->keeper ? ylm__grid_fill_invalid(g) : s;
}
