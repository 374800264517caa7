/* bake.c - asking a light field for the points of a grid, level by level. */
#include "dynamic.h"

#include <math.h>
#include <string.h>

#define BLOCK 8192 /* points of one call of the field; its results are read while in cache */

ylm_status cell_list_push(cell_list *l, uint32_t cell) {
  if (l->n == l->room) {
    size_t room = l->room ? l->room * 2 : 64;
    uint32_t *more = ylm_realloc(l->cell, l->n * sizeof *more, room, sizeof *more);
    if (!more) return YLM_ENOMEM;
    l->cell = more;
    l->room = room;
  }
  l->cell[l->n++] = cell;
  return YLM_OK;
}

/* -- evaluating points ----------------------------------------------------------------- */

/* Room for marks of as many points as the grid has room for. */
static ylm_status reserve_used(baker *b) {
  size_t room = b->g->point_room;
  if (!b->used || b->used_room >= room) return YLM_OK;
  uint8_t *more = ylm_realloc(b->used, b->used_room, room, 1);
  if (!more) return YLM_ENOMEM;
  memset(more + b->used_room, 0, room - b->used_room);
  b->used = more;
  b->used_room = room;
  return YLM_OK;
}

ylm_status baker_point(baker *b, const uint32_t at[3], uint8_t flags, uint32_t *index) {
  ylm_grid *g = b->g;
  ylm_status s = lattice_hash_reserve(&b->g->hash, b->g->hash.used + 1);
  if (s == YLM_OK) s = ylm__grid_reserve_points(g, 1);
  if (s == YLM_OK) s = reserve_used(b);
  if (s != YLM_OK) return s;
  uint32_t *entry = lattice_hash_at(&b->g->hash, lattice_key(at));
  if (*entry == YLM_GRID_NONE) {
    if (b->source->max_points && g->points >= b->source->max_points) return YLM_ELIMIT;
    *entry = (uint32_t)g->points++;
    memcpy(g->lattice + 3 * (size_t)*entry, at, 3 * sizeof *at);
    g->flags[*entry] = flags;
  }
  if (!flags) g->flags[*entry] &= (uint8_t)~YLM_GRID_POINT_TESTED;
  if (b->used) b->used[*entry] = 1;
  *index = *entry;
  return YLM_OK;
}

/* Reports the field's progress under the bake's own stage. */
static bool forward(void *user, uint64_t done, uint64_t total, const char *stage) {
  const baker *b = user;
  (void)stage;
  return ylm_report(b->source->progress, done, total, b->stage) == YLM_OK;
}

/* Asks a field, and keeps the time. */
static ylm_status ask(baker *b, const ylm_field *field, int want, int channels, size_t n,
                      const float *points, ylm_field_result *r) {
  const ylm_grid_form *f = &b->g->view.form;
  ylm_progress progress = {forward, b};
  ylm_field_query q = {.lmax = f->lmax,
                       .channels = channels,
                       .want = want,
                       .metric_channels = f->metric_channels == 3 ? 3 : 1,
                       .dtype = YLM_FLOAT,
                       .threads = b->source->threads,
                       .progress = b->source->progress ? &progress : NULL};
  uint64_t before = r->pairs;
  double t = ylm_seconds();
  ylm_status s = field->evaluate(field, &q, n, points, r, b->e);
  b->g->stats.field_seconds += ylm_seconds() - t;
  b->g->stats.pairs += r->pairs - before;
  return s;
}

ylm_status baker_values(baker *b, size_t n, const float *points, float *value, uint8_t *inside) {
  ylm_field_result r = {.value = value, .inside = inside};
  memset(inside, 0, n);
  return ask(b, b->source->field, YLM_WANT_VALUE, b->g->view.form.channels, n, points, &r);
}

ylm_status baker_ask(baker *b, const ylm_field *field, size_t n, field_block *k) {
  const ylm_grid_form *f = &b->g->view.form;
  ylm_field_result r = {.value = k->value,
                        .gradient = k->gradient,
                        .hessian = k->hessian,
                        .lambda = k->lambda,
                        .norm = k->norm,
                        .inside = k->inside};
  memset(k->inside, 0, n);
  int want = YLM_WANT_VALUE | YLM_WANT_GRADIENT | (k->hessian ? YLM_WANT_HESSIAN : 0);
  if (f->metric_channels)
    want |= YLM_WANT_METRIC;
  else
    for (size_t i = 0; i < n; i++) k->lambda[i] = k->norm[i] = NAN;
  k->hessian_channels = f->channels;
  return ask(b, field, want, f->channels, n, k->position, &r);
}

ylm_status baker_ask_few(baker *b, const ylm_field *field, size_t n, field_block *k) {
  const ylm_grid_form *f = &b->g->view.form;
  ylm_field_result r = {.value = k->value, .gradient = k->gradient, .inside = k->inside};
  ylm_status s = ask(b, field, YLM_WANT_VALUE | YLM_WANT_GRADIENT, f->channels, n, k->position, &r);
  if (s != YLM_OK || !k->hessian) return s;
  ylm_field_result h = {.hessian = k->hessian, .inside = k->inside};
  k->hessian_channels = f->metric_channels;
  s = ask(b, field, YLM_WANT_HESSIAN, f->metric_channels, n, k->position, &h);
  b->g->stats.pairs -= h.pairs; /* the same pairs again */
  return s;
}

void ylm__grid_asked(const ylm_grid *g, uint32_t point, float out[3]) {
  double p[3];
  ylm_grid_position(g, g->lattice + 3 * (size_t)point, p);
  for (size_t a = 0; a < 3; a++) out[a] = (float)p[a];
}

/* Points that are evaluated together: those of a list, or from `first` on. */
typedef struct evaluation {
  baker *b;
  field_block *block;
  const uint32_t *list;
  size_t first;
} evaluation;

static size_t point_of(const evaluation *j, size_t i) {
  return j->list ? j->list[i] : j->first + i;
}

/*
** Puts a block's results in their places. The field was asked at positions rounded to float; the
** gradient carries the value over the last bit to the exact lattice position.
*/
static ylm_status store_block(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const evaluation *j = context;
  const field_block *k = j->block;
  ylm_grid *g = j->b->g;
  size_t w = g->width;
  for (size_t i = begin; i < end; i++) {
    double exact[3];
    size_t p = point_of(j, i);
    float d[3], *to = g->data + p * 4 * g->stride;
    ylm_grid_position(g, g->lattice + 3 * p, exact);
    for (size_t a = 0; a < 3; a++) d[a] = (float)(exact[a] - (double)k->position[3 * i + a]);
    const float *value = k->value + i * w, *slope = k->gradient + i * w * 3;
    for (size_t c = 0; c < w; c++) {
      to[c] = value[c] + (d[0] * slope[3 * c] + d[1] * slope[3 * c + 1] + d[2] * slope[3 * c + 2]);
      for (size_t a = 0; a < 3; a++) to[(a + 1) * g->stride + c] = slope[3 * c + a];
    }
    for (size_t a = 0; a < 4; a++) memset(to + a * g->stride + w, 0, (g->stride - w) * sizeof *to);
    g->lambda[p] = k->lambda[i];
    g->norm[p] = k->norm[i];
    g->flags[p] &= (uint8_t)~YLM_GRID_POINT_INVALID;
    if (k->inside[i]) g->flags[p] |= YLM_GRID_POINT_INVALID;
    if (!ylm_all_finite(YLM_FLOAT, to, 4 * g->stride, NULL)) return YLM_EDOMAIN;
    if (g->dynamic) ylm__dynamic_store(g, (uint32_t)p, k, i);
  }
  return YLM_OK;
}

/* Names the first point of a block at which the field is not finite. */
static ylm_status not_finite(const baker *b, size_t n, const field_block *k) {
  size_t w = b->g->width, bad = 0, slope;
  if (ylm_all_finite(YLM_FLOAT, k->value, n * w, &bad)) bad = n * w;
  if (!ylm_all_finite(YLM_FLOAT, k->gradient, n * w * 3, &slope) && slope / 3 < bad)
    bad = slope / 3;
  const float *p = k->position + 3 * (bad / w < n ? bad / w : 0);
  return ylm_fail(b->e, YLM_EDOMAIN, "the light field is not finite at (%g, %g, %g)", (double)p[0],
                  (double)p[1], (double)p[2]);
}

/* Evaluates the n points of j, which fit into its block. */
static ylm_status evaluate_block(const evaluation *j, size_t n) {
  baker *b = j->b;
  for (size_t i = 0; i < n; i++)
    ylm__grid_asked(b->g, (uint32_t)point_of(j, i), j->block->position + 3 * i);
  ylm_status s = baker_ask(b, b->source->field, n, j->block);
  if (s != YLM_OK) return s;
  s = ylm_parallel(n, 64, b->source->threads, store_block, (void *)(uintptr_t)j, NULL, NULL);
  return s == YLM_EDOMAIN ? not_finite(b, n, j->block) : s;
}

static void free_block(field_block *k) {
  ylm_free(k->position);
  ylm_free(k->value);
  ylm_free(k->gradient);
  ylm_free(k->lambda);
  ylm_free(k->norm);
  ylm_free(k->hessian);
  ylm_free(k->inside);
  *k = (field_block){0};
}

ylm_status baker_reserve_block(baker *b, field_block *k, size_t n) {
  size_t width = b->g->width;
  if (n > BLOCK) n = BLOCK;
  if (n <= k->room) return YLM_OK;
  bool bends = ylm__dynamic_bends(b->g);
  free_block(k);
  *k = (field_block){.position = ylm_alloc(n, 3 * sizeof(float)),
                     .value = ylm_alloc(n, width * sizeof(float)),
                     .gradient = ylm_alloc(n, 3 * width * sizeof(float)),
                     .lambda = ylm_alloc(n, sizeof(float)),
                     .norm = ylm_alloc(n, sizeof(float)),
                     .hessian = bends ? ylm_alloc(n, 6 * width * sizeof(float)) : NULL,
                     .inside = ylm_alloc(n, 1),
                     .room = n};
  bool ok = k->position && k->value && k->gradient && k->lambda && k->norm && k->inside &&
            (k->hessian || !bends);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* Evaluates the n points of `list`, or from `first` on. */
static ylm_status evaluate(baker *b, size_t n, const uint32_t *list, size_t first) {
  ylm_status s = baker_reserve_block(b, &b->block, n);
  for (size_t i = 0; s == YLM_OK && i < n; i += BLOCK) {
    evaluation j = {b, &b->block, list ? list + i : NULL, first + i};
    s = evaluate_block(&j, n - i < BLOCK ? n - i : BLOCK);
  }
  return s;
}

ylm_status baker_evaluate(baker *b) {
  ylm_grid *g = b->g;
  ylm_status s = ylm__dynamic_reserve(g);
  if (s == YLM_OK) s = evaluate(b, g->points - g->evaluated, NULL, g->evaluated);
  g->evaluated = g->points;
  return s;
}

ylm_status baker_evaluate_list(baker *b, size_t n, const uint32_t *list) {
  return evaluate(b, n, list, 0);
}

/* -- cells -------------------------------------------------------------------------------- */

/* Lattice coordinates of corner k of a cell. */
static void corner_at(const ylm_grid *g, const ylm_grid_cell *c, int k, uint32_t at[3]) {
  uint32_t edge = ylm__grid_edge(g, c);
  for (int a = 0; a < 3; a++) at[a] = c->origin[a] + (k >> a & 1 ? edge : 0);
}

float baker_metric(const baker *b, const ylm_grid_cell *c, ylm_grid_metric metric) {
  const ylm_grid *g = b->g;
  if (!g->view.form.metric_channels) return NAN;
  double box = 0, sum = 0, edge = ylm__grid_edge(g, c);
  int n = 0;
  for (int a = 0; a < 3; a++) box += edge / g->scale[a] * (edge / g->scale[a]);
  for (int k = 0; k < 8; k++) {
    uint32_t p = c->corner[k];
    if (g->flags[p] & YLM_GRID_POINT_INVALID) continue;
    double x = (double)g->lambda[p], norm = (double)g->norm[p];
    n++;
    if (x > 0) sum += metric == YLM_GRID_RELATIVE ? x / norm : x;
  }
  return n ? (float)(sum / n * box / 2) : 0;
}

/* True if no light crossed the cell before an update, and none that changed is near it. */
static bool settled(const baker *b, uint32_t cell) {
  const ylm_grid_cell *old = baker_before(b, &b->g->cell[cell]);
  double box[6];
  if (!old || old->flags & YLM_GRID_CROSSED) return false;
  ylm_grid_box(b->g, cell, box);
  for (size_t i = 0; i < b->unsettleds; i++) {
    const double *u = b->unsettled + 6 * i;
    bool apart = false;
    for (int a = 0; a < 3; a++) apart |= box[a] > u[a + 3] || u[a] > box[a + 3];
    if (!apart) return false;
  }
  return true;
}

/*
** Asks which cells of the wave a light's surface crosses. Cells come with their parent's answer: a
** surface that meets a child meets its parent, so only children of crossed cells are asked about.
*/
static ylm_status find_crossed(baker *b) {
  const ylm_field *f = b->source->field;
  ylm_grid *g = b->g;
  size_t n = 0;
  for (size_t i = 0; i < b->wave.n; i++) {
    ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
    if (!f->crosses || settled(b, b->wave.cell[i])) c->flags &= (uint8_t)~YLM_GRID_CROSSED;
    n += (c->flags & YLM_GRID_CROSSED) != 0;
  }
  if (!n) return YLM_OK;
  double *box = ylm_alloc(n, 6 * sizeof *box);
  uint8_t *out = ylm_alloc_zero(n, 1);
  if (!box || !out) {
    ylm_free(box);
    ylm_free(out);
    return YLM_ENOMEM;
  }
  for (size_t i = 0, k = 0; i < b->wave.n; i++)
    if (g->cell[b->wave.cell[i]].flags & YLM_GRID_CROSSED)
      ylm_grid_box(g, b->wave.cell[i], box + 6 * k++);
  double t = ylm_seconds();
  ylm_status s = f->crosses(f, n, box, out);
  g->stats.field_seconds += ylm_seconds() - t;
  for (size_t i = 0, k = 0; i < b->wave.n; i++) {
    ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
    if (c->flags & YLM_GRID_CROSSED && !out[k++]) c->flags &= (uint8_t)~YLM_GRID_CROSSED;
  }
  ylm_free(box);
  ylm_free(out);
  return s;
}

/* Takes the corners of the cell that was in the same place; false if there was none. */
static bool take_corners(baker *b, ylm_grid_cell *c) {
  const ylm_grid_cell *old = baker_before(b, c);
  if (!old || !(old->flags & YLM_GRID_OCCUPIED)) return false;
  for (int k = 0; k < 8; k++) {
    uint32_t p = c->corner[k] = old->corner[k];
    b->used[p] = 1;
    b->g->flags[p] &= (uint8_t)~YLM_GRID_POINT_TESTED;
  }
  return true;
}

/* Finds the corners of the wave's cells; new points wait. */
static ylm_status find_corners(baker *b) {
  ylm_grid *g = b->g;
  for (size_t i = 0; i < b->wave.n; i++) {
    ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
    if (take_corners(b, c)) continue;
    for (int k = 0; k < 8; k++) {
      uint32_t at[3];
      corner_at(g, c, k, at);
      ylm_status s = baker_point(b, at, 0, &c->corner[k]);
      if (s != YLM_OK) return s;
    }
  }
  return YLM_OK;
}

ylm_status baker_corners(baker *b) {
  ylm_grid *g = b->g;
  double t = ylm_seconds();
  ylm_status s = find_corners(b);
  g->stats.lattice_seconds += ylm_seconds() - t;
  if (s == YLM_OK) s = baker_evaluate(b);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < b->wave.n; i++) {
    ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
    c->error = baker_metric(b, c, g->view.form.metric);
  }
  return g->view.form.kind == YLM_GRID_UNIFORM ? YLM_OK : find_crossed(b);
}

ylm_status baker_split(baker *b, uint32_t cell) {
  ylm_grid *g = b->g;
  uint32_t first;
  ylm_status s = ylm__grid_split(g, cell, &first);
  if (s != YLM_OK) return s;
  const ylm_grid_cell *old = baker_before(b, &g->cell[cell]);
  if (old && old->flags & YLM_GRID_LEAF) old = NULL; /* it had none, or for continuity only */
  g->cell[cell].flags &= (uint8_t)~YLM_GRID_LEAF;
  for (uint32_t k = first; k < first + 8; k++) {
    ylm_grid_cell *c = &g->cell[k];
    uint32_t node[3], shift = (uint32_t)(g->view.form.depth - c->level);
    for (int a = 0; a < 3; a++) node[a] = c->origin[a] >> shift;
    c->flags = YLM_GRID_LEAF;
    if (b->before) c->source = old ? old->child + (k - first) : YLM_GRID_NONE;
    if (!occupancy_test(&b->occupied, c->level, node)) continue;
    c->flags |= YLM_GRID_OCCUPIED | (g->cell[cell].flags & YLM_GRID_CROSSED);
    s = cell_list_push(&b->next, k);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

void baker_advance(baker *b) {
  cell_list spent = b->wave;
  b->wave = b->next;
  b->next = spent;
  b->next.n = 0;
}

/* Corners of unoccupied cells that were evaluated for their neighbours. */
static void find_shared_corners(baker *b) {
  ylm_grid *g = b->g;
  for (size_t i = 0; i < g->cells; i++) {
    ylm_grid_cell *c = &g->cell[i];
    for (int k = 0; k < 8; k++) {
      uint32_t at[3];
      if (c->corner[k] != YLM_GRID_NONE) continue;
      corner_at(g, c, k, at);
      c->corner[k] = lattice_hash_find(&b->g->hash, lattice_key(at));
    }
  }
}

ylm_status baker_finish(baker *b, bool last) {
  ylm_grid *g = b->g;
  g->view.octree_cells = g->cells;
  double t = ylm_seconds();
  find_shared_corners(b);
  g->stats.lattice_seconds += ylm_seconds() - t;
  ylm_status s = ylm__grid_fill_invalid(g);
  ylm__grid_find_baked(g);
  t = ylm_seconds();
  bool continuous = g->view.form.kind == YLM_GRID_ADAPTIVE && g->view.form.continuous;
  if (s == YLM_OK && last && continuous) s = ylm__grid_make_continuous(g, b->source->threads);
  g->stats.continuity_seconds += ylm_seconds() - t;
  return s == YLM_OK ? ylm__grid_finish(g) : s;
}

/* -- the three bakes ------------------------------------------------------------------------ */

ylm_status baker_refine_threshold(baker *b) {
  ylm_grid *g = b->g;
  int depth = g->view.form.depth;
  for (int level = 0; b->wave.n; level++) {
    snprintf(b->stage_text, sizeof b->stage_text, "level %d", level);
    ylm_status s = baker_corners(b);
    for (size_t i = 0; s == YLM_OK && i < b->wave.n; i++) {
      const ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
      bool above = (double)c->error > g->view.form.threshold || c->flags & YLM_GRID_CROSSED;
      if (c->level < depth && above) s = baker_split(b, b->wave.cell[i]);
    }
    if (s != YLM_OK) return s;
    baker_advance(b);
  }
  return YLM_OK;
}

/* The paper's: split where the metric exceeds the threshold. */
static ylm_status bake_threshold(baker *b) {
  ylm_status s = baker_refine_threshold(b);
  return s == YLM_OK ? baker_finish(b, true) : s;
}

ylm_status baker_root(baker *b) {
  ylm_grid *g = b->g;
  ylm_status s = ylm__grid_reserve_cells(g, 1);
  if (s != YLM_OK) return s;
  ylm_grid_cell root = {
      .error = NAN, .residual = NAN, .flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_CROSSED};
  for (int k = 0; k < 8; k++) root.corner[k] = YLM_GRID_NONE;
  g->cell[g->cells++] = root;
  return cell_list_push(&b->wave, 0);
}

/* Voxels of a lattice, all or those that hold shading points. */
static ylm_status bake_uniform(baker *b) {
  ylm_grid *g = b->g;
  const uint32_t *r = g->view.resolution;
  size_t n = (size_t)r[0] * r[1] * r[2];
  uint8_t *mark = ylm_alloc_zero(n, 1);
  if (!mark) return YLM_ENOMEM;
  ylm_status s = YLM_OK;
  double t = ylm_seconds();
  if (!b->source->occupied_points)
    memset(mark, 1, n);
  else
    s = occupancy_mark_uniform(g, b->source, mark, &g->stats.outside);
  g->stats.occupancy_seconds = ylm_seconds() - t;
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    if (!mark[i]) continue;
    s = ylm__grid_reserve_cells(g, 1);
    if (s == YLM_OK) s = cell_list_push(&b->wave, (uint32_t)g->cells);
    if (s != YLM_OK) break;
    ylm_grid_cell c = {.error = NAN, .residual = NAN, .flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED};
    c.origin[0] = (uint32_t)(i % r[0]);
    c.origin[1] = (uint32_t)(i / r[0] % r[1]);
    c.origin[2] = (uint32_t)(i / r[0] / r[1]);
    g->cell[g->cells++] = c;
  }
  ylm_free(mark);
  snprintf(b->stage_text, sizeof b->stage_text, "baking");
  if (s == YLM_OK) s = baker_corners(b);
  return s == YLM_OK ? baker_finish(b, true) : s;
}

static ylm_status bake(baker *b) {
  b->stage = b->stage_text;
  if (b->g->view.form.kind == YLM_GRID_UNIFORM) return bake_uniform(b);
  double t = ylm_seconds();
  ylm_status s = occupancy_build(&b->occupied, b->g, b->source, &b->g->stats.outside);
  b->g->stats.occupancy_seconds = ylm_seconds() - t;
  if (s == YLM_OK) s = baker_root(b);
  if (s != YLM_OK) return s;
  return b->g->view.form.tolerance > 0 ? ylm__grid_bake_tolerance(b) : bake_threshold(b);
}

ylm_status ylm__grid_check_source(const ylm_grid_source *s, bool dynamic, ylm_error *e) {
  size_t bad;
  if (!s->field || !s->field->evaluate) return ylm_fail(e, YLM_EINVAL, "no light field");
  if (dynamic && !s->lights)
    return ylm_fail(e, YLM_EINVAL,
                    "dynamic: a grid that is to be updated is baked from sphere lights");
  if (!s->occupied_points) return YLM_OK;
  if (s->occupied == 0) return ylm_fail(e, YLM_EINVAL, "occupied: no points");
  if (!ylm_all_finite(s->occupied_dtype, s->occupied_points, 3 * s->occupied, &bad))
    return ylm_fail(e, YLM_EDOMAIN, "occupied: point %zu is not finite", bad / 3 + 1);
  return YLM_OK;
}

void baker_free(baker *b) {
  free_block(&b->block);
  ylm_free(b->wave.cell);
  ylm_free(b->next.cell);
  ylm_free(b->used);
}

ylm_status ylm__grid_no_room(ylm_status s, const ylm_grid_source *source, ylm_error *e) {
  if (s == YLM_ENOMEM) ylm_fail(e, s, "the grid does not fit into memory");
  if (s == YLM_ELIMIT)
    ylm_fail(e, s, "the grid needs more than %zu points",
             source->max_points ? source->max_points : (size_t)YLM_GRID_NONE);
  return s;
}

ylm_status ylm_grid_bake(const ylm_grid_form *form, const ylm_grid_source *source, ylm_grid **out,
                         ylm_error *e) {
  double begin = ylm_seconds();
  *out = NULL;
  ylm_status s = ylm__grid_check_form(form, e);
  if (s == YLM_OK) s = ylm__grid_check_source(source, form->dynamic, e);
  if (s != YLM_OK) return s;
  baker b = {.g = ylm__grid_new(form), .source = source, .e = e};
  s = b.g ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && form->dynamic) s = ylm__dynamic_begin(b.g, source, e);
  if (s == YLM_OK) s = bake(&b);
  if (s == YLM_OK && form->dynamic) s = ylm__dynamic_end(b.g, &b.occupied);
  occupancy_free(&b.occupied);
  baker_free(&b);
  if (s != YLM_OK) {
    ylm_grid_free(b.g);
    return ylm__grid_no_room(s, source, e);
  }
  b.g->stats.seconds = ylm_seconds() - begin;
  *out = b.g;
  return YLM_OK;
}
