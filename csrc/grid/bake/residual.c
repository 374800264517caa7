/* residual.c - what interpolation misses at the centres of voxels, and what that says of others. */
#include "tolerance.h"

#include <math.h>
#include <string.h>

#define FEW 32 /* ratios before kappa is trusted */

static void ratios_add(ratios *r, double x) {
  int k = x > 0 ? (int)(2 * log2(x)) + 128 : 0;
  r->count[k < 0 ? 0 : k > 255 ? 255 : k]++;
  r->n++;
}

/* The value that a fraction q of the ratios does not exceed. */
static double ratios_quantile(const ratios *r, double q) {
  uint64_t sum = 0, wanted = (uint64_t)ceil(q * (double)r->n);
  int k = 0;
  while (k < 255 && (sum += r->count[k]) < wanted) k++;
  return exp2(0.5 * (k + 1 - 128));
}

/* Relative distance of two rows; 0 where both vanish. */
double refiner_distance(const float *a, const float *exact, size_t width) {
  double d = 0, n = 0;
  for (size_t j = 0; j < width; j++) {
    double x = (double)a[j] - (double)exact[j];
    d += x * x;
    n += (double)exact[j] * (double)exact[j];
  }
  return relative_distance(d, n);
}

/* -- estimates ------------------------------------------------------------------------- */

static double metric_squared(const refiner *r, const ylm_grid_cell *c) {
  bool known = r->b->g->view.form.metric == YLM_GRID_RELATIVE;
  double e = (double)(known ? c->error : baker_metric(r->b, c, YLM_GRID_RELATIVE));
  return e * e;
}

void refiner_learn(refiner *r) {
  r->trusted = r->ratio.n >= FEW;
  r->median = ratios_quantile(&r->ratio, 0.5);
  r->high = ratios_quantile(&r->ratio, 0.98);
}

/* The error that a cell may have. */
double refiner_estimate(const refiner *r, const ylm_grid_cell *c) {
  if (!isnan(c->residual)) return (double)c->residual;
  double e2 = metric_squared(r, c);
  return r->trusted ? r->median * e2 : sqrt(e2);
}

/* True if a measurement may change what happens to a cell. */
bool refiner_wants_test(const refiner *r, const ylm_grid_cell *c) {
  if (c->level >= r->b->g->view.form.depth || c->flags & YLM_GRID_CROSSED) return false;
  if (!isnan(c->residual)) return false;
  double e2 = metric_squared(r, c);
  double high = r->trusted ? r->high * e2 : sqrt(e2);
  return high * r->tight > r->tolerance;
}

/* Takes the residual of the cell that was in the same place, if nothing that it depends on changed.
 */
static bool take_residual(const baker *b, ylm_grid_cell *c, uint32_t centre) {
  const ylm_grid_cell *old = baker_before(b, c);
  if (!old || isnan(old->residual) || b->changed[centre]) return false;
  for (int k = 0; k < 8; k++)
    if (b->changed[c->corner[k]]) return false;
  c->residual = old->residual;
  return true;
}

/* Residuals of the cells begin .. end-1 of r->tested, whose centres are in r->centre. */
static ylm_status find_residuals(void *context, size_t begin, size_t end, int worker) {
  const refiner *r = context;
  const baker *b = r->b;
  const ylm_grid *g = b->g;
  float *row = r->row + (size_t)worker * (g->stride + ROW_PADDING);
  for (size_t i = begin; i < end; i++) {
    ylm_grid_cell *c = &g->cell[r->tested.cell[i]];
    uint32_t centre = r->centre.cell[i];
    if (take_residual(b, c, centre)) {
      r->centre.cell[i] = YLM_GRID_NONE;
      continue;
    }
    ylm__grid_interpolate(g, c, (const float[3]){0.5f, 0.5f, 0.5f}, row, NULL);
    c->residual = (float)refiner_distance(row, ylm__grid_row(g, centre, 0), g->width);
  }
  return YLM_OK;
}

/* The same of all of r->tested, where rows are kept elsewhere. */
static ylm_status ask_residuals(refiner *r) {
  baker *b = r->b;
  size_t n = r->tested.n;
  ylm_grid_probe *probe = ylm_alloc(n, sizeof *probe);
  float *distance = ylm_alloc(n, sizeof *distance);
  ylm_status s = probe && distance ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    probe[i] = baker_probe(b, &b->g->cell[r->tested.cell[i]], (const float[3]){0.5f, 0.5f, 0.5f},
                           r->centre.cell[i]);
  if (s == YLM_OK && n) s = keeper_residuals(b, n, probe, distance);
  for (size_t i = 0; s == YLM_OK && b->keeper && i < n; i++)
    b->g->cell[r->tested.cell[i]].residual = distance[i];
  ylm_free(probe);
  ylm_free(distance);
  return s;
}

/* Evaluates the centres of the cells in r->tested and keeps what the interpolant misses there. */
ylm_status refiner_measure(refiner *r) {
  baker *b = r->b;
  ylm_grid *g = b->g;
  ylm_status s = YLM_OK;
  double t = ylm_seconds();
  r->centre.n = 0;
  for (size_t i = 0; i < r->tested.n && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[r->tested.cell[i]];
    uint32_t half = ylm__grid_edge(g, c) / 2, at[3], point;
    for (int a = 0; a < 3; a++) at[a] = c->origin[a] + half;
    s = baker_point(b, at, YLM_GRID_POINT_TESTED, &point);
    if (s == YLM_OK) s = cell_list_push(&r->centre, point);
  }
  g->stats.lattice_seconds += ylm_seconds() - t;
  if (s == YLM_OK) s = baker_evaluate(b);
  t = ylm_seconds();
  if (s == YLM_OK && b->keeper) s = ask_residuals(r);
  if (s == YLM_OK && !b->keeper)
    s = ylm_parallel(r->tested.n, 64, b->source->threads, find_residuals, r, NULL, NULL);
  for (size_t i = 0; i < r->tested.n && s == YLM_OK && !r->frozen; i++) {
    if (r->centre.cell[i] == YLM_GRID_NONE) continue;
    const ylm_grid_cell *c = &g->cell[r->tested.cell[i]];
    double e2 = metric_squared(r, c);
    if (e2 > 0 && isfinite(e2)) ratios_add(&r->ratio, (double)c->residual / e2);
  }
  refiner_learn(r);
  g->stats.residual_seconds += ylm_seconds() - t;
  r->tested.n = 0;
  return s;
}
