/* phong.c - f = base / pi + specular (n + 2) / (2 pi) max(0, cos a)^n, a the angle from the mirror
   direction (Lafortune & Willems 1994, "Using the Modified Phong Reflectance Model"): numbers n,
   specular [3], base [3]. The plain form judges the kernels. */
#include "phong.h"

#include <math.h>

#include "kernels.h"
#include "kind.h"
#include "plain.h"

enum { EXPONENT, SPECULAR, BASE = SPECULAR + 3, NUMBERS = BASE + 3 };

static ylm_status check(const float *x, ylm_error *e) {
  static const char *const names[] = {"red", "green", "blue"};
  if (!(x[EXPONENT] >= 0 && x[EXPONENT] <= 1e5f))
    return ylm_fail(e, YLM_EDOMAIN, "exponent must be from 0 to 1e5, got %g", (double)x[EXPONENT]);
  for (int c = 0; c < 6; c++)
    if (!(x[SPECULAR + c] >= 0 && x[SPECULAR + c] <= 1))
      return ylm_fail(e, YLM_EDOMAIN, "the %s's %s must be from 0 to 1, got %g",
                      c < 3 ? "specular" : "base", names[c % 3], (double)x[SPECULAR + c]);
  for (int c = 0; c < 3; c++)
    if (x[SPECULAR + c] + x[BASE + c] > 1 + 1e-6f)
      return ylm_fail(
          e, YLM_EDOMAIN,
          "base + specular must not be more than 1, which would reflect more light than "
          "comes; their %s is %g",
          names[c], (double)(x[SPECULAR + c] + x[BASE + c]));
  return YLM_OK;
}

static ylm_status prepare(ylm_material *m, ylm_error *e) {
  (void)e;
  phong *g = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  m->table = g;
  m->bytes = sizeof *g;
  double n = (double)m->x[EXPONENT], specular = 0, base = 0;
  g->exponent = m->x[EXPONENT];
  g->density = (float)((n + 1) / (2 * YLM_PI));
  for (int c = 0; c < 3; c++) {
    specular += (double)m->x[SPECULAR + c];
    base += (double)m->x[BASE + c];
    g->lobe[c] = (float)((double)m->x[SPECULAR + c] * (n + 2) / (2 * YLM_PI));
    g->base[c] = (float)((double)m->x[BASE + c] / YLM_PI);
  }
  g->share = base == 0 ? 1 : specular == 0 ? 0 : (float)fmax(0.1, specular / (specular + base));
  return YLM_OK;
}

static bool isotropic(const ylm_material *m) {
  (void)m;
  return true;
}

/* -- the plain form --------------------------------------------------------------- */

/* max(0, 1 - t)^n, where t is half the square of a distance of two directions. */
static double power(double square, double n) {
  double t = square / 2;
  return t < 1 ? exp(n * log1p(-t)) : 0;
}

/* f and the density of samples for two directions above the surface: of the lobe and of what is
   mirrored in the surface, as visible.h has it. */
static double both(const void *p, const double wi[3], const double wo[3], double f[3]) {
  const phong *g = p;
  double x = wi[0] + wo[0], y = wi[1] + wo[1], near = wi[2] - wo[2], far = wi[2] + wo[2];
  double lobe = power(x * x + y * y + near * near, (double)g->exponent);
  double image = power(x * x + y * y + far * far, (double)g->exponent);
  for (int c = 0; c < 3; c++) f[c] = (double)g->base[c] + (double)g->lobe[c] * lobe;
  return (double)g->share * (double)g->density * (lobe + image) +
         (1 - (double)g->share) * wi[2] / YLM_PI;
}

/* A direction of the lobe about the mirror direction. */
static void lobe(const phong *g, const double wo[3], const float u[3], double wi[3]) {
  double t = -expm1(log1p(-(double)u[1]) / ((double)g->exponent + 1)),
         turn = 2 * YLM_PI * (double)u[0];
  double s = sqrt(t * (2 - t)), x = -wo[0], y = -wo[1], k = 1 / (1 + wo[2]);
  double a = s * cos(turn), b = s * sin(turn);
  wi[0] = a * (1 - x * x * k) - b * x * y * k + (1 - t) * x;
  wi[1] = -a * x * y * k + b * (1 - y * y * k) + (1 - t) * y;
  wi[2] = fabs(-a * x - b * y + (1 - t) * wo[2]);
}

/* A direction of the lobe, or as the cosine. */
static void choose(const void *p, const double wo[3], const float u[3], double wi[3]) {
  const phong *g = p;
  if (u[2] < g->share)
    lobe(g, wo, u, wi);
  else
    ylm__plain_cosine(u, wi);
}

PLAIN_KERNELS(phong)

/* -- the kind ------------------------------------------------------------------- */

const material_kind ylm__material_phong = {.name = "phong",
                                           .numbers = NUMBERS,
                                           .check = check,
                                           .prepare = prepare,
                                           .isotropic = isotropic,
                                           .kernels = ylm__material_phong_kernels};
