/* bound.c - how large the field of a light can be, and its derivatives: measured once for a
   kind. */
#include <math.h>
#include <string.h>

#include "lamp.h"

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

/*
** Of a sphere s = r/d alone decides, and smoothly, since norms over all orders do not depend on the
** direction. A flat light adds the angle off its normal. An exact one is the integral over its area
** of what a very small one emits, which scales with the distance.
*/
ylm_status ylm__lamp_bounds(int lmax, lamp_kind kind, double bound[4], ylm_error *e) {
  static const double far[] = {NEAR, 3.5, 4.5, 6.5, 12, 40, 400};
  static const double cosine[] = {0.8, 1, 0.95, 0.6, 0.4, 0.2, 0.08, 0.01};
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  double radius = kind == LAMP_EXACT ? 1e-4 : 1, strength = 1;
  double rows[3][3] = {{0}, {radius, 0, 0}, {0, radius, 0}}; /* a disk about the z axis */
  lamp_shape *disk = ylm_alloc_zero(1, sizeof *disk + sizeof rows);
  probe m = {.lmax = lmax,
             .count = count,
             .value = ylm_alloc(POINTS * count, sizeof(double)),
             .gradient = ylm_alloc(POINTS * count, 3 * sizeof(double)),
             .hessian = ylm_alloc(POINTS * count, 6 * sizeof(double))};
  lamp_field f = {0};
  ylm_status s = disk && m.value && m.gradient && m.hessian ? YLM_OK : YLM_ENOMEM;
  for (int k = 0; k < 4; k++) bound[k] = 0;
  if (s == YLM_OK) {
    disk->exact = kind == LAMP_EXACT;
    disk->rows = 3;
    memcpy(disk->row, rows, sizeof rows);
    lamp l = {.radius = radius, .shape = kind == LAMP_SPHERE ? NULL : disk};
    s = ylm__lamp_field(1, (const lamp *const[]){&l}, &strength, &f);
  }
  m.field = f.field;
  size_t distances = kind == LAMP_EXACT ? 1 : sizeof far / sizeof *far;
  size_t angles = kind == LAMP_SPHERE ? 1 : sizeof cosine / sizeof *cosine;
  for (size_t i = 0; s == YLM_OK && i < distances * angles; i++) {
    double c = cosine[i / distances], sine = sqrt(1 - c * c);
    s = measure_at(&m, (double[3]){0.6 * sine, 0.8 * sine, c},
                   kind == LAMP_EXACT ? 1 : far[i % distances], radius, bound, e);
  }
  ylm__lamp_field_free(&f);
  ylm_free(disk);
  ylm_free(m.value);
  ylm_free(m.gradient);
  ylm_free(m.hessian);
  return s;
}
