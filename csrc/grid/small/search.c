/* search.c - a grid rounded as is asked for: each step that is tried is encoded in full, and what it decodes to is measured. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../bake/panel.h"
#include "small.h"

#define PLACES 16384 /* that rounding is looked at, where no panel judges */
#define SEED 0x736d616c6cu
#define NORMALS 6

typedef struct search {
  small_encoder *k;
  const ylm_grid *from;
  const ylm_grid_small *how;
  small_size_fn *size;
  ylm_error *e;
  size_t n; /* places */
  double (*place)[3];
  float *before;      /* [n][width] light of the grid */
  const panel *judge; /* NULL: none */
  measure m;
  double *error, *total;
  uint64_t tried;
} search;

/* -- places --------------------------------------------------------------------------------------------- */

/* Random places of leaves that hold shading points. */
static ylm_status draw_places(search *s) {
  const ylm_grid *g = s->from;
  uint32_t *leaf = ylm_alloc(g->cells, sizeof *leaf);
  size_t leaves = 0;
  ylm_rng rng;
  if (!leaf) return YLM_ENOMEM;
  for (size_t i = 0; i < g->contents.octree_cells; i++)
    if (g->cell[i].flags & YLM_GRID_LEAF && g->cell[i].flags & YLM_GRID_OCCUPIED &&
        !(g->cell[i].flags & YLM_GRID_BRICK))
      leaf[leaves++] = (uint32_t)i;
  for (size_t i = 0; !leaves && i < g->contents.octree_cells; i++)
    if (g->cell[i].flags & YLM_GRID_LEAF) leaf[leaves++] = (uint32_t)i;
  s->place = ylm_alloc(s->n, sizeof *s->place);
  ylm_rng_seed(&rng, SEED, 0);
  for (size_t i = 0; s->place && i < s->n; i++) {
    double box[6];
    size_t which = (size_t)(ylm_rng_double(&rng) * (double)leaves);
    ylm_grid_box(g, leaf[which < leaves ? which : leaves - 1], box);
    for (int a = 0; a < 3; a++)
      s->place[i][a] = box[a] + (box[a + 3] - box[a]) * ylm_rng_double(&rng);
  }
  ylm_free(leaf);
  return s->place ? YLM_OK : YLM_ENOMEM;
}

static ylm_status take_places(search *s) {
  const panel *p = s->judge;
  if (!p) return draw_places(s);
  s->n = p->n;
  s->place = ylm_alloc(s->n, sizeof *s->place);
  if (!s->place) return YLM_ENOMEM;
  for (size_t i = 0; i < s->n; i++) ylm__grid_outward(s->from, p->point + 3 * i, s->place[i]);
  return YLM_OK;
}

static ylm_status sample(const search *s, const ylm_grid *g, float *value) {
  ylm_grid_query q = {.point_dtype = YLM_DOUBLE, .dtype = YLM_FLOAT, .threads = s->how->threads};
  return ylm_grid_sample(g, &q, s->n, s->place, value, NULL, NULL, s->e);
}

/* -- errors ----------------------------------------------------------------------------------------------- */

static void normal_of(int i, float n[3]) {
  for (int a = 0; a < 3; a++) n[a] = a == i / 2 ? (i & 1 ? -1.0f : 1.0f) : 0.0f;
}

/* The mean irradiance that errors are relative to, where no panel tells: over places and normals. */
static void find_means(search *s) {
  s->m = ylm__measure_of(&s->from->contents.form);
  if (s->m.kind != YLM_GRID_IRRADIANCE) return;
  for (size_t i = 0; i < s->n; i++)
    for (int k = 0; k < NORMALS; k++) {
      float n[3];
      double e[3];
      normal_of(k, n);
      ylm__measure_irradiance(&s->m, s->before + i * s->from->width, n, e);
      for (int c = 0; c < s->m.channels; c++) s->m.mean[c] += fabs(e[c]) / (double)(NORMALS * s->n);
    }
}

/* The error of one row against another at place i: of irradiance that of the worst normal, where none is known. */
static double error_at(const search *s, size_t i, const float *row, const float *exact) {
  double worst = 0;
  if (s->m.kind != YLM_GRID_IRRADIANCE) return ylm__measure_error(&s->m, row, exact, NULL);
  if (s->judge) return ylm__measure_error(&s->m, row, exact, s->judge->side + 3 * i);
  for (int k = 0; k < NORMALS; k++) {
    float n[3];
    normal_of(k, n);
    worst = fmax(worst, ylm__measure_error(&s->m, row, exact, n));
  }
  return worst;
}

static void forget(search *s) {
  ylm_free(s->place);
  ylm_free(s->before);
  ylm_free(s->error);
  ylm_free(s->total);
}

static int by_size(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return x < y ? -1 : x > y;
}

void ylm__small_sort(double *error, size_t n) { qsort(error, n, sizeof *error, by_size); }

/* Errors, sorted, of those that are not left out; how many there are. */
static size_t sort_errors(double *error, size_t n) {
  size_t kept = 0;
  for (size_t i = 0; i < n; i++)
    if (error[i] >= 0) error[kept++] = error[i];
  ylm__small_sort(error, kept);
  return kept;
}

double ylm__small_quantile(const double *error, size_t n, double q) {
  return n ? error[(size_t)(q * (double)(n - 1))] : 0;
}

/* Measures what the encoder's grid is, into its report. */
static ylm_status judge(search *s) {
  ylm_grid_small_report *r = &ylm__small_packed_of(s->k)->report;
  size_t w = s->from->width;
  float *value = ylm_alloc(s->n, w * sizeof *value);
  ylm_status status = value ? sample(s, ylm__small_grid_of(s->k), value) : YLM_ENOMEM;
  ruling said = {0};
  for (size_t i = 0; status == YLM_OK && i < s->n; i++) {
    bool out = s->judge && s->judge->inside[i];
    double x = out ? -1 : error_at(s, i, value + i * w, s->before + i * w);
    s->error[i] = isnan(x) ? INFINITY : x;
    x = out || !s->judge ? -1 : error_at(s, i, value + i * w, s->judge->exact + i * w);
    s->total[i] = isnan(x) ? INFINITY : x;
  }
  ylm_free(value);
  if (status == YLM_OK && s->judge)
    status = ylm__panel_rule(s->judge, s->total, s->from->contents.form.tolerance, DOUBT, &said);
  if (status != YLM_OK) return status;
  size_t n = sort_errors(s->error, s->n), totals = sort_errors(s->total, s->n);
  const ylm_grid_stats *stats = &s->from->stats;
  *r = (ylm_grid_small_report){.before = stats->error,
                               .rounding = ylm__small_quantile(s->error, n, 0.99),
                               .largest = ylm__small_quantile(s->error, n, 1),
                               .middle = s->judge ? ylm__small_quantile(s->total, totals, 0.5)
                                                  : ylm__small_quantile(s->error, n, 0.5),
                               .places = n,
                               .judged = s->judge != NULL,
                               .confidence = 1 - DOUBT,
                               .step = (double)ylm__small_packed_of(s->k)->head.step};
  r->error = s->judge ? said.error : stats->error + r->largest;
  if (isnan(r->error)) r->confidence = 0;
  return YLM_OK;
}

/* -- searching ------------------------------------------------------------------------------------------------ */

#define PARTS 1000 /* of a try, in progress */

static ylm_status say(void *self, double done) {
  const search *s = self;
  return ylm_report(s->how->progress, s->tried * PARTS + (uint64_t)(done * PARTS),
                    (SMALL_TRIES + 1) * PARTS, "rounding");
}

/* Encodes by a step: the error in all, of rounding alone where the grid's own is not known, or the bytes. */
static ylm_status try_step(void *self, double step, double *found) {
  search *s = self;
  ylm_status status = ylm__small_round(s->k, (float)step, say, s);
  s->tried++;
  if (status == YLM_OK) status = judge(s);
  if (status != YLM_OK) return status;
  const small_packed *p = ylm__small_packed_of(s->k);
  *found = s->how->bytes            ? (double)s->size(ylm__small_grid_of(s->k), p)
           : isnan(p->report.error) ? p->report.largest
                                    : p->report.error;
  return YLM_OK;
}

static ylm_status not_to_be_had(const search *s) {
  const ylm_grid_small_report *r = &ylm__small_packed_of(s->k)->report;
  if (s->how->bytes)
    return ylm_fail(
        s->e, YLM_ELIMIT,
        "bytes: this grid takes %zu at the coarsest step of rounding, and %llu are asked for",
        (size_t)s->size(ylm__small_grid_of(s->k), ylm__small_packed_of(s->k)),
        (unsigned long long)s->how->bytes);
  return ylm_fail(s->e, YLM_ELIMIT,
                  "tolerance: the grid errs by %.3g before any rounding, %g is asked for in all: "
                  "bake it to a smaller tolerance, or "
                  "save it to a larger one",
                  r->before, s->how->tolerance);
}

static ylm_status look_for_step(search *s) {
  double step = s->how->step, found;
  if (step > 0) return try_step(s, step, &found);
  small_hunt h = {.how = s->how,
                  .before = s->from->stats.error,
                  .judged = s->judge != NULL,
                  .width = s->from->width,
                  .round = try_step,
                  .self = s};
  ylm_status status = ylm__small_hunt(&h, &step);
  return status == YLM_ELIMIT ? not_to_be_had(s) : status;
}

ylm_status ylm__small_search(small_encoder *k, const ylm_grid *from, const ylm_grid_small *how,
                             small_size_fn *size, ylm_error *e) {
  search s = {.k = k, .from = from, .how = how, .size = size, .e = e, .n = PLACES};
  if (from->panel && from->panel->points.n) s.judge = &from->panel->points;
  ylm_status status = take_places(&s);
  s.before = ylm_alloc(s.n, from->width * sizeof *s.before);
  s.error = ylm_alloc(s.n, sizeof *s.error);
  s.total = ylm_alloc(s.n, sizeof *s.total);
  if (status == YLM_OK && !(s.before && s.error && s.total)) status = YLM_ENOMEM;
  if (status == YLM_OK) status = sample(&s, from, s.before);
  if (status == YLM_OK) {
    if (s.judge)
      s.m = from->panel->measure;
    else
      find_means(&s);
    status = look_for_step(&s);
  }
  forget(&s);
  return status;
}

ylm_status ylm__small_roundings(small_encoder *k, const ylm_grid *from, int threads, size_t n,
                                double *error, ylm_error *e) {
  return ylm__small_errors(from, ylm__small_grid_of(k), threads, n, error, e);
}

ylm_status ylm__small_errors(const ylm_grid *from, const ylm_grid *to, int threads, size_t n,
                             double *error, ylm_error *e) {
  search s = {.from = from, .how = &(ylm_grid_small){.threads = threads}, .e = e, .n = n};
  ylm_status status = draw_places(&s);
  s.before = ylm_alloc(n, from->width * sizeof *s.before);
  float *value = ylm_alloc(n, from->width * sizeof *value);
  if (status == YLM_OK && !(s.before && value)) status = YLM_ENOMEM;
  if (status == YLM_OK) status = sample(&s, from, s.before);
  if (status == YLM_OK) status = sample(&s, to, value);
  if (status == YLM_OK) find_means(&s);
  for (size_t i = 0; status == YLM_OK && i < n; i++) {
    double x = error_at(&s, i, value + i * from->width, s.before + i * from->width);
    error[i] = isnan(x) ? INFINITY : x;
  }
  ylm_free(value);
  forget(&s);
  if (status == YLM_OK) ylm__small_sort(error, n);
  return status;
}
