/* residual.c - what interpolation misses at the centres of voxels, and what that says of others. */
#include "tolerance.h"

#include <math.h>
#include <string.h>

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

/* -- estimates ------------------------------------------------------------------------- */

/* The square of the relative metric, that of norms in the dark at least the mean of occupied points
   where irradiance is measured. */
static double metric_squared(const refiner *r, const ylm_grid_cell *c) {
  bool known = r->b->g->contents.form.metric == YLM_GRID_RELATIVE;
  if (r->side) {
    double e = ylm__metric_above(r->b, c, r->b->measure.norm);
    return e * e;
  }
  if (r->b->measure.floor > 0) {
    double e = ylm__metric_above(r->b, c, r->b->measure.floor);
    return e * e;
  }
  double e = (double)(known ? c->error : ylm__metric_of(r->b, c, YLM_GRID_RELATIVE));
  return e * e;
}

void ylm__residual_learn(refiner *r) {
  r->trusted = r->ratio.n >= FEW_RATIOS;
  r->median = ratios_quantile(&r->ratio, MEDIAN_RATIO);
  r->high = ratios_quantile(&r->ratio, HIGH_RATIO);
}

/* The error that a cell may have. */
double ylm__residual_estimate(const refiner *r, const ylm_grid_cell *c) {
  if (!isnan(c->residual)) return (double)c->residual;
  double e2 = metric_squared(r, c);
  return r->trusted ? r->median * e2 : sqrt(e2);
}

/* True if a measurement may change what happens to a cell. */
bool ylm__residual_wanted(const refiner *r, const ylm_grid_cell *c) {
  if (c->level >= r->b->g->contents.form.depth || c->flags & YLM_GRID_CROSSED) return false;
  if (!isnan(c->residual)) return false;
  double e2 = metric_squared(r, c);
  double high = r->trusted ? r->high * e2 : sqrt(e2);
  return high * r->tight > r->tolerance;
}

/* Takes the residual of the cell that was in the same place, if nothing that it depends on
   changed. */
static bool take_residual(const baker *b, ylm_grid_cell *c, uint32_t centre) {
  const ylm_grid_cell *old = cells_before(b, c);
  if (!old || isnan(old->residual) || b->changed[centre]) return false;
  for (int k = 0; k < 8; k++)
    if (b->changed[c->corner[k]]) return false;
  c->residual = old->residual;
  return true;
}

/* The cells of r->tested whose interpolants are to be compared with their centres; in updates
   others have their residuals, and leave the list. */
static size_t list_probes(refiner *r, ylm_grid_probe *probe) {
  baker *b = r->b;
  size_t n = 0;
  for (size_t i = 0; i < r->tested.n; i++) {
    ylm_grid_cell *c = &b->g->cell[r->tested.cell[i]];
    uint32_t centre = r->centre.cell[i];
    if (take_residual(b, c, centre)) continue;
    r->tested.cell[n] = r->tested.cell[i];
    probe[n++] = ylm__held_probe(b->g, c, (const float[3]){0.5f, 0.5f, 0.5f}, centre);
  }
  return n;
}

/* Errors of interpolants at the centres of the cells in r->tested, which are evaluated. */
static ylm_status find_residuals(refiner *r) {
  size_t n = r->tested.n;
  ylm_grid_probe *probe = ylm_alloc(n, sizeof *probe);
  double *distance = ylm_alloc(n, sizeof *distance);
  ylm_status s = probe && distance ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) r->tested.n = list_probes(r, probe);
  if (s == YLM_OK) s = ylm__backend_residuals(r->b, r->tested.n, probe, NULL, distance);
  for (size_t i = 0; s == YLM_OK && i < r->tested.n; i++)
    r->b->g->cell[r->tested.cell[i]].residual = (float)distance[i];
  ylm_free(probe);
  ylm_free(distance);
  return s;
}

/* Points at the centres of the cells in r->tested. */
static ylm_status find_centres(refiner *r) {
  const ylm_grid *g = r->b->g;
  ylm_status s = YLM_OK;
  r->centre.n = 0;
  for (size_t i = 0; i < r->tested.n && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &g->cell[r->tested.cell[i]];
    uint32_t half = ylm__grid_edge(g, c) / 2, at[3], point;
    for (int a = 0; a < 3; a++) at[a] = c->origin[a] + half;
    s = ylm__corners_point(r->b, at, YLM_GRID_POINT_TESTED, &point);
    if (s == YLM_OK) s = ylm__cell_list_push(&r->centre, point);
  }
  return s;
}

ylm_status ylm__residual_measure(refiner *r) {
  ylm_grid *g = r->b->g;
  double t = ylm_seconds();
  ylm_status s = find_centres(r);
  g->stats.lattice_seconds += ylm_seconds() - t;
  if (s == YLM_OK) s = ylm__backend_evaluate(r->b, g->points - g->evaluated);
  t = ylm_seconds();
  if (s == YLM_OK && r->tested.n) s = find_residuals(r);
  for (size_t i = 0; i < r->tested.n && s == YLM_OK && !r->frozen; i++) {
    const ylm_grid_cell *c = &g->cell[r->tested.cell[i]];
    double e2 = metric_squared(r, c);
    if (e2 > 0 && isfinite(e2)) ratios_add(&r->ratio, (double)c->residual / e2);
  }
  ylm__residual_learn(r);
  g->stats.residual_seconds += ylm_seconds() - t;
  r->tested.n = 0;
  return s;
}
