/*
** sun.c - suns: discs of one radiance, infinitely far away, as a kind of light.
**
** | parameter  | unit    | allowed                                                          |
** | irradiance | W m^-2  | finite, linear Rec. 709, on a surface that faces the sun         |
** | direction  | -       | towards the sun; finite, not all zero                            |
** | angle      | degrees | 0 < angle <= 180, across the disc                                |
**
** A record: irradiance [3], direction [3], angle. With alpha the cosine of half the angle, the
** radiance is irradiance/(pi (1 - alpha^2)), and that of a sphere light seen under the same angle:
**
**   L_lm = 2 irradiance P_l'(alpha)/(l(l+1)) Y_lm(direction),  L_00 = 2/(1+alpha) irradiance Y_00
**
** for every point. Nothing cancels where the angle is small.
**
** Source  docs/math.md "Distant light"
*/
#include <string.h>

#include "distant.h"
#include "ylm_sh.h"
#include "ylm_vector.h"

enum { DIRECTION = 3, ANGLE = 6, NUMBERS };

static size_t length(const double *x, size_t left) {
  (void)x;
  return left < NUMBERS ? 0 : NUMBERS;
}

static double alpha_of(double angle) { return cos(angle * YLM_PI / 360); }

/* F_l of 0 .. lmax for irradiance 1. */
static void zonal(double alpha, int lmax, double *F) {
  double before = 0, slope = 1, p = 1, last = 0; /* P'_(l-1), P'_l, P_l, P_(l-1) at l = 1 */
  F[0] = 2 / (1 + alpha);
  last = p, p = alpha;
  for (int l = 1; l <= lmax; l++) {
    F[l] = 2 * slope / (l * (l + 1.0));
    double next = ((2 * l + 1) * alpha * p - l * last) / (l + 1),
           steeper = before + (2 * l + 1) * p;
    last = p, p = next;
    before = slope, slope = steeper;
  }
}

/* -- the field ------------------------------------------------------------------------------ */

/* Adds a sun's coefficients to sum [3][count]; y and F are scratch. */
static ylm_status add(const double *sun, int lmax, double *y, double *F, double *sum) {
  size_t count = ylm_sh_count(lmax);
  zonal(alpha_of(sun[ANGLE]), lmax, F);
  ylm_status status =
      ylm_sh_eval(lmax, 0, false, YLM_DOUBLE, 1, sun + DIRECTION, y, NULL, NULL, 1, NULL);
  for (int l = 0; l <= lmax && status == YLM_OK; l++)
    for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++)
      for (size_t c = 0; c < 3; c++) sum[c * count + k] += sun[c] * F[l] * y[k];
  return status;
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm__distant *p = f->self;
  ylm_status s = ylm_field_check(q, n, points, r, YLM_LIGHT_LMAX, "these lights", e);
  if (s != YLM_OK) return s;
  size_t count = ylm_sh_count(q->lmax);
  double *sum = ylm_alloc_zero(4 * count + (size_t)q->lmax + 1, sizeof *sum);
  if (!sum) return ylm_no_memory(e);
  for (size_t i = 0; i < p->n && s == YLM_OK; i++)
    s = add(p->record[i], q->lmax, sum + 3 * count, sum + 4 * count, sum);
  if (s == YLM_OK) s = ylm__distant_write(q, n, points, sum, p->n, r, e);
  ylm_free(sum);
  return s;
}

static void cone(const void *of, size_t i, ylm_light_cone *out) {
  const double *sun = ((const ylm__distant *)of)->record[i], alpha = alpha_of(sun[ANGLE]);
  *out = (ylm_light_cone){.cosine = alpha};
  memcpy(out->axis, sun + DIRECTION, sizeof out->axis);
  for (int c = 0; c < 3; c++) out->radiance[c] = sun[c] / (YLM_PI * (1 - alpha) * (1 + alpha));
}

static void radiance(const void *of, const double d[3], double rgb[3]) {
  const ylm__distant *p = of;
  for (size_t i = 0; i < p->n; i++) {
    ylm_light_cone k;
    cone(of, i, &k);
    double along = k.axis[0] * d[0] + k.axis[1] * d[1] + k.axis[2] * d[2];
    for (int c = 0; c < 3 && along >= k.cosine; c++) rgb[c] += k.radiance[c];
  }
}

/* -- a pack --------------------------------------------------------------------------------- */

/* Directions come to have length 1. */
static ylm_status settle(double *sun, size_t i, ylm_error *e) {
  double angle = sun[ANGLE];
  if (!ylm_all_finite(YLM_DOUBLE, sun, 3, NULL) || !ylm_unit3(sun + DIRECTION))
    return ylm_fail(e, YLM_EDOMAIN, "sun %zu has no direction, or is not finite", i + 1);
  if (!(angle > 0 && angle <= 180) || !(alpha_of(angle) < 1))
    return ylm_fail(e, YLM_EDOMAIN, "sun %zu: its angle must be above 0 and at most 180, got %g",
                    i + 1, angle);
  return YLM_OK;
}

static ylm_status create(size_t n, const double *const *record, ylm__light_pack *made,
                         ylm_error *e) {
  ylm_status s = ylm__distant_create(&ylm__sun_kind, n, record, settle, made, e);
  if (s == YLM_OK) ((ylm__distant *)made->of)->field.evaluate = evaluate;
  return s;
}

/* -- one of them ---------------------------------------------------------------------------- */

static double norm(const ylm_light *l, int lmax) {
  double F[YLM_LIGHT_LMAX + 1], s = 0;
  zonal(alpha_of(l->shape->x[ANGLE - DIRECTION]), lmax, F);
  for (int k = 0; k <= lmax; k++) s += F[k] * F[k] * (2 * k + 1) / (4 * YLM_PI);
  return sqrt(s);
}

const ylm__light_kind ylm__sun_kind = {.name = "sun",
                                       .length = length,
                                       .create = create,
                                       .free = ylm__distant_free,
                                       .get = ylm__distant_get,
                                       .radiance = radiance,
                                       .cone = cone,
                                       .record = ylm__distant_record,
                                       .slides = ylm__distant_slides,
                                       .norm = norm};
