/* dynamic.c - the state that updates need: made by the bake, kept per point. */
#include "dynamic.h"

#include <math.h>
#include <string.h>

/* -- bounds of a light's field ----------------------------------------------------------- */

static double squares(const double *x, size_t n) {
  double s = 0;
  for (size_t i = 0; i < n; i++) s += x[i] * x[i];
  return s;
}

/* The square of the norm of Hessians xx xy xz yy yz zz, or of a difference of two sets. */
static double hessian_squares(const double *a, const double *b, size_t n) {
  double s = 0;
  for (size_t i = 0; i < 6 * n; i++) {
    double x = a[i] - (b ? b[i] : 0);
    s += (i % 6 == 1 || i % 6 == 2 || i % 6 == 4 ? 2 : 1) * x * x;
  }
  return s;
}

/*
** Measures the norms of value and derivatives of a light of radius 1 at distances from NEAR on and
** scales them: s = r/d alone decides, and smoothly. Norms over all orders do not depend on the
** direction.
*/
static ylm_status measure_bounds(int lmax, double bound[4], ylm_error *e) {
  enum { DISTANCES = 7, POINTS = 7 };
  static const double far[DISTANCES] = {NEAR, 3.5, 4.5, 6.5, 12, 40, 400};
  static const double way[3] = {0.36, 0.48, 0.8}, at[3] = {0}, radius = 1, radiance[3] = {1, 1, 1};
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  ylm_lights *one = NULL;
  double *v = ylm_alloc(POINTS * count, sizeof *v), *g = ylm_alloc(POINTS * count, 3 * sizeof *g),
         *h = ylm_alloc(POINTS * count, 6 * sizeof *h), x[POINTS][3];
  ylm_status s = v && g && h ? ylm_lights_create(1, at, &radius, radiance, &one, e) : YLM_ENOMEM;
  for (int k = 0; k < 4; k++) bound[k] = 0;
  for (int i = 0; s == YLM_OK && i < DISTANCES; i++) {
    double d = far[i], step = 1e-4 * d, third = 0;
    for (int p = 0; p < POINTS; p++)
      for (int a = 0; a < 3; a++)
        x[p][a] = d * way[a] + (p > 0 && (p - 1) / 2 == a ? (p & 1 ? step : -step) : 0);
    ylm_field_query q = {.lmax = lmax,
                         .channels = 1,
                         .metric_channels = 1,
                         .dtype = YLM_DOUBLE,
                         .threads = 1,
                         .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_HESSIAN};
    ylm_field_result r = {.value = v, .gradient = g, .hessian = h};
    const ylm_field *f = ylm_lights_field(one);
    s = f->evaluate(f, &q, POINTS, x, &r, e);
    for (size_t a = 0; a < 3; a++)
      third += hessian_squares(h + (1 + 2 * a) * 6 * count, h + (2 + 2 * a) * 6 * count, count);
    double norm[4] = {squares(v, count), squares(g, 3 * count), hessian_squares(h, NULL, count),
                      third / (4 * step * step)};
    for (int k = 0; k < 4; k++) bound[k] = fmax(bound[k], 1.1 * sqrt(norm[k]) * pow(d, k + 2));
  }
  ylm_lights_free(one);
  ylm_free(v);
  ylm_free(g);
  ylm_free(h);
  return s;
}

/* -- making ------------------------------------------------------------------------------- */

ylm_status ylm__dynamic_begin(ylm_grid *g, const ylm_grid_source *source, ylm_error *e) {
  grid_dynamic *d = g->dynamic = ylm_alloc_zero(1, sizeof *d);
  if (!d) return YLM_ENOMEM;
  size_t bytes = source->occupied * 3 * ylm_dtype_size(source->occupied_dtype);
  d->lamps = ylm_lights_count(source->lights);
  d->lamp = ylm__lamps(source->lights);
  d->mover_of = ylm_alloc(d->lamps, sizeof *d->mover_of);
  d->source = *source;
  d->source.field = NULL;
  d->source.lights = NULL;
  d->source.progress = NULL;
  if (source->occupied_points) {
    d->occupied_points = ylm_alloc_copy(source->occupied_points, bytes, 1);
    if (!d->occupied_points) return YLM_ENOMEM;
  }
  d->source.occupied_points = d->occupied_points;
  if (!d->lamp || !d->mover_of) return YLM_ENOMEM;
  for (size_t i = 0; i < d->lamps; i++) d->mover_of[i] = -1;
  d->bends = 6 * (size_t)g->view.count * (size_t)g->view.form.metric_channels;
  return measure_bounds(g->view.form.lmax, d->bound, e);
}

ylm_status ylm__dynamic_end(ylm_grid *g, occupancy *occupied) {
  g->dynamic->occupied = *occupied;
  *occupied = (occupancy){0};
  ylm__dynamic_sign_all(g, g->dynamic->source.threads);
  g->stats.bytes += ylm__dynamic_bytes(g->dynamic);
  return YLM_OK;
}

void ylm__dynamic_free(grid_dynamic *d) {
  if (!d) return;
  for (size_t m = 0; m < d->movers; m++) ylm_free(d->mover[m].seen);
  ylm_free(d->mover);
  ylm_free(d->lamp);
  ylm_free(d->mover_of);
  ylm_free(d->hessian);
  ylm_free(d->size);
  ylm_free(d->drift);
  ylm_free(d->sign);
  ylm_free(d->born_sign);
  ylm_free(d->cell_sign);
  ylm_free(d->occupied_points);
  ylm_regrow_free(d->log, d->log_bytes);
  ylm_free(d->spare);
  occupancy_free(&d->occupied);
  lattice_hash_free(&d->forced);
  ylm_free(d);
}

size_t ylm__dynamic_bytes(const grid_dynamic *d) {
  if (!d) return 0;
  return sizeof *d + d->lamps * (sizeof *d->lamp + sizeof *d->mover_of) +
         d->movers * (sizeof *d->mover + d->room) +
         d->room * ((d->bends + 2) * sizeof(float) + sizeof *d->sign) +
         (d->born_room + d->cell_room) * sizeof *d->sign +
         d->source.occupied * 3 * ylm_dtype_size(d->source.occupied_dtype) + d->log_bytes +
         d->spare_room * sizeof *d->spare;
}
