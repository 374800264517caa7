/* ggx.c - surfaces of GGX microfacets: numbers alpha along the tangent and across it, f0 [3], base
   [3], whether light lost between microfacets comes back. The plain form judges the kernels. */
#include "ggx.h"

#include <math.h>
#include <string.h>

#include "gen/material.h"
#include "kernels.h"
#include "kind.h"
#include "plain.h"

enum { ALPHA_X, ALPHA_Y, F0, BASE = F0 + 3, COMPENSATE = BASE + 3, NUMBERS };

static ylm_status check(const float *x, ylm_error *e) {
  static const char *const names[] = {"red", "green", "blue"};
  for (int i = 0; i < 2; i++)
    if (!(x[ALPHA_X + i] >= 1e-3f && x[ALPHA_X + i] <= 1))
      return ylm_fail(e, YLM_EDOMAIN, "alpha must be from 0.001 to 1, got %g", (double)x[i]);
  for (int c = 0; c < 6; c++)
    if (!(x[F0 + c] >= 0 && x[F0 + c] <= 1))
      return ylm_fail(e, YLM_EDOMAIN, "the %s's %s must be from 0 to 1, got %g",
                      c < 3 ? "f0" : "base", names[c % 3], (double)x[F0 + c]);
  return YLM_OK;
}

/* -- albedo -------------------------------------------------------------------- */

/* The first of four knots about x in 0 .. YLM__ALBEDO_KNOTS-1, and their weights in the cubic. */
static int cubic(double x, double w[4]) {
  int k = (int)x - 1;
  if (k < 0) k = 0;
  if (k > YLM__ALBEDO_KNOTS - 4) k = YLM__ALBEDO_KNOTS - 4;
  double t = x - k;
  w[0] = -(t - 1) * (t - 2) * (t - 3) / 6;
  w[1] = t * (t - 2) * (t - 3) / 2;
  w[2] = -t * (t - 1) * (t - 3) / 2;
  w[3] = t * (t - 1) * (t - 2) / 6;
  return k;
}

/* The curve of a roughness from the table. */
static void find_curve(double alpha, ggx *g) {
  const double least = sqrt(YLM__ALBEDO_LEAST), knots = YLM__ALBEDO_KNOTS - 1;
  double row[4], column[4];
  int r = cubic((sqrt(alpha) - least) / (1 - least) * knots, row);
  for (int i = 0; i <= GGX_CURVE + 1; i++) {
    double s = i < GGX_CURVE ? (double)i / GGX_CURVE : 1, sum[2] = {0};
    int c = cubic(s * knots, column);
    for (int y = 0; y < 4; y++)
      for (int x = 0; x < 4; x++)
        for (int k = 0; k < 2; k++)
          sum[k] += row[y] * column[x] * (double)ylm__material_albedo[r + y][c + x][k];
    double scale = 65535 / fmax(1, sum[0] + sum[1]); /* rounded down: their sum is at most 1 */
    g->curve[i] = (uint32_t)(fmax(0, sum[0]) * scale) + ((uint32_t)(fmax(0, sum[1]) * scale) << 16);
  }
}

/* A and B at a cosine. */
static void curve_at(const ggx *g, double cosine, double *A, double *B) {
  double s = sqrt(cosine) * GGX_CURVE;
  int i = s < GGX_CURVE ? (int)s : GGX_CURVE - 1;
  double t = s - i;
  uint32_t a = g->curve[i], b = g->curve[i + 1];
  *A = ((a & 65535) * (1 - t) + (b & 65535) * t) / 65535;
  *B = ((a >> 16) * (1 - t) + (b >> 16) * t) / 65535;
}

/* Their averages over the cosine. */
static void average(const ggx *g, double *A, double *B) {
  const int n = 4096;
  *A = *B = 0;
  for (int i = 0; i < n; i++) {
    double a, b;
    curve_at(g, sqrt((i + 0.5) / n), &a, &b);
    *A += a / n, *B += b / n;
  }
}

/* Albedo of all above the base in channel c. */
static double above(const ggx *g, int c, double A, double B) {
  return (double)g->f0[c] * A + B + (double)g->K[c] * (1 - A - B);
}

static ylm_status prepare(ylm_material *m, ylm_error *e) {
  (void)e;
  const float *x = m->x;
  ggx *g = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  m->table = g;
  m->bytes = sizeof *g;
  g->ax = x[ALPHA_X], g->ay = x[ALPHA_Y];
  memcpy(g->f0, x + F0, sizeof g->f0);
  memcpy(g->colour, x + BASE, sizeof g->colour);
  g->plain = x[COMPENSATE] == 0 && x[BASE] == 0 && x[BASE + 1] == 0 && x[BASE + 2] == 0;
  double A, B, ax = (double)g->ax, ay = (double)g->ay;
  find_curve(sqrt((ax * ax + ay * ay) / 2), g);
  average(g, &A, &B);
  double E = A + B;
  for (int c = 0; c < 3; c++) {
    double f0 = (double)g->f0[c], F = f0 + (1 - f0) / 21;
    double K = x[COMPENSATE] != 0 ? F * F * E / (1 - F * (1 - E)) : 0;
    g->K[c] = (float)K;
    g->lost[c] = E < 1 - 1e-6 ? (float)(K / (YLM_PI * (1 - E))) : 0;
    double over = above(g, c, A, B);
    g->base[c] = over < 1 - 1e-6 ? (float)((double)g->colour[c] / (YLM_PI * (1 - over))) : 0;
  }
  return YLM_OK;
}

static bool isotropic(const ylm_material *m) { return m->x[ALPHA_X] == m->x[ALPHA_Y]; }

static void mean(const ylm_material *m, float albedo[3]) {
  const ggx *g = m->table;
  double A, B;
  if (!isotropic(m)) {
    ylm__material_mean(m, albedo);
    return;
  }
  average(g, &A, &B);
  for (int c = 0; c < 3; c++) {
    double over = above(g, c, A, B);
    albedo[c] = (float)fmin(1, over + (double)g->colour[c] * (1 - over));
  }
}

static void reflectance(const ylm_material *m, size_t n, const float (*wo)[3], float (*albedo)[3]) {
  const ggx *g = m->table;
  if (!isotropic(m)) {
    ylm__material_reflectance(m, n, wo, albedo);
    return;
  }
  for (size_t i = 0; i < n; i++) {
    double A, B;
    curve_at(g, fmax(0, (double)wo[i][2]), &A, &B);
    for (int c = 0; c < 3; c++) {
      double over = above(g, c, A, B);
      albedo[i][c] = wo[i][2] > 0 ? (float)(over + (double)g->colour[c] * (1 - over)) : 0;
    }
  }
}

/* -- the plain form --------------------------------------------------------------- */

/* sqrt(z^2 + ax^2 x^2 + ay^2 y^2). */
static double root(const ggx *g, const double w[3]) {
  double x = w[0] * (double)g->ax, y = w[1] * (double)g->ay;
  return sqrt(w[2] * w[2] + x * x + y * y);
}

/* D of the normal along h. */
static double ndf(const ggx *g, double x, double y, double z) {
  double ax = (double)g->ax, ay = (double)g->ay, e = x * x / (ax * ax) + y * y / (ay * ay) + z * z;
  double q = (x * x + y * y + z * z) / fmax(e, 1e-30);
  return q * q / (YLM_PI * ax * ay);
}

/* The share of mirrored directions among samples. */
static double share_of(const ggx *g, double cosine) {
  if (g->plain) return 1;
  double A, B, mirrored = 0, rest = 0;
  curve_at(g, cosine, &A, &B);
  for (int c = 0; c < 3; c++) {
    double K = (double)g->K[c] * (1 - A - B);
    mirrored += (double)g->f0[c] * A + B;
    rest += K + (double)g->colour[c] * (1 - above(g, c, A, B));
  }
  return fmax(0.1, mirrored / (mirrored + rest));
}

/* f and the density of samples for two directions above the surface. */
static double both(const void *p, const double wi[3], const double wo[3], double f[3]) {
  const ggx *g = p;
  double h[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]}, gz = wo[2] - wi[2];
  double square = h[0] * h[0] + h[1] * h[1] + h[2] * h[2];
  double image = h[0] * h[0] + h[1] * h[1] + gz * gz, ro = root(g, wo);
  double D = ndf(g, h[0], h[1], h[2]), also = 0;
  if (gz > 0 && image > MATERIAL_FOLDED) also = ndf(g, h[0], h[1], gz);
  double schlick = pow(1 - sqrt(square) / 2, 5), Ai, Bi, Ao, Bo;
  curve_at(g, wi[2], &Ai, &Bi);
  curve_at(g, wo[2], &Ao, &Bo);
  for (int c = 0; c < 3; c++) {
    double f0 = (double)g->f0[c], F = f0 + (1 - f0) * schlick;
    f[c] = F * D / fmax(1e-30, 2 * (wo[2] * root(g, wi) + wi[2] * ro));
    f[c] += (double)g->lost[c] * (1 - Ai - Bi) * (1 - Ao - Bo);
    f[c] += (double)g->base[c] * (1 - above(g, c, Ai, Bi)) * (1 - above(g, c, Ao, Bo));
  }
  double share = share_of(g, wo[2]);
  return share * (D + also) / (2 * (wo[2] + ro)) + (1 - share) * wi[2] / YLM_PI;
}

/* A direction: mirrored, or as the cosine. */
static void choose(const void *p, const double wo[3], const float u[3], double wi[3]) {
  const ggx *g = p;
  if ((double)u[2] < share_of(g, fmax(0, wo[2])))
    ylm__plain_mirrored((double)g->ax, (double)g->ay, wo, u, wi);
  else
    ylm__plain_cosine(u, wi);
}

PLAIN_KERNELS(ggx)

/* -- the kind ------------------------------------------------------------------- */

const material_kind ylm__material_ggx = {.name = "ggx",
                                         .numbers = NUMBERS,
                                         .check = check,
                                         .prepare = prepare,
                                         .mean = mean,
                                         .reflectance = reflectance,
                                         .isotropic = isotropic,
                                         .mirrored = true,
                                         .kernels = ylm__material_ggx_kernels};
