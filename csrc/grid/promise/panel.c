/*
** panel.c - random occupied points with their exact light, which judge whether a promise is kept.
**
** Refinement stops where few of its held-out points fail; these have decided when it stops, so they
** say too little. The points of a panel decide nothing. Of a grid in which more than 1 % of all
** occupied points fail, they say that it keeps its tolerance with a chance of at most 1 %.
*/
#include <stdlib.h>
#include <string.h>

#include "tolerance.h"
#include "ylm_list.h"

/* By the binomial distribution: exact (Clopper and Pearson 1934). */
int ylm__confidence_allowed(size_t n, double share, double doubt) {
  double term = exp((double)n * log1p(-share)), sum = term;
  int k = -1;
  while (sum <= doubt && (size_t)(k + 1) < n) {
    k++;
    term *= (double)(n - (size_t)k) / (double)(k + 1) * (share / (1 - share));
    sum += term;
  }
  return k;
}

/* -- arrays --------------------------------------------------------------------------------- */

void ylm__panel_free(panel *p) {
  ylm_free(p->point);
  ylm_free(p->exact);
  ylm_free(p->drift);
  ylm_free(p->inside);
  ylm_free(p->side);
  ylm_free(p->sampled);
  ylm_grid_track_free(p->track);
  *p = (panel){0};
}

void ylm__grid_forget_panel(ylm_grid *g) {
  if (g->panel) ylm__panel_free(&g->panel->points);
  ylm_free(g->panel);
  g->panel = NULL;
}

/* Bytes of a panel that a grid keeps, at most. */
#define KEPT_MOST ((size_t)1 << 24)

/* The panel becomes the grid's, which has none; one that is too large does not. */
static ylm_status keep_panel(const refiner *r, panel *p) {
  if (ylm__panel_bytes(p, r->b->g->width) > KEPT_MOST) return YLM_OK;
  grid_panel *kept = ylm_alloc(1, sizeof *kept);
  if (!kept) return YLM_ENOMEM;
  *kept = (grid_panel){*p, r->b->measure};
  r->b->g->panel = kept;
  *p = (panel){0};
  return YLM_OK;
}

size_t ylm__panel_bytes(const panel *p, size_t width) {
  size_t kept = p->sampled ? width * sizeof *p->sampled + 16 : 0; /* 16: of the track */
  return p->n * (3 * sizeof *p->point + width * sizeof *p->exact + sizeof *p->drift + 1 + kept);
}

ylm_status ylm__panel_copy_light(panel *to, const panel *from, size_t width) {
  *to = *from;
  to->exact = ylm_alloc_copy(from->exact, from->n, width * sizeof *to->exact);
  to->drift = ylm_alloc_copy(from->drift, from->n, sizeof *to->drift);
  to->inside = ylm_alloc_copy(from->inside, from->n, 1);
  return to->exact && to->drift && to->inside ? YLM_OK : YLM_ENOMEM;
}

void ylm__panel_forget_light(panel *p) {
  ylm_free(p->exact);
  ylm_free(p->drift);
  ylm_free(p->inside);
  *p = (panel){0};
}

void ylm__panel_exchange(panel *a, panel *b) {
  panel was = *a;
  *a = *b;
  *b = was;
}

/* Room for the arrays of n points; what is there stays. */
static ylm_status reserve(panel *p, size_t n, size_t width) {
  return ylm_list_resize(&p->point, p->n, n, 3 * sizeof *p->point) &&
                 ylm_list_resize(&p->exact, p->n, n, width * sizeof *p->exact) &&
                 ylm_list_resize(&p->drift, p->n, n, sizeof *p->drift) &&
                 ylm_list_resize(&p->inside, p->n, n, 1)
             ? YLM_OK
             : YLM_ENOMEM;
}

/* -- rulings -------------------------------------------------------------------------------- */

/* The most failures with which the promise is kept; -1: it cannot be said. */
static int most_failures(const panel *p, size_t points, double doubt) {
  return p->all ? (int)(PROMISED * (double)points)
                : ylm__confidence_allowed(points, PROMISED, doubt);
}

/* Sorts x into the n largest numbers so far, largest first. */
static void sort_in(double *largest, size_t n, double x) {
  if (!(x > largest[n - 1])) return;
  size_t i = n - 1;
  for (; i > 0 && largest[i - 1] < x; i--) largest[i] = largest[i - 1];
  largest[i] = x;
}

ylm_status ylm__panel_rule(const panel *p, const double *error, double tolerance, double doubt,
                           ruling *out) {
  *out = (ruling){.met = true};
  for (size_t i = 0; i < p->n; i++) {
    out->points += error[i] >= 0;
    out->failed += error[i] > tolerance;
  }
  if (!out->points) return YLM_OK;
  int most = most_failures(p, out->points, doubt);
  size_t n = most < 0 ? 1 : (size_t)most + 1;
  double *largest = ylm_alloc_zero(n, sizeof *largest);
  if (!largest) return YLM_ENOMEM;
  for (size_t i = 0; i < p->n; i++) sort_in(largest, n, error[i]);
  out->error = most < 0 ? INFINITY : largest[n - 1];
  out->largest = largest[0];
  out->met = out->error <= tolerance;
  ylm_free(largest);
  return YLM_OK;
}

double ylm__panel_error(const panel *p, size_t i, const float *sample, size_t width, double floor) {
  if (p->inside[i]) return -1;
  double error = ylm__row_distance(sample, p->exact + i * width, width, floor);
  return isnan(error) ? INFINITY : error;
}

/* The errors of samples of a finished grid. */
static void sample_errors(const ylm_grid *g, const panel *p, const float *sampled, double *error) {
  size_t w = g->width;
  for (size_t i = 0; i < p->n; i++)
    error[i] = ylm__panel_error(p, i, sampled + i * w, w, g->contents.form.floor);
}

ylm_status ylm__panel_rule_samples(const ylm_grid *g, const panel *p, const float *sampled,
                                   double doubt, ruling *out) {
  double *error = ylm_alloc(p->n, sizeof *error);
  if (!error) return YLM_ENOMEM;
  sample_errors(g, p, sampled, error);
  ylm_status s = ylm__panel_rule(p, error, g->contents.form.tolerance, doubt, out);
  ylm_free(error);
  return s;
}

ylm_status ylm__panel_errors(const refiner *r, const panel *p, const ylm_grid_walls *walls,
                             double *error) {
  if (p->side) return ylm__sides_errors(r, p, error);
  const ylm_grid *g = r->b->g;
  ylm_grid_query q = {.point_dtype = YLM_FLOAT,
                      .dtype = YLM_FLOAT,
                      .threads = r->b->source->threads,
                      .origin = ylm__grid_origin(g),
                      .walls = walls};
  float *value = ylm_alloc(p->n, g->width * sizeof *value);
  ylm_status s = value ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && r->sample)
    s = r->sample(r->sampled, &q, p->n, p->point, value, r->b->e);
  else if (s == YLM_OK)
    s = ylm_grid_sample(g, &q, p->n, p->point, value, NULL, NULL, r->b->e);
  if (s == YLM_OK) sample_errors(g, p, value, error);
  ylm_free(value);
  return s;
}

/* Judges a finished grid. */
static ylm_status rule_finished(const refiner *r, const panel *p, double doubt, ruling *out) {
  double *error = ylm_alloc(p->n, sizeof *error);
  ylm_status s = error ? ylm__panel_errors(r, p, NULL, error) : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__panel_rule(p, error, r->b->g->contents.form.tolerance, doubt, out);
  for (size_t i = 0; s == YLM_OK && !out->points && i < p->n; i++)
    if (!p->inside[i])
      out->met = false, out->error = INFINITY; /* all are looked up out of the bounds */
  ylm_free(error);
  return s;
}

void ylm__panel_report(ylm_grid_stats *s, const panel *p, const ruling *r, bool limited) {
  s->verified = r->points;
  s->error = r->error;
  s->largest_error = r->largest;
  s->met = r->met;
  s->failed = r->failed;
  s->limited = !r->met && limited;
  s->confidence = p->all ? 1 : 1 - DOUBT;
}

/* -- of a bake ------------------------------------------------------------------------------ */

ylm_status ylm__panel_take(const refiner *r, panel *p) {
  size_t w = r->b->g->width, n = r->held;
  ylm_status s = reserve(p, p->n + n, w);
  if (s == YLM_OK && r->side) {
    size_t row = 3 * sizeof *p->side;
    if (!ylm_list_resize(&p->side, p->n, p->n + n, row)) return YLM_ENOMEM;
    ylm_copy(p->side + 3 * p->n, r->side, n * row);
  }
  if (s != YLM_OK) return s;
  ylm_copy(p->point + 3 * p->n, r->points, 3 * n * sizeof *p->point);
  ylm_copy(p->exact + w * p->n, r->exact, w * n * sizeof *p->exact);
  ylm_copy(p->inside + p->n, r->inside, n);
  memset(p->drift + p->n, 0, n * sizeof *p->drift);
  p->n += n;
  return YLM_OK;
}

/* Fresh points join the panel until it has had `batches` of them. */
static ylm_status draw(refiner *r, panel *p, size_t *had, size_t batches) {
  ylm_status s = YLM_OK;
  for (; *had < batches && s == YLM_OK; ++*had) {
    s = ylm__verify(r, MAX_ROUNDS + 1 + *had);
    if (s == YLM_OK) s = ylm__panel_take(r, p);
  }
  return s;
}

/* True if more points may show that the promise is kept. */
static bool is_open(const ruling *r) {
  double expected = PROMISED * (double)r->points;
  return !r->met && (double)r->failed <= expected + 2 * sqrt(expected);
}

/* The first places of a panel are kept for another judge. */
static ylm_status keep_judges(ylm_grid *g, const panel *p) {
  size_t n = p->n < HELD_OUT ? p->n : HELD_OUT;
  g->judge = ylm_alloc(n ? n : 1, sizeof *g->judge);
  if (!g->judge) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    if (p->inside[i]) continue;
    memcpy(g->judge[g->judges], p->point + 3 * i, 3 * sizeof(float));
    memcpy(g->judge[g->judges++] + 3, p->side + 3 * i, 3 * sizeof(float));
  }
  return YLM_OK;
}

size_t ylm_grid_judges(const ylm_grid *g, double (*rows)[6]) {
  for (size_t i = 0; rows && i < g->judges; i++)
    for (int k = 0; k < 6; k++) rows[i][k] = (double)g->judge[i][k] + (k < 3 ? g->origin[k] : 0);
  return g->judges;
}

void ylm_grid_verdict(ylm_grid *g, uint64_t verified, uint64_t failed, double error,
                      double largest) {
  ylm_grid_stats *s = &g->stats;
  s->verified = verified;
  s->failed = failed;
  s->error = error;
  s->largest_error = largest;
  s->met = error <= g->contents.form.tolerance;
  s->limited &= !s->met;
  s->spent &= !s->met;
}

int ylm_grid_allowed(size_t n) {
  const size_t most = 1 << 20; /* of more places, those of so many: they are found one by one */
  return ylm__confidence_allowed(n < most ? n : most, PROMISED, DOUBT);
}

ylm_status ylm__panel_judge(refiner *r, bool limited) {
  ylm_grid *g = r->b->g;
  panel p = {.all = r->all};
  ruling said = {0};
  size_t had = 0;
  ylm_status s = p.all ? ylm__panel_take(r, &p) : YLM_OK;
  for (int look = 0; look < LOOKS && s == YLM_OK; look++) {
    if (!p.all) s = draw(r, &p, &had, (size_t)1 << look);
    double t = ylm_seconds();
    if (s == YLM_OK) s = rule_finished(r, &p, DOUBT / LOOKS, &said);
    g->stats.verify_seconds += ylm_seconds() - t;
    if (p.all || !is_open(&said)) break;
  }
  if (s == YLM_OK && g->follower && !p.all) s = draw(r, &p, &had, PANEL / HELD_OUT);
  if (s == YLM_OK) ylm__panel_report(&g->stats, &p, &said, limited);
  if (s == YLM_OK && g->contents.form.sides && p.side) s = keep_judges(g, &p);
  if (s == YLM_OK && !g->follower && !g->contents.form.sides) s = keep_panel(r, &p);
  if (s == YLM_OK && g->follower)
    r->b->learnt.panel = p;
  else
    ylm__panel_free(&p);
  return s;
}
