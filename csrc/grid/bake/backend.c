/*
** backend.c - asking the back end of a bake. Without one, and where a device's memory has run out,
** the processor is asked: b->remote is NULL then.
*/
#include "baker.h"

#include <string.h>

/* The facts that a back end is told. */
static const ylm_grid_making *making(baker *b) {
  const ylm_grid *g = b->g;
  b->making.parts =
      (ylm_grid_parts){g->cell, g->lattice, g->stride, g->data, g->lambda, g->norm, g->flags};
  return &b->making;
}

/* Where memory has run out, goes on without the back end: its rows come here. */
static ylm_status leave(baker *b, ylm_status s) {
  const ylm_grid_backend *k = b->remote;
  if ((s != YLM_ENOMEM && s != YLM_ELIMIT) || backend_keeps_cells(b)) return s;
  b->remote = NULL;
  return k->rows(k->self, making(b), YLM_GRID_ROWS_LEAVE, b->g->evaluated, NULL, b->g->data);
}

ylm_status ylm__backend_occupied(baker *b, uint64_t **code, size_t *n) {
  const ylm_grid_backend *k = b->remote;
  if (!k) return YLM_OK;
  double t = ylm_seconds();
  b->stage = "occupancy";
  ylm_status s = k->occupied(k->self, making(b), code, n);
  b->stage = b->stage_text;
  b->g->stats.occupancy_seconds = ylm_seconds() - t;
  b->told = s != YLM_OK;
  return s;
}

ylm_status ylm__backend_shading(baker *b, size_t n, const size_t *index, float *out) {
  const ylm_grid_backend *k = b->source->backend; /* also of a bake that has left it */
  return k->shading(k->self, making(b), n, index, out);
}

ylm_status ylm__backend_evaluate(baker *b, size_t n) {
  ylm_grid *g = b->g;
  ylm_status s = g->follower ? g->follower->reserve(g) : YLM_OK;
  if (s == YLM_OK && b->remote && n)
    s = leave(b, b->remote->evaluate(b->remote->self, making(b), n));
  if (s == YLM_OK && !b->remote) s = b->own.evaluate(b, making(b), n);
  g->evaluated = g->points;
  return s;
}

ylm_status ylm__backend_residuals(baker *b, size_t n, const ylm_grid_probe *probe,
                                  const ylm_grid_held *held, double *distance) {
  const ylm_grid_backend *k = b->remote;
  ylm_status s = YLM_OK;
  if (!n) return s;
  if (k) s = leave(b, k->residuals(k->self, making(b), n, probe, held, distance));
  if (s == YLM_OK && !b->remote) s = b->own.residuals(b, making(b), n, probe, held, distance);
  return s;
}

ylm_status ylm__backend_fetch(baker *b) {
  const ylm_grid_backend *k = b->remote;
  if (!k) return YLM_OK;
  b->stage = "download";
  ylm_status s = k->rows(k->self, making(b), YLM_GRID_ROWS_ALL, b->g->evaluated, NULL, b->g->data);
  b->told |= s != YLM_OK && backend_keeps_cells(b);
  return s;
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
  const ylm_grid_backend *k = b->remote;
  size_t n = 0;
  for (size_t p = 0; p < b->g->evaluated; p++)
    if (mark[p]) point[n++] = (uint32_t)p;
  ylm_status s = k->rows(k->self, making(b), YLM_GRID_ROWS_TAKE, n, point, row);
  if (s == YLM_OK) {
    list_rows(b->g, mark, 3, point, row, true);
    s = ylm__grid_fill_invalid(b->g);
  }
  if (s != YLM_OK) return s;
  n = list_rows(b->g, mark, 2, point, row, false);
  return k->rows(k->self, making(b), YLM_GRID_ROWS_PUT, n, point, row);
}

ylm_status ylm__backend_fill_invalid(baker *b) {
  ylm_grid *g = b->g;
  if (!b->remote) return ylm__grid_fill_invalid(g);
  uint8_t *mark = ylm_alloc_zero(g->evaluated, 1);
  if (!mark) return YLM_ENOMEM;
  size_t n = mark_corners(g, mark);
  uint32_t *point = ylm_alloc(n, sizeof *point);
  float *row = ylm_alloc(n * 4, g->stride * sizeof *row);
  ylm_status s = point && row ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && n) s = leave(b, fill_kept(b, mark, point, row));
  ylm_free(mark);
  ylm_free(point);
  ylm_free(row);
  return s == YLM_OK && !b->remote ? ylm__grid_fill_invalid(g) : s;
}
