/* distant.c - what kinds of distant lights share: their packs, and fields that are the same at
   every point. */
#include "distant.h"

#include <string.h>

#include "../finite.h"
#include "ylm_sh.h"

/* -- packs ---------------------------------------------------------------------------------- */

ylm_status ylm__distant_copy(ylm__distant *d, const ylm__light_kind *kind, size_t n,
                             const double *const *record, ylm__distant_settle_fn *settle,
                             ylm_error *e) {
  size_t all = 0;
  for (size_t i = 0; i < n; i++) all += kind->length(record[i], SIZE_MAX);
  d->field = (ylm_field){.self = d, .crosses = ylm__distant_crosses, .relative = true};
  d->kind = kind;
  d->n = n;
  d->record = ylm_alloc(n, sizeof *d->record);
  double *to = d->numbers = ylm_alloc(all, sizeof *to);
  ylm_status s = d->record && to ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    size_t numbers = kind->length(record[i], SIZE_MAX);
    memcpy(to, record[i], numbers * sizeof *to);
    s = settle(to, i, e);
    d->record[i] = to;
    to += numbers;
  }
  return s;
}

void ylm__distant_release(ylm__distant *d) {
  ylm_free(d->record);
  ylm_free(d->numbers);
}

void ylm__distant_free(void *of) {
  ylm__distant_release(of);
  ylm_free(of);
}

ylm_status ylm__distant_create(const ylm__light_kind *kind, size_t n, const double *const *record,
                               ylm__distant_settle_fn *settle, ylm__light_pack *made,
                               ylm_error *e) {
  ylm__distant *d = ylm_alloc_zero(1, sizeof *d);
  if (!d) return YLM_ENOMEM;
  ylm_status s = ylm__distant_copy(d, kind, n, record, settle, e);
  if (s == YLM_OK)
    *made = (ylm__light_pack){kind, d, &d->field, n, 0};
  else
    ylm__distant_free(d);
  return s;
}

size_t ylm__distant_get(const void *of, size_t i, ylm_light *out, ylm_light_shape *shape) {
  const ylm__distant *d = of;
  const double *x = d->record[i];
  size_t numbers = d->kind->length(x, SIZE_MAX) - 3;
  if (!shape) return numbers;
  *shape = (ylm_light_shape){d->kind, numbers, false};
  memcpy(shape->x, x + 3, numbers * sizeof *shape->x);
  *out = (ylm_light){.shape = shape};
  memcpy(out->radiance, x, sizeof out->radiance);
  return numbers;
}

size_t ylm__distant_record(const ylm_light *l, const double radiance[3], double *to) {
  size_t numbers = l->shape->numbers;
  if (!to) return 3 + numbers;
  memcpy(to, radiance, 3 * sizeof *to);
  memcpy(to + 3, l->shape->x, numbers * sizeof *to);
  return 3 + numbers;
}

/* -- fields --------------------------------------------------------------------------------- */

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
  if (!sum) return ylm_no_memory(e);
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
