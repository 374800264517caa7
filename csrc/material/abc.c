/* abc.c - the ABC model: numbers kd [3], a [3], b, c, ior, scale. The plain form judges the
   kernels. */
#include "abc.h"

#include <math.h>

#include "calibration.h"
#include "kernels.h"
#include "kind.h"
#include "plain.h"

enum { KD, A = KD + 3, B = A + 3, C, IOR, SCALE, NUMBERS };

static ylm_status check(const float *x, ylm_error *e) {
  static const char *const names[] = {"kd's red", "kd's green", "kd's blue", "a's red", "a's green",
                                      "a's blue", "b",          "c",         "ior",     "scale"};
  static const float most[] = {1, 1, 1, 1e6f, 1e6f, 1e6f, 1e8f, 100, 1000, 100};
  for (int i = 0; i < NUMBERS; i++) {
    float least = i == IOR ? 1 : 0;
    if (!(x[i] >= least && x[i] <= most[i]))
      return ylm_fail(e, YLM_EDOMAIN, "%s must be from %g to %g, got %g", names[i], (double)least,
                      (double)most[i], (double)x[i]);
  }
  return YLM_OK;
}

/* Roughness at which GGX falls to a quarter where S does, seen along the normal. */
static double roughness(double b, double c) {
  double fall = (pow(4, 1 / fmax(c, 0.05)) - 1) / fmax(b, 1e-6); /* 1 - m.z */
  if (!(fall < 0.29)) return 1;
  return fmax(0.002, sqrt(fall * (2 - fall)) / (1 - fall));
}

static ylm_status prepare(ylm_material *m, ylm_error *e) {
  (void)e;
  const float *x = m->x;
  abc *g = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  m->table = g;
  m->bytes = sizeof *g;
  for (int k = 0; k < 3; k++) {
    g->kd[k] = (float)((double)x[SCALE] * (double)x[KD + k] / YLM_PI);
    g->a[k] = (float)((double)x[SCALE] * (double)x[A + k] / YLM_PI);
  }
  g->b = x[B], g->c = x[C], g->ior = x[IOR];
  g->alpha = (float)roughness((double)g->b, (double)g->c);
  g->share = 0.5f;
  ylm__material_mean(m, m->albedo); /* of these samples; then of the share that it says is glossy */
  double all = 0, diffuse = 0;
  for (int k = 0; k < 3; k++) {
    all += (double)m->albedo[k];
    diffuse += (double)(x[SCALE] * x[KD + k]);
  }
  if (all > 0) g->share = (float)fmin(0.9, fmax(0.1, 1 - diffuse / all));
  return YLM_OK;
}

static bool isotropic(const ylm_material *m) {
  (void)m;
  return true;
}

/* -- the plain form --------------------------------------------------------------- */

/* Reflected by a dielectric at a cosine, unpolarised. */
static double fresnel(double ior, double c) {
  double t = sqrt(fmax(0, ior * ior - 1 + c * c)), s = (c - t) / (c + t);
  double p = (ior * ior * c - t) / (ior * ior * c + t);
  return (s * s + p * p) / 2;
}

/* D of GGX of the normal along (x, y, z). */
static double ndf(double alpha, double x2, double z) {
  double q = (x2 + z * z) / fmax(1e-30, x2 / (alpha * alpha) + z * z);
  return q * q / (YLM_PI * alpha * alpha);
}

/* f and the density of samples for two directions above the surface. */
static double both(const void *p, const double wi[3], const double wo[3], double f[3]) {
  const abc *g = p;
  double x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2], gz = wo[2] - wi[2];
  double flat = x * x + y * y, length = fmax(1e-6, sqrt(flat + z * z));
  double up = z / length, c = length / 2, zi = fmax(1e-6, wi[2]), zo = fmax(1e-6, wo[2]);
  double fall = flat / (length * (length + z)); /* 1 - m.z, without loss of digits */
  double G = fmin(1, 2 * up * fmin(zi, zo) / c);
  double shape = exp(-(double)g->c * log1p((double)g->b * fall)) * G *
                 fresnel((double)g->ior, fmin(1, c)) / (zi * zo);
  for (int k = 0; k < 3; k++) f[k] = (double)g->kd[k] + (double)g->a[k] * shape;
  double alpha = (double)g->alpha, share = (double)g->share;
  double root = sqrt(wo[2] * wo[2] + alpha * alpha * (wo[0] * wo[0] + wo[1] * wo[1]));
  double D =
      ndf(alpha, flat, z) + (gz > 0 && flat + gz * gz > MATERIAL_FOLDED ? ndf(alpha, flat, gz) : 0);
  return share * D / (2 * (wo[2] + root)) + (1 - share) * wi[2] / YLM_PI;
}

/* A direction: mirrored, or as the cosine. */
static void choose(const void *p, const double wo[3], const float u[3], double wi[3]) {
  const abc *g = p;
  if (u[2] < g->share)
    ylm__plain_mirrored((double)g->alpha, (double)g->alpha, wo, u, wi);
  else
    ylm__plain_cosine(u, wi);
}

PLAIN_KERNELS(abc)

/* -- the kind ------------------------------------------------------------------- */

const material_kind ylm__material_abc = {.name = "abc",
                                         .numbers = NUMBERS,
                                         .check = check,
                                         .prepare = prepare,
                                         .isotropic = isotropic,
                                         .kernels = ylm__material_abc_kernels};
