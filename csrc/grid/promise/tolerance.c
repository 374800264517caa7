/*
** tolerance.c - refinement until 99 % of the shading points are as accurate as promised.
**
** The Hessian's relative metric E is O(h^2), the interpolation error e of Hermite O(h^4): for one
** lamp e is close to E^2 times a constant, with background light the constant varies. So:
**   - kappa, a high quantile of e / E^2 where both are known, says where e may exceed the
**     tolerance; elsewhere nothing is measured;
**   - there e is measured at the voxel's centre, a corner of all its children, which is evaluated
**     anyway if the voxel is split;
**   - a voxel is split where its estimate times `tight` exceeds the tolerance;
**   - held-out shading points are compared with the field. Voxels in which they fail are split, and
**     `tight` grows until the estimates of (almost) all these would have said so. Then fresh
**     points.
** Whether the promise is kept is judged by points that decided nothing: panel.c.
*/
#include "tolerance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- refinement -------------------------------------------------------------------------- */

/* Measures what may have to be split of the wave, and splits it. */
static ylm_status choose(void *chooser) {
  refiner *r = chooser;
  baker *b = r->b;
  const ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < b->wave.n && s == YLM_OK; i++)
    if (ylm__residual_wanted(r, &g->cell[b->wave.cell[i]]))
      s = ylm__cell_list_push(&r->tested, b->wave.cell[i]);
  if (s == YLM_OK) s = ylm__residual_measure(r);
  for (size_t i = 0; i < b->wave.n && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
    if (c->level >= g->contents.form.depth) continue;
    if (c->flags & YLM_GRID_CROSSED || ylm__residual_estimate(r, c) * r->tight > r->tolerance ||
        (r->frozen && r->forced(g, c)))
      s = ylm__cells_split(b, b->wave.cell[i]);
  }
  return s;
}

ylm_status ylm__tolerance_refine(refiner *r) {
  r->b->stage = r->b->stage_text;
  return ylm__refine(r->b, r->b->wave.n);
}

/* Splits a voxel in which a held-out point failed. */
static ylm_status split_failed(refiner *r, uint32_t leaf) {
  const ylm_grid *g = r->b->g;
  const ylm_grid_cell *c = &g->cell[leaf];
  ylm_status s = YLM_OK;
  if (!(c->flags & YLM_GRID_LEAF) || c->level >= g->contents.form.depth) return s;
  if (g->follower) s = g->follower->failed(r->b->g, c);
  return s == YLM_OK ? ylm__cells_split(r->b, leaf) : s;
}

ylm_status ylm__tolerance_again(refiner *r) {
  baker *b = r->b;
  ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  size_t cells = g->cells;
  for (size_t i = 0; i < cells && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (c->flags & YLM_GRID_LEAF && c->flags & YLM_GRID_OCCUPIED && ylm__residual_wanted(r, c))
      s = ylm__cell_list_push(&r->tested, (uint32_t)i);
  }
  if (s == YLM_OK) s = ylm__residual_measure(r);
  for (size_t i = 0; i < r->verdicts && s == YLM_OK; i++) {
    const verdict *v = &r->verdict[i];
    if (!(v->error > r->tolerance)) continue;
    s = split_failed(r, v->leaf);
  }
  for (size_t i = 0; i < cells && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (c->flags & YLM_GRID_LEAF && c->flags & YLM_GRID_OCCUPIED &&
        c->level < g->contents.form.depth && ylm__residual_estimate(r, c) * r->tight > r->tolerance)
      s = ylm__cells_split(b, (uint32_t)i);
  }
  ylm__cells_advance(b);
  return s == YLM_OK ? ylm__tolerance_refine(r) : s;
}

/* -- what refinement needs --------------------------------------------------------------------- */

/* The surface that held-out points are drawn on, if there is one. */
static ylm_status find_surface(refiner *r) {
  const ylm_grid *g = r->b->g;
  const ylm_grid_source *s = r->b->source;
  ylm_status status = YLM_OK;
  r->surface = r->b->surface;
  if (!s->meshes || r->surface) return YLM_OK;
  double box[6];
  memcpy(box, g->contents.form.bounds, sizeof box);
  for (int a = 0; s->within && a < 3; a++) {
    box[a] = fmax(box[a], s->within[a]);
    box[a + 3] = fmin(box[a + 3], s->within[a + 3]);
    if (!(box[a] < box[a + 3]))
      return ylm_fail(r->b->e, YLM_EDOMAIN, "within: the box lies outside of the grid's bounds");
  }
  status = ylm_grid_surface_create(s->meshes, s->mesh, box, s->threads, &r->own, r->b->e);
  r->b->told = status != YLM_OK;
  r->surface = r->own;
  return status;
}

ylm_status ylm__tolerance_begin(refiner *r) {
  baker *b = r->b;
  size_t row = b->g->stride + ROW_PADDING;
  b->choose = choose;
  b->chooser = r;
  if (!r->most) r->most = HELD_OUT;
  b->row = ylm_alloc((size_t)ylm_threads(b->source->threads) * row, sizeof *b->row);
  r->points = ylm_alloc(HELD_OUT, 3 * sizeof *r->points);
  r->exact = ylm_alloc(HELD_OUT, b->g->width * sizeof *r->exact);
  r->inside = ylm_alloc(HELD_OUT, 1);
  r->verdict = ylm_alloc(HELD_OUT, sizeof *r->verdict);
  bool sides = ylm__sides_wanted(b);
  if (sides) r->side = ylm_alloc(HELD_OUT, 3 * sizeof *r->side);
  ylm__residual_learn(r);
  bool ok = b->row && r->points && r->exact && r->inside && r->verdict && (r->side || !sides);
  ylm_status s = ok ? find_surface(r) : YLM_ENOMEM;
  return s == YLM_OK && r->side ? ylm__sides_scale(r) : s;
}

void ylm__tolerance_end(refiner *r) {
  r->b->choose = NULL;
  ylm_free(r->points);
  ylm_free(r->exact);
  ylm_free(r->inside);
  ylm_free(r->side);
  ylm_free(r->verdict);
  ylm_free(r->tested.cell);
  ylm_free(r->centre.cell);
  ylm_grid_surface_free(r->own);
}
