/* verify.c - held-out shading points against the light field. */
#include "tolerance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Chooses points for this round: all, if there are not more. One that rounding to float moved out
   of occupied voxels is left out. */
static ylm_status hold_out(refiner *r, uint64_t round) {
  const ylm_grid_source *s = r->b->source;
  const ylm_grid *g = r->b->g;
  bool all = backend_has_shading(s) && s->occupied < r->most;
  size_t n = all ? s->occupied : r->most;
  r->all = all;
  ylm_rng rng;
  ylm_rng_seed(&rng, s->seed, round);
  r->held = 0;
  ylm_status status =
      r->surface ? ylm__held_surface(r, round, n) : ylm__held_points(r, &rng, all, n);
  for (size_t i = 0; status == YLM_OK && i < n; i++) {
    const float *x = r->points + 3 * i;
    uint32_t leaf = ylm__held_leaf(g, x);
    if (!(g->cell[leaf].flags & YLM_GRID_OCCUPIED)) continue;
    memmove(r->points + 3 * r->held, x, 3 * sizeof *x);
    if (r->side) memmove(r->side + 4 * r->held, r->side + 4 * i, 4 * sizeof *x);
    r->verdict[r->held++].leaf = leaf;
  }
  return status;
}

ylm_status ylm__verify_compare(refiner *r) {
  baker *b = r->b;
  if (r->side) return ylm__sides_compare(r);
  ylm_grid_probe *probe = ylm_alloc(r->held, sizeof *probe);
  double *distance = ylm_alloc(r->held, sizeof *distance);
  ylm_grid_held held = {r->points, r->exact, r->inside};
  ylm_status s = probe && distance ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < r->held; i++) {
    const ylm_grid_cell *c = &b->g->cell[r->verdict[i].leaf];
    float t[3];
    ylm__held_fractions(b->g, c, r->points + 3 * i, t);
    probe[i] = ylm__held_probe(b->g, c, t, (uint32_t)i);
  }
  if (s == YLM_OK) s = ylm__backend_residuals(b, r->held, probe, &held, distance);
  r->verdicts = 0;
  for (size_t i = 0; i < r->held && s == YLM_OK; i++)
    if (!r->inside[i])
      r->verdict[r->verdicts++] = (verdict){distance[i], r->verdict[i].leaf, r->verdict[i].leaf};
  ylm_free(probe);
  ylm_free(distance);
  return s;
}

static int downwards(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return x > y ? -1 : x < y;
}

bool ylm__verify_satisfied(refiner *r, bool *limited) {
  const ylm_grid *g = r->b->g;
  double estimates[HELD_OUT];
  size_t refinable = 0, stuck = 0, n = r->verdicts;
  for (size_t i = 0; i < n; i++) {
    const ylm_grid_cell *c = &g->cell[r->verdict[i].leaf];
    if (!(r->verdict[i].error > r->tolerance)) continue;
    const ylm_grid_cell *beyond = &g->cell[r->verdict[i].beyond];
    if (beyond->level < c->level) c = beyond;
    if (c->level < g->contents.form.depth)
      estimates[refinable++] = ylm__residual_estimate(r, c);
    else
      stuck++;
  }
  double all = (double)n, can = (double)refinable, cannot = (double)stuck;
  *limited = stuck > 0;
  if (can + cannot <= ENOUGH * all || can <= ENOUGH_REFINABLE * all) return true;
  if (cannot > PROMISED * all && can <= ENOUGH_BESIDE_STUCK * all) return true;
  size_t few = (size_t)(LET_GO * all);
  if (refinable <= few) return false; /* the others are at the finest level */
  qsort(estimates, refinable, sizeof *estimates, downwards);
  double wanted = BEYOND * r->tolerance / estimates[refinable - few - 1];
  if (wanted > STEP * r->tight) wanted = STEP * r->tight;
  if (wanted > r->tight) r->tight = wanted;
  return false;
}

ylm_status ylm__verify(refiner *r, uint64_t round) {
  baker *b = r->b;
  double t = ylm_seconds();
  b->stage = "verifying";
  ylm_status s = hold_out(r, round);
  if (s == YLM_OK) s = ylm__backend_fill_invalid(b);
  if (s == YLM_OK) s = ylm__verify_compare(r);
  b->g->stats.verify_seconds += ylm_seconds() - t;
  return s;
}
