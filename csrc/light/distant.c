/* distant.c - fields of distant lights: the same at every point. */
#include "distant.h"

#include <string.h>

#include "finite.h"
#include "ylm_sh.h"

ylm_status ylm__distant_check(const ylm_field_query *q, size_t n, const void *points,
                              const ylm_field_result *r, int most, const char *what, ylm_error *e) {
  ylm_status s = ylm__field_check(q, n, points, r, YLM_LIGHT_LMAX, e);
  if (s == YLM_OK && q->lmax > most)
    return ylm_fail(e, YLM_ERANGE, "%s is known to lmax %d, and asked for at lmax %d", what, most,
                    q->lmax);
  return s;
}

/* Copies the first of n rows of results to all others. */
static void repeat(const ylm_field_query *q, void *rows, size_t n, size_t width) {
  size_t bytes = width * ylm_dtype_size(q->dtype);
  for (size_t i = 1; rows && i < n; i++) memcpy((char *)rows + i * bytes, rows, bytes);
}

ylm_status ylm__distant_write(const ylm_field_query *q, size_t n, const void *points,
                              const double *coefficients, size_t lights, ylm_field_result *r,
                              ylm_error *e) {
  size_t count = ylm_sh_count(q->lmax), wide = 10 * count, values = (size_t)q->channels * count;
  if (n == 0) return YLM_OK;
  double *sum = ylm_alloc_zero(3 * wide, sizeof *sum);
  if (!sum) return ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  for (size_t c = 0; c < 3; c++)
    memcpy(sum + c * wide, coefficients + c * count, count * sizeof *sum);
  ylm__field_write(q, 0, 3, sum, wide, r);
  ylm_free(sum);
  if (q->want & YLM_WANT_VALUE) repeat(q, r->value, n, values);
  if (q->want & YLM_WANT_GRADIENT) repeat(q, r->gradient, n, 3 * values);
  if (q->want & YLM_WANT_HESSIAN) repeat(q, r->hessian, n, 6 * values);
  if (q->want & YLM_WANT_METRIC) repeat(q, r->lambda, n, 1), repeat(q, r->norm, n, 1);
  if (r->inside) memset(r->inside, 0, n);
  r->pairs += (uint64_t)n * lights;
  ylm_status s = ylm_light_finite(q, 1, points, r, e);
  return s == YLM_OK ? ylm_report(q->progress, n, n, "lights") : s;
}

ylm_status ylm__distant_crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  (void)f, (void)boxes;
  memset(out, 0, n);
  return YLM_OK;
}

bool ylm__distant_slides(const ylm_light *a, const ylm_light *b) {
  const ylm_light_shape *s = a->shape, *t = b->shape;
  return s->numbers == t->numbers && memcmp(s->x, t->x, s->numbers * sizeof *s->x) == 0;
}
