/* finite.c - results that are too large for their type are an error that names the point. */
#include "finite.h"

#include <float.h>
#include <math.h>

/* ylm_light_beyond for points relative to an origin; NULL: to 0. */
static ylm_status beyond(const char *what, ylm_dtype t, size_t point, const void *points,
                         const double *origin, ylm_error *e) {
  double x[3];
  for (size_t a = 0; a < 3; a++)
    x[a] = ylm_get(t, points, 3 * point + a) + (origin ? origin[a] : 0);
  return ylm_fail(e, YLM_ERANGE, "%s at point %zu, (%g, %g, %g), is beyond the range of %s", what,
                  point + 1, x[0], x[1], x[2], t == YLM_DOUBLE ? "double" : "float");
}

ylm_status ylm_light_beyond(const char *what, ylm_dtype t, size_t point, const void *points,
                            ylm_error *e) {
  return beyond(what, t, point, points, NULL, e);
}

/* Of n points with `wide` numbers each: YLM_ERANGE where one is not finite. */
static ylm_status look(const ylm_field_query *q, const char *what, size_t n, size_t wide,
                       const void *points, const void *x, ylm_error *e) {
  size_t where;
  if (!x || ylm_all_finite(q->dtype, x, n * wide, &where)) return YLM_OK;
  return beyond(what, q->dtype, where / wide, points, q->origin, e);
}

void ylm_light_saturate(ylm_dtype t, size_t n, void *x) {
  if (!x || ylm_all_finite(t, x, n, NULL)) return;
  for (size_t i = 0; i < n; i++)
    if (isinf(ylm_get(t, x, i))) ylm_put(t, x, i, t == YLM_DOUBLE ? DBL_MAX : (double)FLT_MAX);
}

static ylm_status look_at_metric(const ylm_field_query *q, size_t n, const void *points,
                                 const ylm_field_result *r, ylm_error *e) {
  if (!(q->want & YLM_WANT_METRIC)) return YLM_OK;
  ylm_light_saturate(q->dtype, n, r->lambda);
  ylm_light_saturate(q->dtype, n, r->norm);
  ylm_status s = look(q, "the metric's lambda", n, 1, points, r->lambda, e);
  return s == YLM_OK ? look(q, "the light field's norm", n, 1, points, r->norm, e) : s;
}

static ylm_status look_at_field(const ylm_field_query *q, size_t n, const void *points,
                                const ylm_field_result *r, ylm_error *e) {
  size_t wide = (size_t)q->channels * (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1);
  ylm_status s = YLM_OK;
  if (q->want & YLM_WANT_VALUE) s = look(q, "the light field", n, wide, points, r->value, e);
  if (s == YLM_OK && q->want & YLM_WANT_GRADIENT)
    s = look(q, "the light field's gradient", n, 3 * wide, points, r->gradient, e);
  if (s == YLM_OK && q->want & YLM_WANT_HESSIAN)
    s = look(q, "the light field's Hessian", n, 6 * wide, points, r->hessian, e);
  return s;
}

ylm_status ylm_light_finite(const ylm_field_query *q, size_t n, const void *points,
                            const ylm_field_result *r, ylm_error *e) {
  ylm_status s = look_at_field(q, n, points, r, e);
  return s == YLM_OK ? look_at_metric(q, n, points, r, e) : s;
}

/*
** Sums over lights are at most sqrt(4pi) times their radiances. Each derivative multiplies that by
** (lmax + 2)/h at most, h^2 = d^2 - r^2. The kernels' h is at least NEAREST r: they square r before
** they round. ROOM is for the factors that kernels put in last.
*/
#define NEAREST_FLOAT 1e-8
#define NEAREST_DOUBLE 1e-16
#define ROOM 1e-14
/* Radii whose squares are ordinary numbers. */
#define SMALL_FLOAT 1e-15
#define SMALL_DOUBLE 1e-150

static bool bounded(const ylm_lights *l, const ylm_field_query *q) {
  bool wide = q->dtype == YLM_DOUBLE;
  double most = ROOM * (wide ? DBL_MAX : (double)FLT_MAX), size = 0, least = INFINITY;
  for (size_t i = 0; i < l->active; i++) {
    const ylm__lamp_d *d = &l->lamp_d[i];
    size += fmax(fabs(d->rgb[0]), fmax(fabs(d->rgb[1]), fabs(d->rgb[2])));
    least = fmin(least, d->radius);
  }
  double slope = fmax(1, (q->lmax + 2) / ((wide ? NEAREST_DOUBLE : NEAREST_FLOAT) * least));
  if (q->want & (YLM_WANT_GRADIENT | YLM_WANT_HESSIAN)) size *= slope;
  if (q->want & YLM_WANT_HESSIAN) size *= slope;
  return size <= most && least >= (wide ? SMALL_DOUBLE : SMALL_FLOAT);
}

ylm_status ylm__lights_finite(const ylm_lights *lights, const ylm_field_query *q, size_t n,
                              const void *points, const ylm_field_result *r, ylm_error *e) {
  bool many = n > lights->active / 8; /* more than the lights, to look at */
  if (!many || !bounded(lights, q)) return ylm_light_finite(q, n, points, r, e);
  return look_at_metric(q, n, points, r, e);
}
