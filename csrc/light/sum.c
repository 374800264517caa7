/* sum.c - what fields that are no sums of spheres share: checks, results, the sum of fields. */
#include <math.h>
#include <string.h>

#include "light.h"
#include "ylm_sh.h"

ylm_status ylm__field_check(const ylm_field_query *q, size_t n, const void *points,
                            const ylm_field_result *r, int most, ylm_error *e) {
  size_t where;
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
  if (!ylm_all_finite(q->dtype, points, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", where / 3 + 1);
  return YLM_OK;
}

/*
** The largest absolute eigenvalue of a symmetric matrix xx xy xz yy yz zz (Smith 1961), with the
*sine
** of the angle as csrc/light/sum_body.h finds it, which keeps its digits where two are alike.
*/
static double largest_eigenvalue(const double h[6]) {
  double mean = (h[0] + h[3] + h[5]) / 3, B[6], p2 = 0;
  static const double weight[6] = {1, 2, 2, 1, 2, 1}; /* elements off the diagonal count twice */
  for (int i = 0; i < 6; i++) B[i] = h[i] - (weight[i] == 1 ? mean : 0);
  for (int i = 0; i < 6; i++) p2 += weight[i] * B[i] * B[i] / 6;
  double p = sqrt(p2), r = 0, s2 = 0;
  if (!(p > 0)) return fabs(mean);
  for (int i = 0; i < 6; i++) B[i] /= p;
  double square[6] = {
      B[0] * B[0] + B[1] * B[1] + B[2] * B[2], B[0] * B[1] + B[1] * B[3] + B[2] * B[4],
      B[0] * B[2] + B[1] * B[4] + B[2] * B[5], B[1] * B[1] + B[3] * B[3] + B[4] * B[4],
      B[1] * B[2] + B[3] * B[4] + B[4] * B[5], B[2] * B[2] + B[4] * B[4] + B[5] * B[5]};
  for (int i = 0; i < 6; i++) r += weight[i] * square[i] * B[i] / 6;
  for (int i = 0; i < 6; i++) {
    double c = square[i] - r * B[i] - (weight[i] == 1 ? 2 : 0);
    s2 += weight[i] * c * c / 6;
  }
  double phi = atan2(sqrt(s2), r) / 3;
  double high = mean + 2 * p * cos(phi), low = mean + 2 * p * cos(phi + 2.09439510239319549231);
  return fmax(fabs(high), fabs(low));
}

static void put(ylm_dtype t, void *out, size_t i, double x) {
  if (t == YLM_DOUBLE)
    ((double *)out)[i] = x;
  else
    ((float *)out)[i] = (float)x;
}

void ylm__field_write(const ylm_field_query *q, size_t point, const double *sum, size_t wide,
                      ylm_field_result *r) {
  size_t count = ylm_sh_count(q->lmax);
  static const double luminance[3] = {YLM_LUMINANCE_R, YLM_LUMINANCE_G, YLM_LUMINANCE_B};
  void *out[3] = {q->want & YLM_WANT_VALUE ? r->value : NULL,
                  q->want & YLM_WANT_GRADIENT ? r->gradient : NULL,
                  q->want & YLM_WANT_HESSIAN ? r->hessian : NULL};
  static const size_t width[3] = {1, 3, 6}, before[3] = {0, 1, 4};
  for (int k = 0; k < 3; k++)
    for (int c = 0; out[k] && c < q->channels; c++)
      for (size_t i = 0; i < width[k] * count; i++) {
        size_t at = before[k] * count + i;
        double x = q->channels == 3 ? sum[(size_t)c * wide + at]
                                    : luminance[0] * sum[at] + luminance[1] * sum[wide + at] +
                                          luminance[2] * sum[2 * wide + at];
        put(q->dtype, out[k], (point * (size_t)q->channels + (size_t)c) * width[k] * count + i, x);
      }
  if (!(q->want & YLM_WANT_METRIC)) return;
  double lambda = 0, norm = 0;
  for (int c = 0; c < q->metric_channels; c++)
    for (size_t i = 0; i < count; i++) {
      double h[6], x = 0;
      memset(h, 0, sizeof h);
      for (int s = 0; s < 3; s++) {
        double w = q->metric_channels == 3 ? s == c : luminance[s];
        x += w * sum[(size_t)s * wide + i];
        for (size_t a = 0; a < 6; a++) h[a] += w * sum[(size_t)s * wide + 4 * count + 6 * i + a];
      }
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

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_field_sum *s = f->self;
  ylm_status status = ylm__field_check(q, n, points, r, YLM_LIGHT_LMAX, e);
  if (status != YLM_OK) return status;
  size_t count = ylm_sh_count(q->lmax), wide = 10 * count;
  bool hessian = q->want & (YLM_WANT_HESSIAN | YLM_WANT_METRIC);
  /* every part in rgb and double; sums are written in the end */
  ylm_field_query part = {.lmax = q->lmax,
                          .channels = 3,
                          .metric_channels = 1,
                          .dtype = YLM_DOUBLE,
                          .threads = q->threads,
                          .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT |
                                  (hessian ? YLM_WANT_HESSIAN : 0)};
  double *one = ylm_alloc(STEP * 3 * wide, sizeof *one),
         *sum = ylm_alloc(STEP * 3 * wide, sizeof *sum);
  double x[STEP][3];
  uint8_t inside[STEP], any[STEP];
  if (!one || !sum) status = YLM_ENOMEM;
  for (size_t begin = 0; begin < n && status == YLM_OK; begin += STEP) {
    size_t m = n - begin < STEP ? n - begin : STEP;
    for (size_t i = 0; i < 3 * m; i++)
      x[i / 3][i % 3] = q->dtype == YLM_DOUBLE ? ((const double *)points)[3 * begin + i]
                                               : (double)((const float *)points)[3 * begin + i];
    memset(sum, 0, m * 3 * wide * sizeof *sum);
    memset(any, 0, sizeof any);
    for (size_t k = 0; k < s->n && status == YLM_OK; k++) {
      double *v = one, *g = v + m * 3 * count, *h = g + m * 9 * count;
      ylm_field_result result = {.value = v, .gradient = g, .hessian = h, .inside = inside};
      memset(inside, 0, sizeof inside);
      status = s->parts[k]->evaluate(s->parts[k], &part, m, x, &result, e);
      r->pairs += result.pairs;
      for (size_t i = 0; i < m && status == YLM_OK; i++) {
        any[i] |= inside[i];
        for (size_t c = 0; c < 3; c++) {
          double *to = sum + (i * 3 + c) * wide;
          for (size_t t = 0; t < count; t++) to[t] += v[(i * 3 + c) * count + t];
          for (size_t t = 0; t < 3 * count; t++) to[count + t] += g[(i * 3 + c) * 3 * count + t];
          for (size_t t = 0; hessian && t < 6 * count; t++)
            to[4 * count + t] += h[(i * 3 + c) * 6 * count + t];
        }
      }
    }
    for (size_t i = 0; i < m && status == YLM_OK; i++) {
      ylm__field_write(q, begin + i, sum + i * 3 * wide, wide, r);
      if (r->inside) r->inside[begin + i] = any[i];
    }
    if (status == YLM_OK) status = ylm_report(q->progress, begin + m, n, "lights");
  }
  ylm_free(one);
  ylm_free(sum);
  return status;
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
  const ylm_field **copy = ylm_alloc(n, sizeof *copy);
  if (!s || !copy) {
    ylm_free(s);
    ylm_free(copy);
    return YLM_ENOMEM;
  }
  memcpy(copy, parts, n * sizeof *copy);
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
