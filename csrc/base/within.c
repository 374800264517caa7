/* within.c - whether all numbers of an array are small, or at least finite. */
#include "within.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "ylm_sets.h"

YLM__MAGNITUDE(of_float, float, int32_t, INT32_MAX);
YLM__MAGNITUDE(of_double, double, int64_t, INT64_MAX);

static const ylm__magnitudes plain = {of_float, of_double};

static YLM_KERNEL_CHOICE(const ylm__magnitudes, kernels, ylm_k_magnitudes, &plain);

bool ylm_all_within(ylm_dtype t, const void *x, size_t n, double limit) {
  const ylm__magnitudes *k = kernels();
  if (t == YLM_DOUBLE) {
    int64_t most;
    memcpy(&most, &limit, sizeof most);
    return k->of_double(x, n) <= most;
  }
  float small = (float)limit;
  int32_t most;
  memcpy(&most, &small, sizeof most);
  return k->of_float(x, n) <= most;
}

bool ylm_all_finite(ylm_dtype t, const void *x, size_t n, size_t *where) {
  if (ylm_all_within(t, x, n, t == YLM_DOUBLE ? DBL_MAX : (double)FLT_MAX)) return true;
  const float *f = x;
  const double *d = x;
  for (size_t i = 0; i < n; i++) {
    if (t == YLM_DOUBLE ? isfinite(d[i]) : isfinite(f[i])) continue;
    if (where) *where = i;
    return false;
  }
  return true;
}
