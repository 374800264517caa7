/* refresh.c - a grid's points in another light: evaluated anew, all or none. */
#include "../bake/baker.h"
#include "../bake/panel.h"

#include <math.h>
#include <string.h>

/* The arrays of a grid that a refresh writes. */
typedef struct kept {
  float *data, *lambda, *norm, *validity;
  uint8_t *flags;
} kept;

static kept arrays_of(const ylm_grid *g) {
  return (kept){g->data, g->lambda, g->norm, g->validity, g->flags};
}

static void put_arrays(ylm_grid *g, const kept *k) {
  g->data = k->data;
  g->lambda = k->lambda;
  g->norm = k->norm;
  g->validity = k->validity;
  g->flags = k->flags;
}

/* Room for the grid's points, with the flags that they have. */
static ylm_status make_room(const ylm_grid *g, bool validity, kept *k) {
  size_t n = g->point_room ? g->point_room : 1;
  *k = (kept){.data = ylm_regrow(NULL, 0, g->data_bytes),
              .lambda = ylm_alloc(n, sizeof *k->lambda),
              .norm = ylm_alloc(n, sizeof *k->norm),
              .validity = validity ? ylm_alloc(n, sizeof *k->validity) : NULL,
              .flags = ylm_alloc_zero(n, 1)};
  bool ok = k->data && k->lambda && k->norm && k->flags && (k->validity || !validity);
  if (!ok) return YLM_ENOMEM;
  memcpy(k->flags, g->flags, g->points);
  for (size_t i = g->evaluated; i < g->points; i++) {
    k->lambda[i] = g->lambda[i];
    k->norm[i] = g->norm[i];
  }
  return YLM_OK;
}

static void free_room(kept *k, size_t data_bytes) {
  ylm_regrow_free(k->data, data_bytes);
  ylm_free(k->lambda);
  ylm_free(k->norm);
  ylm_free(k->validity);
  ylm_free(k->flags);
}

/* Forgets the flag of points in lights; the field says it anew. */
static ylm_status evaluate(ylm_grid *g, const ylm_grid_source *source, ylm_error *e) {
  baker b;
  ylm__baker_begin(&b, g, source, e);
  snprintf(b.stage_text, sizeof b.stage_text, "evaluating");
  ylm_status s = ylm_report(source->progress, 0, g->evaluated, b.stage);
  for (size_t i = 0; s == YLM_OK && i < g->evaluated; i += YLM_GRID_BLOCK) {
    size_t n = g->evaluated - i < YLM_GRID_BLOCK ? g->evaluated - i : YLM_GRID_BLOCK;
    s = ylm__evaluate_points(&b, n, NULL, i);
    if (s == YLM_OK) s = ylm_report(source->progress, i + n, g->evaluated, b.stage);
  }
  if (s == YLM_OK) s = ylm__grid_fill_invalid(g);
  if (s == YLM_OK) s = ylm__grid_interpolate_points(g, NULL, source->threads, NULL);
  ylm__baker_free(&b);
  return s;
}

/* The metric of the cells; of a bake, whose cells have it, the same. */
static void find_errors(ylm_grid *g) {
  baker b = {.g = g};
  for (size_t i = 0; i < g->contents.octree_cells; i++) {
    ylm_grid_cell *c = &g->cell[i];
    if (c->flags & YLM_GRID_BAKED && c->flags & YLM_GRID_OCCUPIED)
      c->error = ylm__metric_of(&b, c, g->contents.form.metric);
  }
}

/* True if the light at all points is what it was, to the bit. */
static bool is_same(const ylm_grid *g, const kept *old) {
  size_t rows = g->evaluated * ylm__grid_record(g) * sizeof *g->data;
  return memcmp(g->data, old->data, rows) == 0 && memcmp(g->flags, old->flags, g->points) == 0;
}

/* A promise about another light is none. */
static void forget_promise(ylm_grid *g) {
  ylm_grid_stats *s = &g->stats;
  ylm__grid_forget_panel(g);
  g->is_small = false;
  for (size_t i = 0; i < g->cells; i++) g->cell[i].residual = NAN;
  s->met = s->limited = false;
  s->error = s->largest_error = NAN;
  s->verified = s->failed = 0;
  s->confidence = 0;
}

ylm_status ylm_grid_refresh(ylm_grid *g, const ylm_field *field, int threads,
                            const ylm_progress *progress, ylm_error *e) {
  kept old = arrays_of(g), fresh;
  uint64_t pairs = g->stats.pairs;
  double seconds = g->stats.field_seconds;
  ylm_quantity quantity = g->contents.form.quantity;
  ylm_grid_source source = {.field = field, .threads = threads, .progress = progress};
  if (g->contents.form.dynamic)
    return ylm_fail(e, YLM_EINVAL, "a dynamic grid is kept up to date by ylm_grid_update");
  ylm_status s = make_room(g, field->tells_validity, &fresh);
  if (s == YLM_OK) {
    put_arrays(g, &fresh);
    g->updating = true;
    s = evaluate(g, &source, e);
    g->updating = false;
    fresh = arrays_of(g);
  }
  if (s == YLM_OK) {
    bool same = is_same(g, &old);
    if (!same) forget_promise(g);
    if (!same) g->contents.form.prints = (ylm_grid_prints){0};
    if (!same && g->contents.form.metric_channels) find_errors(g);
    g->contents.form.quantity = g->field.quantity = field->quantity;
    ylm__grid_count(g);
    ylm__grid_sync(g);
    free_room(&old, g->data_bytes);
    g->stats.pairs = pairs; /* of the bake */
    g->stats.field_seconds = seconds;
    return YLM_OK;
  }
  put_arrays(g, &old);
  free_room(&fresh, g->data_bytes);
  g->stats.pairs = pairs;
  g->stats.field_seconds = seconds;
  g->contents.form.quantity = quantity;
  return s == YLM_ENOMEM ? ylm_fail(e, s, "no memory to refresh %zu points", g->evaluated) : s;
}
