/* matte.c - matte (Lambertian) surfaces: albedo / pi times irradiance leaves in every direction. */
#include <math.h>
#include <string.h>

#include "gen/material.h"
#include "kernels.h"
#include "kind.h"

static ylm_status check(const float *albedo, ylm_error *e) {
  static const char *const names[] = {"red", "green", "blue"};
  for (int c = 0; c < 3; c++)
    if (!(albedo[c] >= 0 && albedo[c] <= 1))
      return ylm_fail(e, YLM_EDOMAIN, "the albedo's %s must be from 0 to 1, got %g", names[c],
                      (double)albedo[c]);
  return YLM_OK;
}

/* The clamped cosine: a[l] = 2 pi * integral of t P_l(t) over 0 <= t <= 1, as the recurrence
   a[l+2] = -a[l] (l-1)/(l+4) of even l. */
static ylm_status transfer(int lmax, double *a) {
  for (int l = 0; l <= lmax; l++)
    a[l] = l == 0   ? YLM_PI
           : l == 1 ? 2 * YLM_PI / 3
           : l == 2 ? YLM_PI / 4
           : l % 2  ? 0
                    : -a[l - 2] * (l - 3) / (l + 2);
  return YLM_OK;
}

static void copy(const float *albedo, float *out) { memcpy(out, albedo, 3 * sizeof *out); }

static void mean(const ylm_material *m, float albedo[3]) { copy(m->x, albedo); }

static void reflectance(const ylm_material *m, size_t n, const float (*wo)[3], float (*albedo)[3]) {
  for (size_t i = 0; i < n; i++)
    for (int c = 0; c < 3; c++) albedo[i][c] = wo[i][2] > 0 ? m->x[c] : 0;
}

static void radiance(const float *albedo, size_t n, float *light) {
  for (size_t i = 0; i < 3 * n; i += 3)
    for (size_t c = 0; c < 3; c++) light[i + c] = matte_radiance(light[i + c], albedo[c]);
}

static void reflect(const float *albedo, const double irradiance[3], float out[3]) {
  for (int c = 0; c < 3; c++) out[c] = (float)(irradiance[c] / YLM_PI) * albedo[c];
}

static bool isotropic(const ylm_material *m) {
  (void)m;
  return true;
}

/* -- the plain form --------------------------------------------------------------- */

static void eval_plain(const void *albedo, size_t n, const float (*wi)[3], const float (*wo)[3],
                       float (*f)[3]) {
  for (size_t i = 0; i < n; i++)
    for (int c = 0; c < 3; c++)
      f[i][c] = wi[i][2] > 0 && wo[i][2] > 0 ? ((const float *)albedo)[c] * (float)(1 / YLM_PI) : 0;
}

/* Directions as the cosine: a place on the unit disk, raised to the sphere. */
static void sample_plain(const void *albedo, size_t n, const float (*wo)[3], const float (*u)[3],
                         float (*wi)[3], float (*weight)[3], float *pdf) {
  for (size_t i = 0; i < n; i++) {
    float z = sqrtf(1 - u[i][0]), r = sqrtf(u[i][0]), angle = (float)(2 * YLM_PI) * u[i][1];
    bool above = wo[i][2] > 0;
    wi[i][0] = r * cosf(angle);
    wi[i][1] = r * sinf(angle);
    wi[i][2] = z;
    pdf[i] = above ? z * (float)(1 / YLM_PI) : 0;
    for (int c = 0; c < 3; c++) weight[i][c] = above ? ((const float *)albedo)[c] : 0;
  }
}

static void pdf_plain(const void *albedo, size_t n, const float (*wi)[3], const float (*wo)[3],
                      float *out) {
  (void)albedo;
  for (size_t i = 0; i < n; i++)
    out[i] = wi[i][2] > 0 && wo[i][2] > 0 ? wi[i][2] * (float)(1 / YLM_PI) : 0;
}

const material_kernels ylm__material_matte_plain = {eval_plain, sample_plain, pdf_plain};

/* -- the kind ------------------------------------------------------------------- */

const material_kind ylm__material_matte = {.name = "matte",
                                           .numbers = 3,
                                           .check = check,
                                           .mean = mean,
                                           .reflectance = reflectance,
                                           .transfer = transfer,
                                           .radiance = radiance,
                                           .reflect = reflect,
                                           .row = copy,
                                           .isotropic = isotropic,
                                           .kernels = ylm__material_matte_kernels};
