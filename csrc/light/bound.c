/*
** bound.c - how large the field of a light can be, and its derivatives, and what a change of it
** changes: measured once for a kind.
**
** The norms of the k-th derivatives of the coefficients of a light of radiance 1, k = 0 .. 3, are
** below of[k] radius^2 / d^(k+2) at distances d larger than the kind's `near`. Of distant lights
** values alone matter, whose norm the kind knows.
*/
#include <string.h>

#include "kind.h"

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

/* Values and derivatives about a place, and what is measured of them. */
typedef struct probe {
  const ylm_field *field;
  int lmax;
  size_t count;
  double *value, *gradient, *hessian; /* [POINTS][count], [..][3], [..][6] */
} probe;

enum { POINTS = 7 };

/* Raises the bounds to what they must be at `distance` along `way` from the centre of a light of
   the given radius. */
static ylm_status measure_at(const probe *m, const double way[3], double distance, double radius,
                             double bound[4], ylm_error *e) {
  size_t count = m->count;
  double x[POINTS][3], step = 1e-4 * distance, third = 0;
  for (int p = 0; p < POINTS; p++)
    for (int a = 0; a < 3; a++)
      x[p][a] = distance * way[a] + (p > 0 && (p - 1) / 2 == a ? (p & 1 ? step : -step) : 0);
  ylm_field_query q = {.lmax = m->lmax,
                       .channels = 1,
                       .metric_channels = 1,
                       .dtype = YLM_DOUBLE,
                       .threads = 1,
                       .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_HESSIAN};
  ylm_field_result r = {.value = m->value, .gradient = m->gradient, .hessian = m->hessian};
  ylm_status s = m->field->evaluate(m->field, &q, POINTS, x, &r, e);
  if (s != YLM_OK) return s;
  for (size_t a = 0; a < 3; a++)
    third += hessian_squares(m->hessian + (1 + 2 * a) * 6 * count,
                             m->hessian + (2 + 2 * a) * 6 * count, count);
  double norm[4] = {squares(m->value, count), squares(m->gradient, 3 * count),
                    hessian_squares(m->hessian, NULL, count), third / (4 * step * step)};
  for (int k = 0; k < 4; k++)
    bound[k] = fmax(bound[k], 1.1 * sqrt(norm[k]) * pow(distance, k + 2) / (radius * radius));
  return YLM_OK;
}

const double ylm__probe_distance[YLM__PROBE_DISTANCES] = {YLM__NEAR, 3.5, 4.5, 6.5, 12, 40, 400};
const double ylm__probe_cosine[YLM__PROBE_COSINES] = {0.8, 1, 0.95, 0.6, 0.4, 0.2, 0.08, 0.01};

/* A set of the one light that the kind is measured by. */
static ylm_status make_light(const ylm__light_kind *kind, ylm_light_set **set, ylm_error *e) {
  const double *record = kind->probes->record;
  ylm_light_source from = {kind->name, record, kind->length(record, SIZE_MAX), NULL, NULL};
  return ylm_light_set_create(1, &from, set, e);
}

static ylm_status measure(const ylm__light_kind *kind, int lmax, double bound[4], ylm_error *e) {
  const ylm__light_probes *k = kind->probes;
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  probe m = {.lmax = lmax,
             .count = count,
             .value = ylm_alloc(POINTS * count, sizeof(double)),
             .gradient = ylm_alloc(POINTS * count, 3 * sizeof(double)),
             .hessian = ylm_alloc(POINTS * count, 6 * sizeof(double))};
  ylm_light_set *set = NULL;
  ylm_status s = m.value && m.gradient && m.hessian ? YLM_OK : YLM_ENOMEM;
  for (int i = 0; i < 4; i++) bound[i] = 0;
  if (s == YLM_OK) s = make_light(kind, &set, e);
  if (s == YLM_OK) m.field = ylm_light_set_field(set);
  for (size_t i = 0; s == YLM_OK && i < k->distances * k->cosines; i++) {
    double c = k->cosine[i / k->distances], sine = sqrt(1 - c * c);
    s = measure_at(&m, (double[3]){0.6 * sine, 0.8 * sine, c}, k->distance[i % k->distances],
                   k->radius, bound, e);
  }
  ylm_light_set_free(set);
  ylm_free(m.value);
  ylm_free(m.gradient);
  ylm_free(m.hessian);
  return s;
}

static double *row_of(ylm_light_bounds *b, const ylm_light *l) {
  return b->of[ylm__light_kind_index(l->shape->kind)];
}

ylm_status ylm_light_bounds_meet(ylm_light_bounds *b, size_t n, const ylm_light *light,
                                 ylm_error *e) {
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    double *bound = row_of(b, &light[i]);
    const ylm__light_kind *kind = light[i].shape->kind;
    if (kind->probes && bound[0] == 0) s = measure(kind, b->lmax, bound, e);
  }
  return s;
}

/* -- changes ---------------------------------------------------------------------------------- */

/* The norm of a light's radiance over the channels, or of the difference of two. */
static double emission(const ylm_light_bounds *t, const ylm_light *a, const ylm_light *b) {
  double x[3], s = 0;
  for (int c = 0; c < 3; c++) x[c] = a->radiance[c] - (b ? b->radiance[c] : 0);
  if (t->channels == 1) return fabs(ylm_luminance(x));
  for (int c = 0; c < 3; c++) s += x[c] * x[c];
  return sqrt(s);
}

/* Bounds of value, gradient and Hessian. */
typedef struct bounds {
  double of[3];
} bounds;

/* Of a light of radiance e at distance d. */
static bounds bounds_at(const ylm_light_bounds *t, const ylm_light *l, double e, double d) {
  const ylm__light_kind *kind = l->shape->kind;
  const double *bound = t->of[ylm__light_kind_index(kind)];
  bounds out = {{0}};
  if (kind->norm) {
    out.of[0] = e * kind->norm(l, t->lmax);
    return out;
  }
  double x = e > 0 ? e * l->radius * l->radius / (d * d) : 0;
  for (int k = 0; k < 3; k++) {
    out.of[k] = bound[k] * x;
    x = x > 0 ? x / d : 0;
  }
  if (kind->cut) kind->cut(l, t->lmax, e, d, out.of);
  return out;
}

/* The distance at which a light is seen, and whether that is too near for a bound. */
static double distance_of(const ylm_light *l, double e, const double p[3], bool *near) {
  const ylm__light_kind *kind = l->shape->kind;
  if (kind->norm) return INFINITY;
  double d = kind->distance(l, l, p);
  *near |= e > 0 && d <= kind->near(l);
  return d;
}

/* Bounds of the change by a light of radiance e that slides from a to b, and by the change of its
   radiance. False where they do not hold. */
static bool bounds_of_way(const ylm_light_bounds *t, const ylm_light *a, const ylm_light *b,
                          const double p[3], double e, double db, bounds *out) {
  const ylm__light_kind *kind = a->shape->kind;
  const double *bound = t->of[ylm__light_kind_index(kind)];
  *out = bounds_at(t, b, emission(t, b, a), db);
  if (kind->norm) return true;
  double way = ylm__distance(a->at, b->at);
  if (kind->passes && kind->passes(a, b, p)) return false;
  double ds = kind->distance(a, b, p);
  if (ds <= kind->near(a)) return false;
  double x = e * a->radius * a->radius * way / (ds * ds * ds);
  for (int k = 0; k < 3; k++) {
    out->of[k] += x > 0 ? bound[k + 1] * x : 0;
    x = x > 0 ? x / ds : 0;
  }
  return true;
}

/* Both ends are bounded by themselves; a light that slides also by its way times the largest
   derivative on it. */
bool ylm_light_bounds_add(const ylm_light_bounds *t, const ylm_light *a, const ylm_light *b,
                          bool slides, const double p[3], double bound[3]) {
  bool near = false;
  double ea = emission(t, a, NULL), eb = emission(t, b, NULL);
  double da = distance_of(a, ea, p, &near), db = distance_of(b, eb, p, &near);
  if (near) return false;
  bounds from = bounds_at(t, a, ea, da), to = bounds_at(t, b, eb, db), moved;
  bool moves = slides && bounds_of_way(t, a, b, p, ea, db, &moved);
  for (int k = 0; k < 3; k++) {
    double ends = from.of[k] + to.of[k];
    bound[k] += moves && moved.of[k] < ends ? moved.of[k] : ends;
  }
  return true;
}
