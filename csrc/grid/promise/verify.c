/* verify.c - held-out shading points against the light field. */
#include "tolerance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ylm_vector.h"

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
    if (r->side) memmove(r->side + 3 * r->held, r->side + 3 * i, 3 * sizeof *x);
    r->verdict[r->held++].leaf = leaf;
  }
  return status;
}

/* Does a place see nothing but the sky? Rays over the hemisphere of normal n. */
static bool sees_nothing(const ylm_grid_walls *w, const float x[3], const float n[3], double far) {
  float from[SKYWARD][3], to[SKYWARD][3], share[SKYWARD];
  for (int i = 0; i < SKYWARD; i++) {
    double d[3], up = 0;
    ylm_spiral(i, SKYWARD, d);
    for (int a = 0; a < 3; a++) up += d[a] * (double)n[a];
    for (int a = 0; a < 3; a++) {
      from[i][a] = x[a];
      to[i][a] = x[a] + (float)(far * (up < 0 ? -d[a] : d[a]));
    }
  }
  w->share(w->self, SKYWARD, (const float(*)[3])from, (const float(*)[3])to, share);
  for (int i = 0; i < SKYWARD; i++)
    if (share[i] < 1) return false;
  return true;
}

static double longest_edge(const double box[6]) {
  return fmax(box[3] - box[0], fmax(box[4] - box[1], box[5] - box[2]));
}

/*
** Leaves out places that no promise is about: on sides of surfaces that are not used, and where other surfaces cover them,
** since nobody sees these; of indirect light also those that see no surface, where it is 0.
*/
static void leave_out(const refiner *r) {
  const ylm_grid *g = r->b->g;
  const ylm_grid_walls *w = r->b->source->walls;
  double all = longest_edge(g->contents.form.bounds), longest = all;
  if (r->b->source->within) longest = fmin(all, longest_edge(r->b->source->within));
  bool indirect = g->contents.form.quantity == YLM_QUANTITY_indirect;
  for (size_t i = 0; i < r->held; i++) {
    float from[1][3], to[1][3], share;
    const float *n = r->side + 3 * i;
    for (size_t a = 0; a < 3; a++) {
      double way = g->origin[a] - w->origin[a];
      double x = (double)r->points[3 * i + a] + way;
      from[0][a] = (float)(x + COVERED_OFF * longest * (double)n[a]);
      to[0][a] = (float)(x + COVERED * longest * (double)n[a]);
    }
    w->share(w->self, 1, (const float(*)[3])from, (const float(*)[3])to, &share);
    r->inside[i] |=
        share < 1 || place_buried(g, w, to[0]) || (indirect && sees_nothing(w, to[0], n, 4 * all));
  }
}

/* Moves the held points that are not left out to the lists' ends; how many fit. */
static size_t keep(const refiner *r, size_t n, float *point, float *side) {
  for (size_t i = 0; i < r->held && n < HELD_OUT; i++) {
    if (r->inside[i]) continue;
    memcpy(point + 3 * n, r->points + 3 * i, 3 * sizeof *point);
    memcpy(side + 3 * n, r->side + 3 * i, 3 * sizeof *side);
    n++;
  }
  return n;
}

/* Draws places until HELD_OUT are not left out, or HELD_TRIES times. */
static ylm_status hold_open(refiner *r, uint64_t round) {
  float *point = ylm_alloc(2 * HELD_OUT, 3 * sizeof *point), *side = point + 3 * (size_t)HELD_OUT;
  ylm_status s = point ? YLM_OK : YLM_ENOMEM;
  size_t n = 0;
  for (uint64_t k = 0; s == YLM_OK && k < HELD_TRIES && n < HELD_OUT; k++) {
    s = hold_out(r, round * HELD_TRIES + k);
    if (s != YLM_OK) break;
    memset(r->inside, 0, r->held);
    leave_out(r);
    n = keep(r, n, point, side);
    if (r->all) break;
  }
  if (s == YLM_OK) {
    memcpy(r->points, point, 3 * n * sizeof *point);
    memcpy(r->side, side, 3 * n * sizeof *side);
    r->held = n;
  }
  ylm_free(point);
  return s;
}

ylm_status ylm__verify_draw(refiner *r, uint64_t round) {
  ylm_status s = r->side ? hold_open(r, round) : hold_out(r, round);
  return s == YLM_OK ? ylm__sides_ask(r) : s;
}

/* Holds a point if its leaf is wanted and has none of its side; *had [cells] says of which sides there are. */
static void hold_wanted(refiner *r, uint64_t k, const uint8_t *wanted, uint8_t *had) {
  float x[3];
  ylm__held_surface_point(r, r->b->source->seed, k, IN_LEAVES, x);
  uint32_t leaf = ylm__held_leaf(r->b->g, x);
  uint8_t side = k & 1 ? 2 : 1;
  if (leaf == YLM_GRID_NONE || !wanted[leaf] || had[leaf] & side) return;
  had[leaf] |= side;
  memcpy(r->points + 3 * r->held, x, sizeof x);
  ylm__held_surface_side(r->surface, r->b->source->seed, k, IN_LEAVES, r->side + 3 * r->held++);
}

ylm_status ylm__verify_draw_in(refiner *r, uint64_t round, const uint8_t *wanted) {
  uint8_t *had = ylm_alloc_zero(r->b->g->cells, 1);
  if (!had) return YLM_ENOMEM;
  r->held = 0;
  for (uint64_t i = 0; i < IN_LEAVES && r->held < HELD_OUT; i++)
    hold_wanted(r, round * IN_LEAVES + i, wanted, had);
  ylm_free(had);
  memset(r->inside, 0, r->held);
  leave_out(r);
  size_t n = 0;
  for (size_t i = 0; i < r->held; i++) {
    if (r->inside[i]) continue;
    memmove(r->points + 3 * n, r->points + 3 * i, 3 * sizeof *r->points);
    memmove(r->side + 3 * n++, r->side + 3 * i, 3 * sizeof *r->side);
  }
  r->held = n;
  return n ? ylm__sides_ask(r) : YLM_OK;
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
    if (!r->inside[i]) r->verdict[r->verdicts++] = (verdict){distance[i], r->verdict[i].leaf};
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
  if (b->g->contents.form.sides) {
    ylm_status s = ylm__verify_draw(r, round);
    b->g->stats.verify_seconds += ylm_seconds() - t;
    return s;
  }
  ylm_status s = hold_out(r, round);
  if (s == YLM_OK) s = ylm__backend_fill_invalid(b);
  if (s == YLM_OK) s = ylm__verify_compare(r);
  b->g->stats.verify_seconds += ylm_seconds() - t;
  return s;
}
