/*
** environment.c - light from all around, infinitely far away, as a kind of light.
**
** | parameter    | unit         | allowed                                              |
** | radiance     | W sr^-1 m^-2 | finite, linear Rec. 709; multiplies the coefficients |
** | lmax         | -            | 0 .. YLM_LIGHT_LMAX, or -1: all others are zero      |
** | coefficients | sr^1/2       | finite, [(lmax+1)^2]; with lmax -1 the first alone   |
**
** A record: radiance [3], lmax, coefficients. Channels that differ in more than a factor are three
** records. L_lm(x) is the radiance times the coefficients, for every x. A query beyond lmax is
** refused: coefficients that were left out are unknown. Rays see max(0, reconstruction), of all
** records of a pack together.
**
** Source  docs/math.md "Distant light"
*/
#include <string.h>

#include "environment.h"
#include "ylm_sh.h"

enum { LMAX = 3, HEAD };

static int degree_of(const double *record) { return record[LMAX] < 0 ? 0 : (int)record[LMAX]; }

static size_t length(const double *x, size_t left) {
  if (left < HEAD || !(x[LMAX] >= -1) || x[LMAX] > YLM_LIGHT_LMAX) return 0;
  size_t n = HEAD + ylm_sh_count(degree_of(x));
  return n <= left ? n : 0;
}

/* -- the field ------------------------------------------------------------------------------ */

/* The highest degree that all records are known to. */
static int known_to(const ylm__distant *p) {
  int most = YLM_LIGHT_LMAX;
  for (size_t i = 0; i < p->n; i++)
    if (p->record[i][LMAX] >= 0 && degree_of(p->record[i]) < most) most = degree_of(p->record[i]);
  return most;
}

static ylm_status check(const ylm__distant *p, bool projected, const ylm_field_query *q, size_t n,
                        const void *points, const ylm_field_result *r, ylm_error *e) {
  ylm_status s = ylm_field_check(q, n, points, r, YLM_LIGHT_LMAX, "these lights", e);
  int most = known_to(p);
  if (s != YLM_OK || q->lmax <= most) return s;
  return ylm_fail(e, YLM_ERANGE,
                  "an environment light is %s to lmax %d%s, and asked for at lmax %d",
                  projected ? "projected" : "known", most,
                  projected ? " (lmax = in environment_light)" : "", q->lmax);
}

ylm_status ylm__environment_evaluate(const ylm__distant *p, bool projected,
                                     const ylm_field_query *q, size_t n, const void *points,
                                     ylm_field_result *r, ylm_error *e) {
  ylm_status s = check(p, projected, q, n, points, r, e);
  if (s != YLM_OK) return s;
  size_t count = ylm_sh_count(q->lmax);
  double *sum = ylm_alloc_zero(3 * count, sizeof *sum);
  if (!sum) return ylm_no_memory(e);
  for (size_t i = 0; i < p->n; i++) {
    const double *x = p->record[i];
    for (size_t k = 0; k < count && k < ylm_sh_count(degree_of(x)); k++)
      for (size_t c = 0; c < 3; c++) sum[c * count + k] += x[c] * x[HEAD + k];
  }
  s = ylm__distant_write(q, n, points, sum, p->n, r, e);
  ylm_free(sum);
  return s;
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm__environment_evaluate(f->self, false, q, n, points, r, e);
}

static void radiance(const void *of, const double d[3], double rgb[3]) {
  const ylm__distant *p = of;
  double y[(YLM_LIGHT_LMAX + 1) * (YLM_LIGHT_LMAX + 1)], sum[3] = {0};
  int lmax = 0;
  for (size_t i = 0; i < p->n; i++)
    if (degree_of(p->record[i]) > lmax) lmax = degree_of(p->record[i]);
  if (ylm_sh_eval(lmax, 0, false, YLM_DOUBLE, 1, d, y, NULL, NULL, 1, NULL) != YLM_OK) return;
  for (size_t i = 0; i < p->n; i++) {
    const double *x = p->record[i];
    double value = 0;
    for (size_t k = 0; k < ylm_sh_count(degree_of(x)); k++) value += x[HEAD + k] * y[k];
    for (int c = 0; c < 3; c++) sum[c] += x[c] * value;
  }
  for (int c = 0; c < 3; c++) rgb[c] += fmax(0, sum[c]);
}

/* Uniform where no record knows more than the mean. */
static void dome(const void *of, ylm_light_dome *out) {
  const ylm__distant *p = of;
  out->uniform = true;
  for (size_t i = 0; i < p->n; i++)
    if (degree_of(p->record[i]) > 0) out->uniform = false;
}

/* -- a pack --------------------------------------------------------------------------------- */

static ylm_status settle(double *record, size_t i, ylm_error *e) {
  if (ylm_all_finite(YLM_DOUBLE, record, length(record, SIZE_MAX), NULL)) return YLM_OK;
  return ylm_fail(e, YLM_EDOMAIN, "environment %zu is not finite", i + 1);
}

ylm_status ylm__environment_copy(ylm__distant *d, size_t n, const double *const *record,
                                 ylm_error *e) {
  return ylm__distant_copy(d, &ylm__environment_kind, n, record, settle, e);
}

static ylm_status create(size_t n, const double *const *record, ylm__light_pack *made,
                         ylm_error *e) {
  ylm_status s = ylm__distant_create(&ylm__environment_kind, n, record, settle, made, e);
  if (s == YLM_OK) ((ylm__distant *)made->of)->field.evaluate = evaluate;
  return s;
}

/* -- one of them ---------------------------------------------------------------------------- */

static double norm(const ylm_light *l, int lmax) {
  double s = 0;
  for (size_t k = 1; k < l->shape->numbers && k <= ylm_sh_count(lmax); k++)
    s += l->shape->x[k] * l->shape->x[k];
  return sqrt(s);
}

const ylm__light_kind ylm__environment_kind = {.name = "environment",
                                               .length = length,
                                               .create = create,
                                               .free = ylm__distant_free,
                                               .get = ylm__distant_get,
                                               .radiance = radiance,
                                               .dome = dome,
                                               .record = ylm__distant_record,
                                               .slides = ylm__distant_slides,
                                               .norm = norm};
