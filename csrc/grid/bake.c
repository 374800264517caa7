/* bake.c - asking a light field for the points of a grid, level by level. */
#include "grid.h"

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

ylm_status baker_point(baker *b, const uint32_t at[3], uint8_t flags, uint32_t *index) {
  ylm_grid *g = b->g;
  ylm_status s = lattice_hash_reserve(&b->g->hash, b->g->hash.used + 1);
  if (s == YLM_OK) s = ylm__grid_reserve_points(g, 1);
  if (s != YLM_OK) return s;
  uint32_t *entry = lattice_hash_at(&b->g->hash, lattice_key(at));
  if (*entry == YLM_GRID_NONE) {
    if (b->source->max_points && g->points >= b->source->max_points) return YLM_ELIMIT;
    *entry = (uint32_t)g->points++;
    memcpy(g->lattice + 3 * (size_t)*entry, at, 3 * sizeof *at);
    g->flags[*entry] = flags;
  }
  if (!flags) g->flags[*entry] &= (uint8_t)~YLM_GRID_POINT_TESTED;
  *index = *entry;
  return YLM_OK;
}

/* Reports the field's progress under the bake's own stage. */
static bool forward(void *user, uint64_t done, uint64_t total, const char *stage) {
  const baker *b = user;
  (void)stage;
  return ylm_report(b->source->progress, done, total, b->stage) == YLM_OK;
}

/* Asks the field, and keeps the time. */
static ylm_status ask(baker *b, int want, size_t n, const float *points, ylm_field_result *r) {
  const ylm_grid_form *f = &b->g->view.form;
  ylm_progress progress = {forward, b};
  ylm_field_query q = {.lmax = f->lmax,
                       .channels = f->channels,
                       .want = want,
                       .metric_channels = f->metric_channels == 3 ? 3 : 1,
                       .dtype = YLM_FLOAT,
                       .threads = b->source->threads,
                       .progress = b->source->progress ? &progress : NULL};
  const ylm_field *field = b->source->field;
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
  return ask(b, YLM_WANT_VALUE, n, points, &r);
}

/*
** Puts a block's results in their places. The field was asked at positions rounded to float; the
** gradient carries the value over the last bit to the exact lattice position.
*/
static ylm_status store_block(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const baker *b = ((void **)context)[0];
  const field_block *k = ((void **)context)[1];
  ylm_grid *g = b->g;
  size_t first = *(size_t *)((void **)context)[2], w = g->width;
  for (size_t i = begin; i < end; i++) {
    double exact[3];
    float d[3], *to = g->data + (first + i) * 4 * g->stride;
    ylm_grid_position(g, g->lattice + 3 * (first + i), exact);
    for (size_t a = 0; a < 3; a++) d[a] = (float)(exact[a] - (double)k->position[3 * i + a]);
    const float *value = k->value + i * w, *slope = k->gradient + i * w * 3;
    for (size_t j = 0; j < w; j++) {
      to[j] = value[j] + (d[0] * slope[3 * j] + d[1] * slope[3 * j + 1] + d[2] * slope[3 * j + 2]);
      for (size_t a = 0; a < 3; a++) to[(a + 1) * g->stride + j] = slope[3 * j + a];
    }
    for (size_t a = 0; a < 4; a++) memset(to + a * g->stride + w, 0, (g->stride - w) * sizeof *to);
    if (k->inside[i]) g->flags[first + i] |= YLM_GRID_POINT_INVALID;
    if (!ylm_all_finite(YLM_FLOAT, to, 4 * g->stride, NULL)) return YLM_EDOMAIN;
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

/* Evaluates n points from `first` on. */
static ylm_status evaluate_block(baker *b, size_t first, size_t n, const field_block *k) {
  ylm_grid *g = b->g;
  for (size_t i = 0; i < n; i++) {
    double p[3];
    ylm_grid_position(g, g->lattice + 3 * (first + i), p);
    for (size_t a = 0; a < 3; a++) k->position[3 * i + a] = (float)p[a];
  }
  ylm_field_result r = {.value = k->value,
                        .gradient = k->gradient,
                        .lambda = g->lambda + first,
                        .norm = g->norm + first,
                        .inside = k->inside};
  memset(k->inside, 0, n);
  int want = YLM_WANT_VALUE | YLM_WANT_GRADIENT;
  if (g->view.form.metric_channels)
    want |= YLM_WANT_METRIC;
  else
    for (size_t i = 0; i < n; i++) g->lambda[first + i] = g->norm[first + i] = NAN;
  ylm_status s = ask(b, want, n, k->position, &r);
  if (s != YLM_OK) return s;
  void *context[3] = {b, (void *)(uintptr_t)k, &first};
  s = ylm_parallel(n, 64, b->source->threads, store_block, context, NULL, NULL);
  return s == YLM_EDOMAIN ? not_finite(b, n, k) : s;
}

static void free_block(field_block *k) {
  ylm_free(k->position);
  ylm_free(k->value);
  ylm_free(k->gradient);
  ylm_free(k->inside);
  *k = (field_block){0};
}

/* Room for the results of n points. */
static ylm_status reserve_block(field_block *k, size_t n, size_t width) {
  if (n <= k->room) return YLM_OK;
  free_block(k);
  *k = (field_block){ylm_alloc(n, 3 * sizeof(float)), ylm_alloc(n, width * sizeof(float)),
                     ylm_alloc(n, 3 * width * sizeof(float)), ylm_alloc(n, 1), n};
  return k->position && k->value && k->gradient && k->inside ? YLM_OK : YLM_ENOMEM;
}

ylm_status baker_evaluate(baker *b) {
  ylm_grid *g = b->g;
  size_t waiting = g->points - g->evaluated;
  ylm_status s = reserve_block(&b->block, waiting < BLOCK ? waiting : BLOCK, g->width);
  while (s == YLM_OK && g->evaluated < g->points) {
    size_t left = g->points - g->evaluated, now = left < BLOCK ? left : BLOCK;
    s = evaluate_block(b, g->evaluated, now, &b->block);
    g->evaluated += now;
  }
  return s;
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
    if (!f->crosses) c->flags &= (uint8_t)~YLM_GRID_CROSSED;
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

ylm_status baker_corners(baker *b) {
  ylm_grid *g = b->g;
  for (size_t i = 0; i < b->wave.n; i++) {
    ylm_grid_cell *c = &g->cell[b->wave.cell[i]];
    for (int k = 0; k < 8; k++) {
      uint32_t at[3];
      corner_at(g, c, k, at);
      ylm_status s = baker_point(b, at, 0, &c->corner[k]);
      if (s != YLM_OK) return s;
    }
  }
  ylm_status s = baker_evaluate(b);
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
  g->cell[cell].flags &= (uint8_t)~YLM_GRID_LEAF;
  for (uint32_t k = first; k < first + 8; k++) {
    ylm_grid_cell *c = &g->cell[k];
    uint32_t node[3], shift = (uint32_t)(g->view.form.depth - c->level);
    for (int a = 0; a < 3; a++) node[a] = c->origin[a] >> shift;
    c->flags = YLM_GRID_LEAF;
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
  find_shared_corners(b);
  ylm_status s = ylm__grid_fill_invalid(g);
  ylm__grid_find_baked(g);
  bool continuous = g->view.form.kind == YLM_GRID_ADAPTIVE && g->view.form.continuous;
  if (s == YLM_OK && last && continuous) s = ylm__grid_make_continuous(g);
  return s == YLM_OK ? ylm__grid_finish(g) : s;
}

/* -- the three bakes ------------------------------------------------------------------------ */

/* The paper's: split where the metric exceeds the threshold. */
static ylm_status bake_threshold(baker *b) {
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
  return baker_finish(b, true);
}

/* The root alone, occupied. */
static ylm_status begin_octree(baker *b) {
  ylm_grid *g = b->g;
  ylm_status s = occupancy_build(&b->occupied, g, b->source, &g->stats.outside);
  if (s == YLM_OK) s = ylm__grid_reserve_cells(g, 1);
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
  if (!b->source->occupied_points)
    memset(mark, 1, n);
  else
    s = occupancy_mark_uniform(g, b->source, mark, &g->stats.outside);
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
  ylm_status s = begin_octree(b);
  if (s != YLM_OK) return s;
  return b->g->view.form.tolerance > 0 ? ylm__grid_bake_tolerance(b) : bake_threshold(b);
}

/* What is wrong with a source, if anything. */
static ylm_status check_source(const ylm_grid_source *s, ylm_error *e) {
  size_t bad;
  if (!s->field || !s->field->evaluate) return ylm_fail(e, YLM_EINVAL, "no light field");
  if (!s->occupied_points) return YLM_OK;
  if (s->occupied == 0) return ylm_fail(e, YLM_EINVAL, "occupied: no points");
  if (!ylm_all_finite(s->occupied_dtype, s->occupied_points, 3 * s->occupied, &bad))
    return ylm_fail(e, YLM_EDOMAIN, "occupied: point %zu is not finite", bad / 3 + 1);
  return YLM_OK;
}

ylm_status ylm_grid_bake(const ylm_grid_form *form, const ylm_grid_source *source, ylm_grid **out,
                         ylm_error *e) {
  double begin = ylm_seconds();
  *out = NULL;
  ylm_status s = ylm__grid_check_form(form, e);
  if (s == YLM_OK) s = check_source(source, e);
  if (s != YLM_OK) return s;
  baker b = {.g = ylm__grid_new(form), .source = source, .e = e};
  s = b.g ? bake(&b) : YLM_ENOMEM;
  occupancy_free(&b.occupied);
  free_block(&b.block);
  ylm_free(b.wave.cell);
  ylm_free(b.next.cell);
  if (s != YLM_OK) {
    ylm_grid_free(b.g);
    if (s == YLM_ENOMEM) ylm_fail(e, s, "the grid does not fit into memory");
    if (s == YLM_ELIMIT)
      ylm_fail(e, s, "the grid needs more than %zu points",
               source->max_points ? source->max_points : (size_t)YLM_GRID_NONE);
    return s;
  }
  b.g->stats.seconds = ylm_seconds() - begin;
  *out = b.g;
  return YLM_OK;
}
