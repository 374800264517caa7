/* field_sum.c - the sum of light fields. */
#include <string.h>

#include "calibration.h"
#include "finite.h"
#include "ylm_sh.h"

struct ylm_field_sum {
  ylm_field field;
  size_t n;
  const ylm_field **parts;
};

/* The query of a part: no more than the whole needs, in the type of the whole. */
static ylm_field_query part_query(const ylm_field_query *q) {
  bool metric = q->want & YLM_WANT_METRIC;
  ylm_field_query part = {.lmax = q->lmax,
                          .channels = metric && q->metric_channels == 3 ? 3 : q->channels,
                          .metric_channels = 1,
                          .dtype = q->dtype,
                          .threads = q->threads,
                          .origin = q->origin};
  if (metric || (q->want & YLM_WANT_VALUE)) part.want |= YLM_WANT_VALUE;
  if (q->want & YLM_WANT_GRADIENT) part.want |= YLM_WANT_GRADIENT;
  if (metric || (q->want & YLM_WANT_HESSIAN)) part.want |= YLM_WANT_HESSIAN;
  return part;
}

/* to[i * step ..] += width numbers of row i, for n rows. */
static void add_rows(ylm_dtype t, const void *from, size_t n, size_t width, double *to,
                     size_t step) {
  for (size_t i = 0; i < n; i++)
    for (size_t k = 0; k < width; k++) to[i * step + k] += ylm_get(t, from, i * width + k);
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_field_sum *s = f->self;
  ylm_status status = ylm_field_check(q, n, points, r, YLM_LIGHT_LMAX, "these lights", e);
  if (status != YLM_OK) return status;
  ylm_field_query part = part_query(q);
  size_t count = ylm_sh_count(q->lmax), channels = (size_t)part.channels;
  size_t upto = part.want & YLM_WANT_HESSIAN ? 10 : part.want & YLM_WANT_GRADIENT ? 4 : 1;
  size_t size = ylm_dtype_size(q->dtype), rows = YLM__SUM_POINTS * channels * count,
         wide = upto * count;
  char *one = ylm_alloc(rows * upto, size);
  double *sum = ylm_alloc(YLM__SUM_POINTS * channels * wide, sizeof *sum);
  uint8_t inside[YLM__SUM_POINTS], any[YLM__SUM_POINTS];
  if (!one || !sum) status = YLM_ENOMEM;
  for (size_t begin = 0; begin < n && status == YLM_OK; begin += YLM__SUM_POINTS) {
    size_t m = n - begin < YLM__SUM_POINTS ? n - begin : YLM__SUM_POINTS;
    memset(sum, 0, m * channels * wide * sizeof *sum);
    memset(any, 0, sizeof any);
    for (size_t k = 0; k < s->n && status == YLM_OK; k++) {
      ylm_field_result result = {
          .value = part.want & YLM_WANT_VALUE ? one : NULL,
          .gradient = part.want & YLM_WANT_GRADIENT ? one + rows * size : NULL,
          .hessian = part.want & YLM_WANT_HESSIAN ? one + 4 * rows * size : NULL,
          .inside = inside};
      memset(inside, 0, sizeof inside);
      status = ylm_field_evaluate(s->parts[k], &part, m, (const char *)points + 3 * begin * size,
                                  &result, e);
      r->pairs += result.pairs;
      if (status != YLM_OK) break;
      for (size_t i = 0; i < m; i++) any[i] |= inside[i];
      if (result.value) add_rows(q->dtype, result.value, m * channels, count, sum, wide);
      if (result.gradient)
        add_rows(q->dtype, result.gradient, m * channels, 3 * count, sum + count, wide);
      if (result.hessian)
        add_rows(q->dtype, result.hessian, m * channels, 6 * count, sum + 4 * count, wide);
    }
    for (size_t i = 0; i < m && status == YLM_OK; i++) {
      ylm__field_write(q, begin + i, part.channels, sum + i * channels * wide, wide, r);
      if (r->inside) r->inside[begin + i] = any[i];
    }
    if (status == YLM_OK) status = ylm_report(q->progress, begin + m, n, "lights");
  }
  ylm_free(one);
  ylm_free(sum);
  return status == YLM_OK ? ylm_light_finite(q, n, points, r, e) : status;
}

static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_field_sum *s = f->self;
  uint8_t *one = ylm_alloc(n, 1);
  if (!one) return YLM_ENOMEM;
  memset(out, 0, n);
  ylm_status status = YLM_OK;
  for (size_t k = 0; k < s->n && status == YLM_OK; k++) {
    status = s->parts[k]->crosses(s->parts[k], n, boxes, one);
    for (size_t i = 0; i < n; i++) out[i] |= one[i];
  }
  ylm_free(one);
  return status;
}

/* The quantity of a sum: that of its parts. Direct light, or that of lamps, and indirect light make all. */
static ylm_quantity quantity_of(size_t n, const ylm_field *const *part) {
  bool has[YLM_QUANTITY_COUNT] = {false};
  for (size_t i = 0; i < n; i++) has[part[i]->quantity] = true;
  if (has[YLM_QUANTITY_visibility]) return YLM_QUANTITY_visibility;
  bool first = has[YLM_QUANTITY_lights] || has[YLM_QUANTITY_direct];
  if (has[YLM_QUANTITY_all] || (first && has[YLM_QUANTITY_indirect])) return YLM_QUANTITY_all;
  if (has[YLM_QUANTITY_indirect]) return YLM_QUANTITY_indirect;
  return has[YLM_QUANTITY_direct] ? YLM_QUANTITY_direct : YLM_QUANTITY_lights;
}

static bool pointwise(size_t n, const ylm_field *const *part) {
  bool all = true;
  for (size_t i = 0; i < n; i++) all = all && part[i]->pointwise;
  return all;
}

ylm_status ylm_field_sum_create(size_t n, const ylm_field *const *parts, ylm_field_sum **sum) {
  *sum = NULL;
  ylm_field_sum *s = ylm_alloc_zero(1, sizeof *s);
  const ylm_field **copy = ylm_alloc_copy(parts, n, sizeof *copy);
  if (!s || !copy) {
    ylm_free(s);
    ylm_free(copy);
    return YLM_ENOMEM;
  }
  *s = (ylm_field_sum){{.self = s,
                        .evaluate = evaluate,
                        .crosses = crosses,
                        .quantity = quantity_of(n, copy),
                        .pointwise = pointwise(n, copy),
                        .relative = true},
                       n,
                       copy};
  *sum = s;
  return YLM_OK;
}

void ylm_field_sum_free(ylm_field_sum *s) {
  if (!s) return;
  ylm_free(s->parts);
  ylm_free(s);
}

const ylm_field *ylm_field_sum_field(const ylm_field_sum *s) { return &s->field; }
