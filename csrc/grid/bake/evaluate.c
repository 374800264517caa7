/* evaluate.c - asking a light field for the data of points. */
#include "baker.h"
#include "ylm_light.h"
#include "ylm_light_virtual.h"

#include <math.h>
#include <string.h>

/* Asks a field, and keeps the time. */
static ylm_status ask(baker *b, const ylm_field *field, int want, int channels, size_t n,
                      const float *points, ylm_field_result *r) {
  const ylm_grid_form *f = &b->g->contents.form;
  ylm_field_query q = {.lmax = f->lmax,
                       .channels = channels,
                       .want = want,
                       .metric_channels = f->metric_channels == 3 ? 3 : 1,
                       .dtype = YLM_FLOAT,
                       .threads = b->source->threads,
                       .progress = b->making.progress,
                       .origin = ylm__grid_origin(b->g)};
  uint64_t before = r->pairs;
  double t = ylm_seconds();
  ylm_status s = ylm_field_evaluate(field, &q, n, points, r, b->e);
  b->g->stats.field_seconds += ylm_seconds() - t;
  b->g->stats.pairs += r->pairs - before;
  return s;
}

/* Values at all n points: they are asked for at once, and results may depend on that. */
static ylm_status ask_values(baker *b, size_t n, const float *points, float *value,
                             uint8_t *inside) {
  ylm_field_result r = {.value = value, .inside = inside};
  memset(inside, 0, n);
  return ask(b, b->source->field, YLM_WANT_VALUE, b->g->contents.form.channels, n, points, &r);
}

/* Points of this process, where each does `part` of n. */
static size_t own_part(const baker *b, size_t n, size_t part, size_t *first) {
  *first = part * (size_t)b->source->team->rank;
  if (*first >= n) return *first = 0;
  return n - *first < part ? n - *first : part;
}

ylm_status ylm__evaluate_values(baker *b, size_t n, const float *points, float *value,
                                uint8_t *inside) {
  size_t part = b->source->field->pointwise ? ylm__divide_part(b, n) : n, first;
  if (part == n) return ask_values(b, n, points, value, inside);
  size_t own = own_part(b, n, part, &first), row = b->g->width;
  uint64_t before = b->g->stats.pairs;
  ylm_status s =
      own ? ask_values(b, own, points + 3 * first, value + first * row, inside + first) : YLM_OK;
  s = ylm__divide_agree(b, s);
  if (s == YLM_OK) s = ylm__divide_share(b, n, part, row * sizeof *value, value);
  if (s == YLM_OK) s = ylm__divide_share(b, n, part, 1, inside);
  return s == YLM_OK ? ylm__divide_count(b, before, &b->g->stats.pairs) : s;
}

ylm_status ylm__evaluate_ask(baker *b, const ylm_field *field, size_t n, field_block *k) {
  const ylm_grid_form *f = &b->g->contents.form;
  ylm_field_result r = {.value = k->value,
                        .gradient = k->gradient,
                        .hessian = k->hessian,
                        .lambda = k->lambda,
                        .norm = k->norm,
                        .inside = k->inside,
                        .validity = k->validity};
  memset(k->inside, 0, n);
  int want = YLM_WANT_VALUE | YLM_WANT_GRADIENT | (k->hessian ? YLM_WANT_HESSIAN : 0);
  if (f->metric_channels)
    want |= YLM_WANT_METRIC | (f->tolerance > 0 ? YLM_WANT_ROUGH : 0);
  else
    for (size_t i = 0; i < n; i++) k->lambda[i] = k->norm[i] = NAN;
  return ask(b, field, want, f->channels, n, k->position, &r);
}

void ylm__grid_asked(const ylm_grid *g, uint32_t point, float out[3]) {
  double p[3];
  if (g->flags[point] & YLM_GRID_POINT_GHOST) {
    memcpy(out, g->sides.asked[point], sizeof *g->sides.asked);
    return;
  }
  ylm_grid_position(g, g->lattice + 3 * (size_t)point, p);
  ylm__grid_inward(g, p, out);
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

/* Shortens a ghost's way d so that light changes by at most GHOST_MOST of its norm on it. */
static void shorten(size_t w, const float *value, const float *slope, float d[3]) {
  double norm = 0, change = 0;
  for (size_t c = 0; c < w; c++) {
    double x = (double)carried(0, d, slope + 3 * c);
    norm += (double)value[c] * (double)value[c];
    change += x * x;
  }
  double most = GHOST_MOST * sqrt(norm), way = sqrt(change);
  for (int a = 0; way > most && a < 3; a++) d[a] *= (float)(most / way);
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
    float d[3], *to = g->data + p * ylm__grid_record(g);
    ylm_grid_position(g, g->lattice + 3 * p, exact);
    for (size_t a = 0; a < 3; a++)
      d[a] = (float)(exact[a] - g->origin[a] - (double)k->position[3 * i + a]);
    const float *value = k->value + i * w, *slope = k->gradient + i * w * 3;
    if (g->flags[p] & YLM_GRID_POINT_GHOST) shorten(w, value, slope, d);
    for (size_t c = 0; c < w; c++) {
      to[c] = carried(value[c], d, slope + 3 * c);
      for (size_t a = 0; a + 1 < g->rows; a++) to[(a + 1) * g->stride + c] = slope[3 * c + a];
    }
    for (size_t a = 0; a < g->rows; a++)
      memset(to + a * g->stride + w, 0, (g->stride - w) * sizeof *to);
    g->lambda[p] = k->lambda[i];
    g->norm[p] = k->norm[i];
    g->flags[p] &= (uint8_t)~YLM_GRID_POINT_INVALID;
    if (k->inside[i]) g->flags[p] |= YLM_GRID_POINT_INVALID;
    if (k->validity) g->validity[p] = k->validity[i];
    if (!ylm_all_finite(YLM_FLOAT, to, ylm__grid_record(g), NULL)) return YLM_EDOMAIN;
    if (g->follower) g->follower->store(g, (uint32_t)p, k, i);
  }
  return YLM_OK;
}

/* Names the first point of a block whose results, or whose rows, are beyond the range of float. */
static ylm_status not_finite(const evaluation *j, size_t n) {
  const field_block *k = j->block;
  const baker *b = j->b;
  ylm_field_query q = {.lmax = b->g->contents.form.lmax,
                       .channels = b->g->contents.form.channels,
                       .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT,
                       .dtype = YLM_FLOAT,
                       .origin = ylm__grid_origin(b->g)};
  ylm_field_result r = {.value = k->value, .gradient = k->gradient};
  ylm_status s = ylm_light_finite(&q, n, k->position, &r, b->e);
  if (s != YLM_OK) return s;
  size_t i = 0,
         row = ylm__grid_record(b->g); /* a gradient was too large for the last bit of a position */
  while (i + 1 < n && ylm_all_finite(YLM_FLOAT, b->g->data + point_of(j, i) * row, row, NULL)) i++;
  return ylm_light_beyond("the light field", YLM_FLOAT, i, k->position, b->e);
}

/* The block from its row `first` on. */
static field_block part_of(const baker *b, const field_block *k, size_t first) {
  size_t w = b->g->width;
  return (field_block){.position = k->position + 3 * first,
                       .value = k->value + w * first,
                       .gradient = k->gradient + 3 * w * first,
                       .lambda = k->lambda + first,
                       .norm = k->norm + first,
                       .inside = k->inside + first,
                       .validity = k->validity ? k->validity + first : NULL,
                       .room = k->room - first};
}

/* Every process asks for its part of n points, and all have the results. */
static ylm_status ask_together(baker *b, size_t n, size_t part, field_block *k) {
  size_t first, own = own_part(b, n, part, &first), w = b->g->width * sizeof *k->value;
  uint64_t before = b->g->stats.pairs;
  field_block mine = part_of(b, k, first);
  ylm_status s = own ? ylm__evaluate_ask(b, b->source->field, own, &mine) : YLM_OK;
  s = ylm__divide_agree(b, s);
  if (s == YLM_OK) s = ylm__divide_share(b, n, part, w, k->value);
  if (s == YLM_OK) s = ylm__divide_share(b, n, part, 3 * w, k->gradient);
  if (s == YLM_OK) s = ylm__divide_share(b, n, part, sizeof *k->lambda, k->lambda);
  if (s == YLM_OK) s = ylm__divide_share(b, n, part, sizeof *k->norm, k->norm);
  if (s == YLM_OK) s = ylm__divide_share(b, n, part, 1, k->inside);
  if (s == YLM_OK && k->validity)
    s = ylm__divide_share(b, n, part, sizeof *k->validity, k->validity);
  return s == YLM_OK ? ylm__divide_count(b, before, &b->g->stats.pairs) : s;
}

/* Asks for the first points of a bake on every process: all have to have the same light field. */
static ylm_status compare_fields(baker *b, size_t n, field_block *k) {
  if (n > DIVIDE_PROBES) n = DIVIDE_PROBES;
  uint64_t before = b->g->stats.pairs;
  ylm_status s = ylm__divide_agree(b, ylm__evaluate_ask(b, b->source->field, n, k));
  b->g->stats.pairs = before;
  return s == YLM_OK ? ylm__divide_compare(b, k->value, n * b->g->width) : s;
}

/* Evaluates the n points of j, which fit into its block. */
static ylm_status evaluate_block(const evaluation *j, size_t n) {
  baker *b = j->b;
  const ylm_team *team = b->source->team;
  size_t part = ylm__divide_part(b, n);
  for (size_t i = 0; i < n; i++)
    ylm__grid_asked(b->g, (uint32_t)point_of(j, i), j->block->position + 3 * i);
  ylm_status s = YLM_OK;
  if (team && team->size > 1 && !b->g->evaluated && !j->first) s = compare_fields(b, n, j->block);
  if (s == YLM_OK)
    s = part == n ? ylm__evaluate_ask(b, b->source->field, n, j->block)
                  : ask_together(b, n, part, j->block);
  if (s != YLM_OK) return s;
  s = ylm_parallel(n, BAKE_GRAIN, b->source->threads, store_block, (void *)(uintptr_t)j, NULL,
                   NULL);
  return s == YLM_EDOMAIN ? not_finite(j, n) : s;
}

void ylm__evaluate_free_block(field_block *k) {
  ylm_free(k->position);
  ylm_free(k->value);
  ylm_free(k->gradient);
  ylm_free(k->lambda);
  ylm_free(k->norm);
  ylm_free(k->hessian);
  ylm_free(k->inside);
  ylm_free(k->validity);
  *k = (field_block){0};
}

ylm_status ylm__evaluate_reserve_block(baker *b, field_block *k, size_t n) {
  size_t width = b->g->width, most = ylm__divide_round(b);
  if (n > most) n = most;
  if (n <= k->room) return YLM_OK;
  bool hessians = b->g->follower && b->g->contents.form.metric_channels;
  ylm__evaluate_free_block(k);
  *k = (field_block){.position = ylm_alloc(n, 3 * sizeof(float)),
                     .value = ylm_alloc(n, width * sizeof(float)),
                     .gradient = ylm_alloc(n, 3 * width * sizeof(float)),
                     .lambda = ylm_alloc(n, sizeof(float)),
                     .norm = ylm_alloc(n, sizeof(float)),
                     .hessian = hessians ? ylm_alloc(n, 6 * width * sizeof(float)) : NULL,
                     .inside = ylm_alloc(n, 1),
                     .validity = b->g->validity ? ylm_alloc(n, sizeof(float)) : NULL,
                     .room = n};
  bool ok = k->position && k->value && k->gradient && k->lambda && k->norm && k->inside &&
            (k->hessian || !hessians) && (k->validity || !b->g->validity);
  return ok ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm__evaluate_points(baker *b, size_t n, const uint32_t *list, size_t first) {
  size_t most = ylm__divide_round(b);
  ylm_status s = ylm__evaluate_reserve_block(b, &b->block, n);
  for (size_t i = 0; s == YLM_OK && i < n; i += most) {
    evaluation j = {b, &b->block, list ? list + i : NULL, first + i};
    s = evaluate_block(&j, n - i < most ? n - i : most);
  }
  return s;
}
