/* metric.c - eigenvalues of Hessians, and results in the form that a query wants. */
#include <math.h>

#include "light.h"
#include "moments/plan.h"
#include "ylm_sh.h"

/* -- the largest absolute eigenvalue of a symmetric matrix xx xy xz yy yz zz -- */

static inline double larger(double a, double b) { return a > b ? a : b; }
static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double magnitude(double a) { return fabs(a); }
static inline double choose(bool first, double a, double b) { return first ? a : b; }

typedef double real, vreal;
typedef bool vmask;
#define vreal_sqrt sqrt
#define TINY 1e-280
#include "moments/gen/eigenvalue.h"

static float lambda2(size_t count, const float *hessian) {
  double s = 0;
  for (size_t i = 0; i < count; i++) {
    double h[6], e;
    for (size_t a = 0; a < 6; a++) h[a] = (double)hessian[a * count + i];
    e = largest_eigenvalue(h);
    s += e * e;
  }
  return (float)s;
}

ylm_light_lambda2_fn *ylm_light_lambda2(void) {
  ylm__kernel_set set;
  return ylm__kernels_of(ylm_isa_current(), 0, YLM_FLOAT, &set) ? set.lambda2 : lambda2;
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
        ylm_put(q->dtype, out[k], (point * (size_t)q->channels + (size_t)c) * width[k] * count + i,
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
  if (r->lambda) ylm_put(q->dtype, r->lambda, point, sqrt(lambda));
  if (r->norm) ylm_put(q->dtype, r->norm, point, sqrt(norm));
}
