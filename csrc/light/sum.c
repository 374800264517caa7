/* sum.c - what fields that are no sums of spheres share: checks, results, the sum of fields. */
#include <math.h>
#include <string.h>

#include "finite.h"
#include "moments/plan.h"
#include "ylm_sh.h"

ylm_status ylm__query_check(const ylm_field_query *q, const ylm_field_result *r, int most,
                            ylm_error *e) {
  if (q->lmax < 0 || q->lmax > most)
    return ylm_fail(e, YLM_ERANGE, "lmax must be 0 .. %d for these lights, got %d", most, q->lmax);
  if (q->channels != 1 && q->channels != 3)
    return ylm_fail(e, YLM_EINVAL, "channels must be 1 or 3, got %d", q->channels);
  if ((q->want & YLM_WANT_METRIC) && q->metric_channels != 1 && q->metric_channels != 3)
    return ylm_fail(e, YLM_EINVAL, "metric_channels must be 1 or 3, got %d", q->metric_channels);
  if (((q->want & YLM_WANT_VALUE) && !r->value) ||
      ((q->want & YLM_WANT_GRADIENT) && !r->gradient) ||
      ((q->want & YLM_WANT_HESSIAN) && !r->hessian))
    return ylm_fail(e, YLM_EINVAL, "a result is wanted but has no place to go");
  return YLM_OK;
}

ylm_status ylm__field_check(const ylm_field_query *q, size_t n, const void *points,
                            const ylm_field_result *r, int most, ylm_error *e) {
  size_t where;
  ylm_status s = ylm__query_check(q, r, most, e);
  if (s != YLM_OK) return s;
  if (!ylm_all_finite(q->dtype, points, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", where / 3 + 1);
  return YLM_OK;
}

/* -- the largest absolute eigenvalue of a symmetric matrix xx xy xz yy yz zz -- */

static inline double larger(double a, double b) { return a > b ? a : b; }
static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double size(double a) { return fabs(a); }
static inline double choose(bool first, double a, double b) { return first ? a : b; }

#define V double
#define VI bool
#define REAL double
#define NAME(x) x
#define SQRT sqrt
#define TINY 1e-280
#define FINE 1
#include "moments/gen/eigenvalue.h"

static float bend(size_t count, const float *hessian) {
  double s = 0;
  for (size_t i = 0; i < count; i++) {
    double h[6], e;
    for (size_t a = 0; a < 6; a++) h[a] = (double)hessian[a * count + i];
    e = largest_eigenvalue(h);
    s += e * e;
  }
  return (float)s;
}

ylm_light_bend_fn *ylm_light_bend(void) {
  ylm__kernel_set set;
  return ylm__kernels_of(ylm_isa_current(), 0, YLM_FLOAT, &set) ? set.bend : bend;
}

static void put(ylm_dtype t, void *out, size_t i, double x) {
  if (t == YLM_DOUBLE)
    ((double *)out)[i] = x;
  else
    ((float *)out)[i] = (float)x;
}

/* Number `at` of channel c, of luminance where `sum` has three and one is asked for. */
static double channel_of(const double *sum, int from, int to, int c, size_t wide, size_t at) {
  if (from == 1) return sum[at];
  if (to == 3) return sum[(size_t)c * wide + at];
  return YLM_LUMINANCE_R * sum[at] + YLM_LUMINANCE_G * sum[wide + at] +
         YLM_LUMINANCE_B * sum[2 * wide + at];
}

void ylm__field_write(const ylm_field_query *q, size_t point, int channels, const double *sum,
                      size_t wide, ylm_field_result *r) {
  size_t count = ylm_sh_count(q->lmax);
  void *out[3] = {q->want & YLM_WANT_VALUE ? r->value : NULL,
                  q->want & YLM_WANT_GRADIENT ? r->gradient : NULL,
                  q->want & YLM_WANT_HESSIAN ? r->hessian : NULL};
  static const size_t width[3] = {1, 3, 6}, before[3] = {0, 1, 4};
  for (int k = 0; k < 3; k++)
    for (int c = 0; out[k] && c < q->channels; c++)
      for (size_t i = 0; i < width[k] * count; i++)
        put(q->dtype, out[k], (point * (size_t)q->channels + (size_t)c) * width[k] * count + i,
            channel_of(sum, channels, q->channels, c, wide, before[k] * count + i));
  if (!(q->want & YLM_WANT_METRIC)) return;
  double lambda = 0, norm = 0;
  for (int c = 0; c < q->metric_channels; c++)
    for (size_t i = 0; i < count; i++) {
      double h[6], x = channel_of(sum, channels, q->metric_channels, c, wide, i);
      for (size_t a = 0; a < 6; a++)
        h[a] = channel_of(sum, channels, q->metric_channels, c, wide, 4 * count + 6 * i + a);
      double e = largest_eigenvalue(h);
      lambda += e * e;
      norm += x * x;
    }
  if (r->lambda) put(q->dtype, r->lambda, point, sqrt(lambda));
  if (r->norm) put(q->dtype, r->norm, point, sqrt(norm));
}

/* -- the sum of fields
 * -------------------------------------------------------------------------------- */

struct ylm_field_sum {
  ylm_field field;
  size_t n;
  const ylm_field **parts;
};

/* Points of one step: results of a part are kept for as many. */
#define STEP 256

/* The query of a part: no more than the whole needs, in the type of the whole. */
static ylm_field_query part_query(const ylm_field_query *q) {
  bool metric = q->want & YLM_WANT_METRIC;
  ylm_field_query part = {.lmax = q->lmax,
                          .channels = metric && q->metric_channels == 3 ? 3 : q->channels,
                          .metric_channels = 1,
                          .dtype = q->dtype,
                          .threads = q->threads};
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
  ylm_status status = ylm__field_check(q, n, points, r, YLM_LIGHT_LMAX, e);
  if (status != YLM_OK) return status;
  ylm_field_query part = part_query(q);
  size_t count = ylm_sh_count(q->lmax), wide = 10 * count, channels = (size_t)part.channels;
  size_t size = ylm_dtype_size(q->dtype), rows = STEP * channels * count;
  char *one = ylm_alloc(rows * 10, size);
  double *sum = ylm_alloc(STEP * channels * wide, sizeof *sum);
  uint8_t inside[STEP], any[STEP];
  if (!one || !sum) status = YLM_ENOMEM;
  for (size_t begin = 0; begin < n && status == YLM_OK; begin += STEP) {
    size_t m = n - begin < STEP ? n - begin : STEP;
    memset(sum, 0, m * channels * wide * sizeof *sum);
    memset(any, 0, sizeof any);
    for (size_t k = 0; k < s->n && status == YLM_OK; k++) {
      ylm_field_result result = {
          .value = part.want & YLM_WANT_VALUE ? one : NULL,
          .gradient = part.want & YLM_WANT_GRADIENT ? one + rows * size : NULL,
          .hessian = part.want & YLM_WANT_HESSIAN ? one + 4 * rows * size : NULL,
          .inside = inside};
      memset(inside, 0, sizeof inside);
      status = s->parts[k]->evaluate(s->parts[k], &part, m, (const char *)points + 3 * begin * size,
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

ylm_status ylm_field_sum_create(size_t n, const ylm_field *const *parts, ylm_field_sum **sum) {
  *sum = NULL;
  ylm_field_sum *s = ylm_alloc_zero(1, sizeof *s);
  const ylm_field **copy = ylm_alloc_copy(parts, n, sizeof *copy);
  if (!s || !copy) {
    ylm_free(s);
    ylm_free(copy);
    return YLM_ENOMEM;
  }
  *s = (ylm_field_sum){{.self = s, .evaluate = evaluate, .crosses = crosses}, n, copy};
  *sum = s;
  return YLM_OK;
}

void ylm_field_sum_free(ylm_field_sum *s) {
  if (!s) return;
  ylm_free(s->parts);
  ylm_free(s);
}

const ylm_field *ylm_field_sum_field(const ylm_field_sum *s) { return &s->field; }
