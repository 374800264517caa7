/* measure.c - errors of interpolated coefficients, or of the irradiance that they make. */
#include "measure.h"

#include <math.h>

#include "baker.h"
#include "ylm_sh.h"

double ylm__row_distance(const float *a, const float *exact, size_t width, double floor) {
  double d = 0, n = 0;
  for (size_t j = 0; j < width; j++) {
    double x = (double)a[j] - (double)exact[j];
    d += x * x;
    n += (double)exact[j] * (double)exact[j];
  }
  return relative_distance(d, n < floor * floor ? floor * floor : n);
}

measure ylm__measure_of(const ylm_grid_form *form) {
  return (measure){
      .kind = form->measure, .lmax = form->lmax, .channels = form->channels, .floor = form->floor};
}

void ylm__measure_irradiance(const measure *m, const float *row, const float n[3], double out[3]) {
  float Y[(IRRADIANCE_MOST + 1) * (IRRADIANCE_MOST + 1)];
  size_t count = ylm_sh_count(m->lmax);
  int most = m->lmax < IRRADIANCE_MOST ? m->lmax : IRRADIANCE_MOST;
  ylm_sh_eval(most, 0, false, YLM_FLOAT, 1, n, Y, NULL, NULL, 1, NULL);
  for (int c = 0; c < m->channels; c++) {
    const float *L = row + (size_t)c * count;
    out[c] = 0;
    for (int l = 0; l <= most; l++) {
      double sum = 0;
      for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++)
        sum += (double)Y[k] * (double)L[k];
      out[c] += ylm_sh_cosine_factor(l) * sum;
    }
  }
}

/* |difference| of what is `exact`, or of the mean; 0 in darkness. */
static double relative(const measure *m, double difference, double exact, double mean) {
  double scale = fmax(fabs(exact), mean);
  if (m->squares) scale = sqrt(scale * mean);
  return difference == 0 ? 0 : fabs(difference) / scale;
}

double ylm__measure_error(const measure *m, const float *row, const float *exact,
                          const float n[3]) {
  double a[3], b[3], worst = 0;
  size_t width = (size_t)m->channels * ylm_sh_count(m->lmax);
  if (m->kind == YLM_GRID_COEFFICIENTS) return ylm__row_distance(row, exact, width, m->floor);
  ylm__measure_irradiance(m, row, n, a);
  ylm__measure_irradiance(m, exact, n, b);
  for (int c = 0; c < m->channels; c++) {
    double error = relative(m, a[c] - b[c], b[c], m->mean[c]);
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

double ylm__measure_anywhere(const measure *m, const float *row, const float *exact) {
  size_t count = ylm_sh_count(m->lmax);
  double worst = 0;
  if (m->kind == YLM_GRID_COEFFICIENTS)
    return ylm__row_distance(row, exact, (size_t)m->channels * count, m->floor);
  for (int c = 0; c < m->channels; c++, row += count, exact += count) {
    double d = 0, e = 0;
    for (int l = 0; l <= m->lmax; l++) {
      double a = ylm_sh_cosine_factor(l) * ylm_sh_cosine_factor(l) / (4 * YLM_PI);
      for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++) {
        double x = (double)row[k] - (double)exact[k];
        d += a * x * x;
        e += a * (double)exact[k] * (double)exact[k];
      }
    }
    double error = relative(m, sqrt(d), sqrt(e), m->mean[c]);
    if (!(error <= worst)) worst = error;
  }
  return worst;
}
