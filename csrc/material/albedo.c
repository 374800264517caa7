/* albedo.c - reflectances by quadrature of what a material samples, for any kind. */
#include <math.h>

#include "calibration.h"
#include "kind.h"

/* Point i of the additive sequence of d <= 5 coordinates whose steps are powers of 1/g, with
   g^(d+1) = g + 1 (Roberts 2018). */
static void place(size_t i, int d, float *u) {
  static const double g[] = {0,
                             1.6180339887498948482,
                             1.3247179572447460260,
                             1.2207440846057594754,
                             1.1673039782614186843,
                             1.1347241384015194926};
  double step = 1;
  for (int k = 0; k < d; k++) {
    step /= g[d];
    double x = 0.5 + step * (double)(i + 1);
    u[k] = fminf((float)(x - floor(x)), 0x1.fffffep-1f);
  }
}

/* Adds n <= ALBEDO_BATCH weights to sums. */
static void add(const ylm_material *m, size_t n, const float (*wo)[3], const float (*u)[3],
                double sum[3]) {
  float wi[ALBEDO_BATCH][3], weight[ALBEDO_BATCH][3], pdf[ALBEDO_BATCH];
  ylm_material_sample(m, n, wo, u, wi, weight, pdf);
  for (size_t i = 0; i < n; i++)
    for (int c = 0; c < 3; c++) sum[c] += (double)weight[i][c];
}

static void put(const double sum[3], size_t n, float albedo[3]) {
  for (int c = 0; c < 3; c++) albedo[c] = (float)(sum[c] / (double)n);
}

void ylm__material_mean(const ylm_material *m, float albedo[3]) {
  const size_t n = ALBEDO_MEAN_SAMPLES;
  float wo[ALBEDO_BATCH][3], u[ALBEDO_BATCH][3], p[5];
  double sum[3] = {0};
  for (size_t i = 0; i < n; i += ALBEDO_BATCH) {
    for (size_t k = 0; k < ALBEDO_BATCH; k++) {
      place(i + k, 5, p);
      float r = sqrtf(p[3]), angle = (float)(2 * YLM_PI) * p[4];
      wo[k][0] = r * cosf(angle);
      wo[k][1] = r * sinf(angle);
      wo[k][2] = sqrtf(1 - p[3]);
      for (int a = 0; a < 3; a++) u[k][a] = p[a];
    }
    add(m, ALBEDO_BATCH, (const float(*)[3])wo, (const float(*)[3])u, sum);
  }
  put(sum, n, albedo);
}

/* The square's mean is that of pi f times the weight of directions which the material chooses: narrow lobes are not missed. */
static float excess_at(const ylm_material *m, float cosine) {
  float wo[ALBEDO_BATCH][3], u[ALBEDO_BATCH][3], wi[ALBEDO_BATCH][3], weight[ALBEDO_BATCH][3];
  float pdf[ALBEDO_BATCH], f[ALBEDO_BATCH][3], p[4], r = sqrtf(1 - cosine * cosine);
  double square[3] = {0}, mean[3] = {0}, squares = 0, means = 0;
  for (size_t i = 0; i < EXCESS_SAMPLES; i += ALBEDO_BATCH) {
    for (size_t k = 0; k < ALBEDO_BATCH; k++) {
      place(i + k, 4, p);
      float angle = (float)(2 * YLM_PI) * p[3];
      wo[k][0] = r * cosf(angle), wo[k][1] = r * sinf(angle), wo[k][2] = cosine;
      for (int a = 0; a < 3; a++) u[k][a] = p[a];
    }
    ylm_material_sample(m, ALBEDO_BATCH, (const float(*)[3])wo, (const float(*)[3])u, wi, weight,
                        pdf);
    ylm_material_eval(m, ALBEDO_BATCH, (const float(*)[3])wi, (const float(*)[3])wo, f);
    for (size_t k = 0; k < ALBEDO_BATCH; k++)
      for (int c = 0; c < 3; c++) {
        square[c] += YLM_PI * (double)f[k][c] * (double)weight[k][c] / EXCESS_SAMPLES;
        mean[c] += (double)weight[k][c] / EXCESS_SAMPLES;
      }
  }
  for (int c = 0; c < 3; c++) squares += square[c], means += mean[c] * mean[c];
  return means > 0 ? (float)fmax(0, squares / means - 1) : 0;
}

void ylm__material_fill_excess(ylm_material *m) {
  for (int k = 0; k < MATERIAL_EYES; k++)
    m->excess[k] = excess_at(m, ((float)k + 0.5f) / MATERIAL_EYES);
}

void ylm__material_reflectance(const ylm_material *m, size_t n, const float (*wo)[3],
                               float (*albedo)[3]) {
  const size_t points = ALBEDO_SAMPLES;
  float same[ALBEDO_BATCH][3], u[ALBEDO_BATCH][3];
  for (size_t i = 0; i < n; i++) {
    double sum[3] = {0};
    for (size_t k = 0; k < ALBEDO_BATCH; k++)
      for (int a = 0; a < 3; a++) same[k][a] = wo[i][a];
    for (size_t k = 0; k < points; k += ALBEDO_BATCH) {
      for (size_t j = 0; j < ALBEDO_BATCH; j++) place(k + j, 3, u[j]);
      add(m, ALBEDO_BATCH, (const float(*)[3])same, (const float(*)[3])u, sum);
    }
    put(sum, points, albedo[i]);
  }
}
