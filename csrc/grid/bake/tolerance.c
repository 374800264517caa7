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

#define FIRST_TIGHT 0.35

/* -- refinement -------------------------------------------------------------------------- */

/* Tests and splits what the wave holds, then its children, until nothing is left. */
ylm_status refiner_refine(refiner *r) {
  baker *b = r->b;
  ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  while (b->wave.n && s == YLM_OK) {
    snprintf(b->stage_text, sizeof b->stage_text, "level %d", g->cell[b->wave.cell[0]].level);
    b->stage = b->stage_text;
    s = baker_corners(b);
    for (size_t i = 0; i < b->wave.n && s == YLM_OK; i++)
      if (refiner_wants_test(r, &g->cell[b->wave.cell[i]]))
        s = cell_list_push(&r->tested, b->wave.cell[i]);
    if (s == YLM_OK) s = refiner_measure(r);
    for (size_t i = 0; i < b->wave.n && s == YLM_OK; i++) {
      const ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
      if (c->level >= g->view.form.depth) continue;
      if (c->flags & YLM_GRID_CROSSED || refiner_estimate(r, c) * r->tight > r->tolerance ||
          (r->frozen && r->forced(g, c)))
        s = baker_split(b, b->wave.cell[i]);
    }
    baker_advance(b);
  }
  return s;
}

ylm_status refiner_again(refiner *r) {
  baker *b = r->b;
  ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  size_t cells = g->cells;
  for (size_t i = 0; i < cells && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (c->flags & YLM_GRID_LEAF && c->flags & YLM_GRID_OCCUPIED && refiner_wants_test(r, c))
      s = cell_list_push(&r->tested, (uint32_t)i);
  }
  if (s == YLM_OK) s = refiner_measure(r);
  for (size_t i = 0; i < r->verdicts && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[r->verdict[i].leaf];
    if (r->verdict[i].error > r->tolerance && c->flags & YLM_GRID_LEAF &&
        c->level < g->view.form.depth) {
      if (g->follower) s = g->follower->failed(g, c);
      if (s == YLM_OK) s = baker_split(b, r->verdict[i].leaf);
    }
  }
  for (size_t i = 0; i < cells && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (c->flags & YLM_GRID_LEAF && c->flags & YLM_GRID_OCCUPIED && c->level < g->view.form.depth &&
        refiner_estimate(r, c) * r->tight > r->tolerance)
      s = baker_split(b, (uint32_t)i);
  }
  baker_advance(b);
  return s == YLM_OK ? refiner_refine(r) : s;
}

/* -- the bake ---------------------------------------------------------------------------------- */

/* The surface that held-out points are drawn on, if there is one. */
static ylm_status find_surface(refiner *r) {
  const ylm_grid *g = r->b->g;
  const ylm_grid_source *s = r->b->source;
  ylm_status status = YLM_OK;
  r->surface = r->b->surface;
  if (!s->meshes || r->surface) return YLM_OK;
  status = ylm_grid_surface_create(s->meshes, s->mesh, g->view.form.bounds, s->threads, &r->own,
                                   r->b->e);
  r->b->told = status != YLM_OK;
  r->surface = r->own;
  return status;
}

ylm_status refiner_begin(refiner *r) {
  size_t w = r->b->g->width;
  r->row = ylm_alloc((size_t)ylm_threads(r->b->source->threads) * (r->b->g->stride + ROW_PADDING),
                     sizeof *r->row);
  r->points = ylm_alloc(HELD_OUT, 3 * sizeof *r->points);
  r->exact = ylm_alloc(HELD_OUT, w * sizeof *r->exact);
  r->inside = ylm_alloc(HELD_OUT, 1);
  r->verdict = ylm_alloc(HELD_OUT, sizeof *r->verdict);
  refiner_learn(r);
  bool ok = r->row && r->points && r->exact && r->inside && r->verdict;
  return ok ? find_surface(r) : YLM_ENOMEM;
}

static ylm_status run(refiner *r) {
  bool limited = false;
  ylm_status s = refiner_refine(r);
  for (uint64_t round = 1; s == YLM_OK; round++) {
    r->b->g->stats.rounds = round;
    s = refiner_verify(r, round);
    if (s != YLM_OK || refiner_satisfied(r, &limited) || round == MAX_ROUNDS) break;
    s = refiner_again(r);
  }
  if (s == YLM_OK) s = baker_finish(r->b);
  return s == YLM_OK ? refiner_judge(r, limited) : s;
}

void refiner_end(refiner *r) {
  ylm_free(r->row);
  ylm_free(r->points);
  ylm_free(r->exact);
  ylm_free(r->inside);
  ylm_free(r->verdict);
  ylm_free(r->tested.cell);
  ylm_free(r->centre.cell);
  ylm_grid_surface_free(r->own);
}

ylm_status ylm__grid_bake_tolerance(baker *b) {
  refiner r = {.b = b, .tolerance = b->g->view.form.tolerance, .tight = FIRST_TIGHT};
  ylm_status s = refiner_begin(&r);
  if (s == YLM_OK) s = run(&r);
  refiner_end(&r);
  b->learnt.ratio = r.ratio;
  b->learnt.tight = r.tight;
  return s;
}
