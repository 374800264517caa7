/* matte.c - matte (Lambertian) surfaces: albedo / pi times irradiance leaves in every direction. */
#include <string.h>

#include "gen/material.h"
#include "kind.h"

#define PI 3.14159265358979323846

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
    a[l] = l == 0   ? PI
           : l == 1 ? 2 * PI / 3
           : l == 2 ? PI / 4
           : l % 2  ? 0
                    : -a[l - 2] * (l - 3) / (l + 2);
  return YLM_OK;
}

static void copy(const float *albedo, float *out) { memcpy(out, albedo, 3 * sizeof *out); }

static void radiance(const float *albedo, size_t n, float *light) {
  for (size_t i = 0; i < 3 * n; i += 3)
    for (size_t c = 0; c < 3; c++) light[i + c] = matte_radiance(light[i + c], albedo[c]);
}

static void reflect(const float *albedo, const double irradiance[3], float out[3]) {
  for (int c = 0; c < 3; c++) out[c] = (float)(irradiance[c] / PI) * albedo[c];
}

const material_kind ylm__material_matte = {"matte", 3,        check,   transfer,
                                           copy,    radiance, reflect, copy};
