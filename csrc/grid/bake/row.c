/* row.c - coefficients of a point compared with others. */
#include "baker.h"

double ylm__row_distance(const float *a, const float *exact, size_t width, double floor) {
  double d = 0, n = 0;
  for (size_t j = 0; j < width; j++) {
    double x = (double)a[j] - (double)exact[j];
    d += x * x;
    n += (double)exact[j] * (double)exact[j];
  }
  return relative_distance(d, n < floor * floor ? floor * floor : n);
}
