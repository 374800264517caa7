/* field.c - light fields: the check of a query; far from 0 origins, and fields that do not know them. */
#include <math.h>

#include "ylm_base.h"

/* Squares of coordinates stay numbers of float. */
#define FARTHEST 1e15

ylm_status ylm_field_check(const ylm_field_query *q, size_t n, const void *points,
                           const ylm_field_result *r, int most, const char *what, ylm_error *e) {
  size_t where;
  if (q->lmax < 0 || q->lmax > most)
    return ylm_fail(e, YLM_ERANGE, "lmax must be 0 .. %d for %s, got %d", most, what, q->lmax);
  if (q->channels != 1 && q->channels != 3)
    return ylm_fail(e, YLM_EINVAL, "channels must be 1 or 3, got %d", q->channels);
  if ((q->want & YLM_WANT_METRIC) && q->metric_channels != 1 && q->metric_channels != 3)
    return ylm_fail(e, YLM_EINVAL, "metric_channels must be 1 or 3, got %d", q->metric_channels);
  if (((q->want & YLM_WANT_VALUE) && !r->value) ||
      ((q->want & YLM_WANT_GRADIENT) && !r->gradient) ||
      ((q->want & YLM_WANT_HESSIAN) && !r->hessian))
    return ylm_fail(e, YLM_EINVAL, "a result is wanted but has no place to go");
  if (points && !ylm_all_finite(q->dtype, points, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", where / 3 + 1);
  if (q->origin && !ylm_all_finite(YLM_DOUBLE, q->origin, 3, &where))
    return ylm_fail(e, YLM_EDOMAIN, "the origin of points is not finite");
  for (int a = 0; q->origin && a < 3; a++)
    if (fabs(q->origin[a]) > FARTHEST)
      return ylm_fail(e, YLM_ERANGE, "the origin of points is beyond %g", FARTHEST);
  return YLM_OK;
}

void ylm_origin(const double box[6], double origin[3]) {
  double half = 0, far = 0;
  for (int a = 0; a < 3; a++) {
    half = fmax(half, (box[a + 3] - box[a]) / 2);
    far = fmax(far, fabs(box[a + 3] / 2 + box[a] / 2));
  }
  bool near = !(far > YLM_ORIGIN_NEAR && far > YLM_ORIGIN_RATIO * half) || !isfinite(far);
  double step = near ? 1 : exp2(floor(log2(fmax(half, far * 0x1p-40))));
  for (int a = 0; a < 3; a++)
    origin[a] = near ? 0 : step * nearbyint((box[a + 3] / 2 + box[a] / 2) / step);
}

/* Numbers of all results of a block, and points of a block. */
enum { ROOM = 1 << 20, LEAST = 64 };

/* Results of a block in double, and where they go. */
typedef struct widened {
  const ylm_field *f;
  const ylm_field_query *q;
  size_t width; /* numbers of a value */
  double *points, *value, *gradient, *hessian, *lambda, *norm;
} widened;

static double *room(bool wanted, size_t n, size_t width) {
  return wanted ? ylm_alloc(n, width * sizeof(double)) : NULL;
}

static bool make(widened *w, size_t n, const ylm_field_result *r) {
  const int want = w->q->want;
  const bool metric = want & YLM_WANT_METRIC;
  w->points = room(true, n, 3);
  w->value = room(want & YLM_WANT_VALUE, n, w->width);
  w->gradient = room(want & YLM_WANT_GRADIENT, n, 3 * w->width);
  w->hessian = room(want & YLM_WANT_HESSIAN, n, 6 * w->width);
  w->lambda = room(metric && r->lambda, n, 1);
  w->norm = room(metric && r->norm, n, 1);
  return w->points && (w->value || !(want & YLM_WANT_VALUE)) &&
         (w->gradient || !(want & YLM_WANT_GRADIENT)) &&
         (w->hessian || !(want & YLM_WANT_HESSIAN)) && (w->lambda || !(metric && r->lambda)) &&
         (w->norm || !(metric && r->norm));
}

static void forget(widened *w) {
  ylm_free(w->points);
  ylm_free(w->value);
  ylm_free(w->gradient);
  ylm_free(w->hessian);
  ylm_free(w->lambda);
  ylm_free(w->norm);
}

/* n numbers to results, from number `first` on. */
static void put(ylm_dtype t, void *to, size_t first, const double *from, size_t n) {
  for (size_t i = 0; from && to && i < n; i++) ylm_put(t, to, first + i, from[i]);
}

/* Asks for points begin .. begin+n-1. */
static ylm_status ask(const widened *w, size_t begin, size_t n, const void *points,
                      ylm_field_result *r, ylm_error *e) {
  ylm_field_query q = *w->q;
  ylm_field_result wide = {.value = w->value,
                           .gradient = w->gradient,
                           .hessian = w->hessian,
                           .lambda = w->lambda,
                           .norm = w->norm,
                           .inside = r->inside ? r->inside + begin : NULL,
                           .validity = r->validity ? r->validity + begin : NULL};
  for (size_t i = 0; i < 3 * n; i++)
    w->points[i] = ylm_get(q.dtype, points, 3 * begin + i) + q.origin[i % 3];
  q.dtype = YLM_DOUBLE;
  q.origin = NULL;
  ylm_status s = w->f->evaluate(w->f, &q, n, w->points, &wide, e);
  r->pairs += wide.pairs;
  if (s != YLM_OK) return s;
  const ylm_dtype t = w->q->dtype;
  put(t, r->value, begin * w->width, w->value, n * w->width);
  put(t, r->gradient, 3 * begin * w->width, w->gradient, 3 * n * w->width);
  put(t, r->hessian, 6 * begin * w->width, w->hessian, 6 * n * w->width);
  put(t, r->lambda, begin, w->lambda, n);
  put(t, r->norm, begin, w->norm, n);
  return s;
}

ylm_status ylm_field_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                              const void *points, ylm_field_result *r, ylm_error *e) {
  if (!q->origin || f->relative) return f->evaluate(f, q, n, points, r, e);
  widened w = {.f = f, .q = q};
  w.width = (size_t)q->channels * (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1);
  size_t most = ROOM / (10 * w.width);
  if (most < LEAST) most = LEAST;
  if (most > n) most = n ? n : 1;
  ylm_status s = make(&w, most, r) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_ENOMEM) s = ylm_fail_plain(e, s);
  for (size_t i = 0; s == YLM_OK && i < n; i += most)
    s = ask(&w, i, n - i < most ? n - i : most, points, r, e);
  forget(&w);
  return s;
}
