/* gather_plain.c - one virtual light at one point, in plain code and double. */
#include <math.h>

#include "gather.h"

/* Widths of Gaussian lights in radii, and how softly they turn: ylm_light_virtual.h. */
#define WIDTH2 0.25
#define SOFT2 (0.25 / 16)

/* The factor of all degrees; with *decay that of degree l is times decay^(l (l+1)/2). */
static double profile(const gather_lights *l, const gather_ask *a, double r, double d2,
                      double *decay) {
  double sg2 = WIDTH2 * r * r, o = d2 * d2 * (double)a->core;
  double gauss = d2 > 0 ? -expm1(-2 * d2 / sg2) / d2 : 2 / sg2;
  double far = d2 > 0 ? -expm1(-o) / d2 : 0;
  *decay = exp(-sg2 / fmax(d2, 1e-300));
  switch (l->form.profile) {
  case YLM_LIGHT_VIRTUAL_POINT: *decay = 1; return d2 > 0 ? 1 / d2 : 0;
  case YLM_LIGHT_VIRTUAL_FAR: return far;
  case YLM_LIGHT_VIRTUAL_NEAR: return gauss - far;
  default: return gauss;
  }
}

/* sum over l of z_l G_l P_l(c). */
static double by_degrees(const gather_lights *l, const gather_ask *a, double r, double d2,
                         double c) {
  double decay, G = profile(l, a, r, d2, &decay), A = 1, q = 1, P0 = 1, P1 = c;
  double sum = (double)a->zonal[0];
  for (int k = 1; k <= a->o->lmax; k++) {
    q *= decay;
    A *= q;
    sum += (double)a->zonal[k] * A * P1;
    double P2 = ((2 * k + 1) * c * P1 - k * P0) / (k + 1);
    P0 = P1, P1 = P2;
  }
  return G * sum;
}

/* The sum for a cap, whose degrees are its own: G_l = 2 P_l'(alpha)/(l (l+1) max(d, r)^2). */
static double by_cap(const gather_ask *a, double r, double d2, double c) {
  double most = fmax(d2, r * r), alpha = sqrt(fmax(0, 1 - r * r / most));
  double P0 = 1, P1 = c, Q0 = 1, Q1 = alpha, D0 = 0, D1 = 1; /* of c; of alpha, its slopes */
  double sum = (double)a->zonal[0] * 2 / (1 + alpha);
  for (int k = 1; k <= a->o->lmax; k++) {
    sum += (double)a->zonal[k] * 2 * D1 / (k * (k + 1.0)) * P1;
    double P2 = ((2 * k + 1) * c * P1 - k * P0) / (k + 1);
    double Q2 = ((2 * k + 1) * alpha * Q1 - k * Q0) / (k + 1), D2 = D0 + (2 * k + 1) * Q1;
    P0 = P1, P1 = P2, Q0 = Q1, Q1 = Q2, D0 = D1, D1 = D2;
  }
  return sum / most;
}

/* The paper's Eq. 22: a smooth step of the angle above the horizon, from -a to a. */
static double above(double r, double d2, double c) {
  double half = asin(fmin(1, r / sqrt(fmax(d2, 1e-300))));
  double t = half > 0 ? fmin(1, fmax(0, (asin(c) + half) / (2 * half))) : c > 0;
  return t * t * (3 - 2 * t);
}

double ylm__gather_weight(const gather_lights *l, const gather_ask *a, size_t i, const float x[3],
                          const float N[3]) {
  const ylm_shade_gather_options *o = a->o;
  double d2 = 0, up = 0, along = 0, r = (double)l->radius[i], eps2 = 0;
  for (int k = 0; k < 3; k++) {
    double v = (double)l->at[k][i] - (double)x[k];
    d2 += v * v;
    up += v * (double)N[k];
    along -= v * (double)l->normal[k][i];
  }
  double d = sqrt(d2), c = d > 0 ? up / d : 0;
  bool soft = o->method == YLM_SHADE_HVL && l->form.profile != YLM_LIGHT_VIRTUAL_CAP &&
              l->form.profile != YLM_LIGHT_VIRTUAL_POINT;
  if (soft) eps2 = SOFT2 * r * r;
  double D = sqrt(d2 + eps2);
  double cosine = fmax(0, (double)l->shift[i] + (D > 0 ? along / D : 0));
  if (o->method == YLM_SHADE_VPL)
    return d2 > 0 ? ylm__gather_bound(a, fmax(0, c) * cosine / d2, d2) : 0;
  if (o->horizon == YLM_SHADE_HORIZON_GATE && up < -r) return 0;
  if (o->horizon == YLM_SHADE_HORIZON_PAPER) cosine *= above(r, d2, c);
  c = fmin(1, fmax(-1, c));
  return cosine * (l->form.profile == YLM_LIGHT_VIRTUAL_CAP ? by_cap(a, r, d2, c)
                                                            : by_degrees(l, a, r, d2, c));
}
