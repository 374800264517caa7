/* judge.c - a grid that was updated, judged by its panel: in the octree's leaves while it is
   refined, by its samples once it is finished. */
#include <string.h>

#include "update.h"

typedef struct leaf_job {
  const refiner *r;
  const panel *p;
  const uint8_t *changed; /* [old] by point that was there */
  size_t old;
  double *error;
  uint8_t *stuck;
} leaf_job;

/* True if samples in a leaf of the octree are what they were before the update. */
static bool is_unchanged(const leaf_job *j, const ylm_grid_cell *c) {
  const ylm_grid_cell *before = cells_before(j->r->b, c);
  if (!j->p->known || !before || !(before->flags & YLM_GRID_LEAF)) return false;
  for (int k = 0; k < 8; k++) {
    uint32_t p = c->corner[k];
    if (p >= j->old || j->changed[p] || j->r->b->g->flags[p] & YLM_GRID_POINT_INVALID) return false;
  }
  return true;
}

/* The interpolant of a leaf at x, as sampling computes it. */
static void interpolate(const ylm_grid *g, const ylm_grid_cell *c, const float x[3], float *row) {
  sample_batch b = {.points = 1, .width = (int)g->width, .value = {row}};
  float t[3];
  ylm__held_fractions(g, c, x, t);
  for (int a = 0; a < 3; a++) b.t[a][0] = t[a];
  ylm__grid_set_cell(g, c, &b);
  ylm__grid_kernel()(&b);
}

/* Errors of points begin .. end-1, interpolated in the octree's leaves. */
static ylm_status compare_range(void *context, size_t begin, size_t end, int worker) {
  const leaf_job *j = context;
  const ylm_grid *g = j->r->b->g;
  float *row = j->r->b->row + (size_t)worker * (g->stride + ROW_PADDING);
  for (size_t i = begin; i < end; i++) {
    const float *x = j->p->point + 3 * i;
    j->error[i] = -1;
    j->stuck[i] = 0;
    if (j->p->inside[i]) continue;
    const ylm_grid_cell *c = &g->cell[ylm__held_leaf(g, x)];
    if (!(c->flags & YLM_GRID_OCCUPIED)) continue;
    bool same = is_unchanged(j, c);
    if (!same) interpolate(g, c, x, row);
    j->error[i] = ylm__panel_error(j->p, i, same ? j->p->sampled + i * g->width : row, g->width,
                                   g->contents.form.floor);
    j->stuck[i] = j->error[i] > j->r->tolerance && c->level >= g->contents.form.depth;
  }
  return YLM_OK;
}

ylm_status ylm__judge_leaves(const refiner *r, const panel *p, const uint8_t *changed, size_t old,
                             ruling *out) {
  leaf_job j = {r, p, changed, old, ylm_alloc(p->n, sizeof *j.error), ylm_alloc(p->n, 1)};
  ylm_status s = j.error && j.stuck ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm_parallel(p->n, BAKE_GRAIN, r->b->source->threads, compare_range, &j, NULL, NULL);
  if (s == YLM_OK) s = ylm__panel_rule(p, j.error, r->tolerance, DOUBT, out);
  for (size_t i = 0; s == YLM_OK && i < p->n; i++) out->stuck += j.stuck[i];
  ylm_free(j.error);
  ylm_free(j.stuck);
  return s;
}

typedef struct panel_taker {
  panel *p;
  size_t width;
} panel_taker;

/* Keeps the samples of n points. */
static void take_samples(void *user, size_t n, const uint32_t *point, size_t row,
                         const float *value) {
  const panel_taker *t = user;
  for (size_t i = 0; i < n; i++)
    memcpy(t->p->sampled + point[i] * t->width, value + i * row, t->width * sizeof *value);
}

ylm_status ylm__judge_samples(const ylm_grid *g, panel *p, int threads, ruling *out) {
  panel_taker to = {p, g->width};
  uint64_t fresh;
  ylm_status s = YLM_OK;
  if (!p->sampled) p->sampled = ylm_alloc(p->n, g->width * sizeof *p->sampled);
  if (!p->sampled) return YLM_ENOMEM;
  if (!p->track) s = ylm_grid_track_create(p->n, p->point, g->origin, NULL, &p->track);
  if (s == YLM_OK)
    s = ylm_grid_track_sample(p->track, g, YLM_GRID_HERMITE, threads, NULL,
                              &(ylm_grid_taker){NULL, take_samples, &to}, &fresh, NULL);
  p->known = s == YLM_OK;
  return s == YLM_OK ? ylm__panel_rule_samples(g, p, p->sampled, DOUBT, out) : s;
}
