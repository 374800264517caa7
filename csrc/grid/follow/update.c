/*
** update.c - a dynamic grid after its lights changed.
**
** In this order: find what changed; bring points up to date whose interpolation is off by more than
** the tolerance; refine and merge from the root, where points that exist are not evaluated again;
** drop unused points and make the grid continuous. Until the last step everything can be taken
** back, so that a cancelled update leaves the grid as it was.
*/
#include "update.h"
#include "calibration.h"

#include <math.h>
#include <string.h>

/* Bakes everything anew; the grid changes places with the new one. */
static ylm_status rebake(update *u) {
  ylm_grid *g = u->g, *fresh;
  ylm_grid_form form = g->contents.form;
  ylm_status s = ylm_grid_bake(&form, &u->source, &fresh, u->b.e);
  if (s != YLM_OK) return s;
  ylm_grid_take(g, fresh);
  g->updating = true;
  u->stats.rebaked = true;
  u->stats.points = u->stats.exact = g->stats.points;
  u->stats.pairs = g->stats.pairs;
  u->stats.field_seconds = g->stats.field_seconds;
  return YLM_OK;
}

/* Gives the new lights shapes that stay: those that did not change have one. */
static ylm_status keep_shapes(update *u) {
  ylm_status s = YLM_OK;
  for (size_t j = 0; j < u->now.n && s == YLM_OK; j++)
    if (u->origin[j] >= 0)
      u->now.light[j].shape = u->d->light[u->origin[j]].shape;
    else
      s = ylm_light_keep(&u->d->shapes, &u->now.light[j]);
  return s;
}

/* The new lights are the grid's. */
static void commit(update *u, int32_t *of) {
  grid_dynamic *d = u->d;
  ylm_free(d->light);
  ylm_free(d->mover_of);
  d->light = u->now.light;
  d->mover_of = of;
  d->lights = u->now.n;
  u->now.light = NULL;
  ylm__panel_exchange(&d->panel, &u->panel);
}

/* Judges the finished grid; where memory runs out, what was said of its octree stands. */
static void judge(const update *u) {
  ylm_grid *g = u->g;
  ruling said;
  if (!(g->contents.form.tolerance > 0) || g->spent) return;
  double t = ylm_seconds();
  if (ylm__judge_samples(g, &u->d->panel, u->source.threads, &said) == YLM_OK)
    ylm__panel_report(&g->stats, &u->d->panel, &said, g->stats.limited);
  g->stats.verify_seconds += ylm_seconds() - t;
}

/* Evaluates anew what a difference has left less light than its rounding may be seen beside. */
static ylm_status renew_worn(update *u) {
  ylm_grid *g = u->g;
  uint32_t *list = u->exact + u->exacts; /* has room for all points */
  size_t n = 0;
  for (size_t i = 0; i < u->shifts; i++)
    if (ylm__grid_is_worn(g, u->shift[i], u->tolerance, 4)) list[n++] = u->shift[i];
  u->stats.exact += n;
  return ylm__evaluate_points(&u->b, n, list, 0);
}

static ylm_status follow(update *u) {
  ylm_grid *g = u->g;
  ylm_status s = ylm_light_bounds_meet(&u->d->bounds, u->now.n, u->now.light, u->b.e);
  if (s == YLM_OK) s = ylm__update_remember(u);
  if (s == YLM_OK) s = keep_shapes(u);
  if (s == YLM_OK) s = ylm__update_panel(u);
  if (s != YLM_OK) return s;
  int32_t *of = ylm_alloc(u->now.n, sizeof *of);
  if (!of) return YLM_ENOMEM;
  s = ylm__update_enter_changes(u, of);
  if (s == YLM_OK) s = ylm__update_choose_points(u);
  if (s == YLM_OK) s = ylm__update_log_rows(u);
  if (s == YLM_OK) s = ylm__evaluate_points(&u->b, u->exacts, u->exact, 0);
  if (s == YLM_OK) s = ylm__update_shift_all(u);
  u->stats.exact = u->exacts;
  if (s == YLM_OK) s = renew_worn(u);
  u->stats.points = u->exacts + u->shifts;
  double begin = ylm_seconds(), field = g->stats.field_seconds;
  if (s == YLM_OK)
    s = g->contents.form.kind == YLM_GRID_UNIFORM ? ylm__update_uniform(u) : ylm__update_octree(u);
  u->stats.tree_seconds = ylm_seconds() - begin - (g->stats.field_seconds - field);
  if (s != YLM_OK && !u->over) {
    ylm__update_restore(u);
    ylm_free(of);
    return s;
  }
  commit(u, of);
  ylm__update_retire(u->d, g->evaluated);
  ylm__dynamic_sign_all(g, u->source.threads);
  if (s == YLM_OK) judge(u);
  ylm__grid_sync(g);
  return s;
}

static ylm_status run(update *u) {
  ylm_status s =
      ylm__lights_match(u->d, u->now.n, u->now.light, u->origin, &u->change, &u->changes);
  if (s != YLM_OK) return s;
  u->stats.lights = u->changes;
  if (!u->changes) return YLM_OK;
  s = ylm_report(u->source.progress, 0, 1, "updating");
  if (s != YLM_OK) return s;
  bool many = u->changes > 4 && 2 * u->changes > u->d->lights;
  bool anew = u->changes > MOST_CHANGES || many || !u->now.n || !u->d->lights;
  s = anew ? rebake(u) : follow(u);
  if (s == YLM_OK || u->over) u->g->contents.form.prints = (ylm_grid_prints){0};
  return s;
}

ylm_status ylm_grid_update(ylm_grid *g, const ylm_grid_change *change, ylm_error *e) {
  double begin = ylm_seconds();
  if (!g->dynamic)
    return ylm_fail(e, YLM_EINVAL,
                    "the grid was not made with dynamic = true, it cannot be updated");
  if (g->spent)
    return ylm_fail(e, YLM_EINVAL,
                    "memory ran out in an update that could not be taken back: the "
                    "grid is spent, bake it anew");
  if (isnan(change->tolerance) || isinf(change->tolerance))
    return ylm_fail(e, YLM_EDOMAIN, "tolerance: a number, got %g", change->tolerance);
  ylm_grid_stats before = g->stats;
  update u = {.g = g,
              .d = g->dynamic,
              .source = g->dynamic->source,
              .tolerance = change->tolerance,
              .whole = change->everywhere};
  if (u.tolerance < 0)
    u.tolerance =
        g->contents.form.tolerance > 0 ? g->contents.form.tolerance / 8 : DEFAULT_TOLERANCE;
  u.source.lights = change->lights;
  u.source.field = change->field;
  u.source.threads = change->threads;
  u.source.progress = change->progress;
  ylm__baker_begin(&u.b, g, &u.source, e);
  u.b.learnt.occupied = u.d->occupied;
  u.b.surface = u.d->surface;
  u.b.stage = "updating";
  u.stats = (ylm_grid_update_stats){.updates = before.update.updates + 1};
  ylm_status s = ylm_light_set_list(change->lights, &u.now);
  u.origin = ylm_alloc(u.now.n, sizeof *u.origin);
  g->updating = true;
  g->stats.update = u.stats; /* its number is used by refinement */
  if (u.d->forced.used > MOST_FORCED) ylm__lattice_hash_free(&u.d->forced);
  g->stats.pairs = 0;
  g->stats.field_seconds = 0;
  if (!u.origin) s = YLM_ENOMEM;
  if (s == YLM_OK) s = run(&u);
  if (!u.stats.rebaked) {
    u.stats.pairs = g->stats.pairs;
    u.stats.field_seconds = g->stats.field_seconds;
    g->stats.pairs = before.pairs;
    g->stats.field_seconds = before.field_seconds;
    g->stats.verify_seconds = before.verify_seconds;
  }
  g->updating = false;
  ylm__update_forget(&u);
  ylm__dynamic_sweep(g->dynamic);
  u.stats.seconds = ylm_seconds() - begin;
  if (s == YLM_OK)
    g->stats.update = u.stats;
  else
    g->stats = before;
  if (s == YLM_EDOMAIN && e && e->status != s)
    return ylm_fail(e, s, "the light field of these lights is beyond the range of float");
  if (g->spent)
    return ylm_fail(e, s,
                    "the grid does not fit into memory, and the update could not be taken "
                    "back: the grid is spent, bake it anew");
  return s == YLM_OK ? s : ylm__grid_no_room(s, &u.source, e);
}

bool ylm_grid_updating(const ylm_grid *g) { return g->updating; }

bool ylm_grid_spent(const ylm_grid *g) { return g->spent; }
