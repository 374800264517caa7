/* many_plain.c - one virtual light at one point, in plain code and double. */
#include <math.h>

#include "many_gloss.h"

/* Widths of Gaussian lights in radii, and how softly they turn: ylm_light_virtual.h. */
#define WIDTH2 0.25
#define SOFT2 (0.25 / 16)

/* The intensity of light i, whose emission has a degree, towards x: out [3]. */
static void send(const ylm_many_lights *l, bool soft, size_t i, const float x[3], float *out,
                 size_t stride) {
  const ylm_many_series *s = l->series;
  double r = soft ? (double)l->radius[i] : 0, d2 = SOFT2 * r * r, u[3], r2 = 0, sum[3] = {0};
  const float *b =
      l->lobe + i / YLM_MANY_LOBES * s->entries * 6 * YLM_MANY_LOBES + i % YLM_MANY_LOBES;
  for (int k = 0; k < 3; k++) {
    u[k] = (double)x[k] - (double)l->at[k][i];
    d2 += u[k] * u[k];
  }
  for (int k = 0; k < 3; k++) {
    u[k] = d2 > 0 ? u[k] / sqrt(d2) : 0;
    r2 += u[k] * u[k];
  }
  double re = 1, im = 0;
  size_t k = 0;
  for (int m = 0; m <= s->lmax; m++) {
    double before = 0, p = (double)s->first[m];
    for (int q = m; q <= s->lmax; q++, k++) {
      const float *at = b + k * 6 * YLM_MANY_LOBES;
      for (int c = 0; c < 3; c++)
        sum[c] += p * (re * (double)at[2 * c * YLM_MANY_LOBES] +
                       im * (double)at[(2 * c + 1) * YLM_MANY_LOBES]);
      double next = (double)s->a[k] * u[2] * p - (double)s->b[k] * r2 * before;
      before = p, p = next;
    }
    double next = re * u[0] - im * u[1];
    im = re * u[1] + im * u[0], re = next;
  }
  for (int c = 0; c < 3; c++) out[(size_t)c * stride] = (float)sum[c];
}

void ylm__many_send(const ylm_many_lights *l, bool soft, size_t first, size_t n, const float x[3],
                    float (*I)[YLM_MANY_CHUNK]) {
  for (size_t k = 0; k < n; k++)
    if (first + k < l->n)
      send(l, soft, first + k, x, I[0] + k, YLM_MANY_CHUNK);
    else
      for (int c = 0; c < 3; c++) I[c][k] = 0;
}

/* The factor of all degrees; with *decay that of degree l is times decay^(l (l+1)/2). */
static double profile(const ylm_many_lights *l, const ylm_many_ask *a, double r, double d2,
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
static double by_degrees(const ylm_many_lights *l, const ylm_many_ask *a, double r, double d2,
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
static double by_cap(const ylm_many_ask *a, double r, double d2, double c) {
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

double ylm__many_above(const ylm_many_lights *l, size_t i, const float x[3], const float N[3]) {
  double d2 = 0, up = 0;
  for (int k = 0; k < 3; k++) {
    double v = (double)l->at[k][i] - (double)x[k];
    d2 += v * v;
    up += v * (double)N[k];
  }
  return above((double)l->radius[i], d2, d2 > 0 ? fmin(1, fmax(-1, up / sqrt(d2))) : 0);
}

/* G_l of light i at the square of a distance, l to lmax. */
static void degrees(const ylm_many_lights *l, const ylm_many_ask *a, size_t i, double d2,
                    double *G) {
  double r = (double)l->radius[i], decay, g, A = 1, q = 1;
  if (l->form.profile == YLM_LIGHT_VIRTUAL_CAP) {
    double most = fmax(d2, r * r), alpha = sqrt(fmax(0, 1 - r * r / most));
    double Q0 = 1, Q1 = alpha, D0 = 0, D1 = 1;
    G[0] = 2 / (1 + alpha) / most;
    for (int k = 1; k <= a->o->lmax; k++) {
      G[k] = 2 * D1 / (k * (k + 1.0)) / most;
      double Q2 = ((2 * k + 1) * alpha * Q1 - k * Q0) / (k + 1), D2 = D0 + (2 * k + 1) * Q1;
      Q0 = Q1, Q1 = Q2, D0 = D1, D1 = D2;
    }
    return;
  }
  G[0] = g = profile(l, a, r, d2, &decay);
  for (int k = 1; k <= a->o->lmax; k++) {
    q *= decay;
    A *= q;
    G[k] = g * A;
  }
}

/* The sum over degrees and orders of a row times G and the harmonics at w, in the frame of the view. */
static double by_orders(const ylm_many_receiver *r, int f, const double *G, const double w[3]) {
  const ylm_many_series *s = r->series;
  const float *plus = r->row + (size_t)(2 * f) * s->entries, *minus = plus + s->entries;
  double re = 1, im = 0, sum = 0;
  size_t k = 0;
  for (int m = 0; m <= s->lmax; m++) {
    double before = 0, p = (double)s->first[m], a = 0, b = 0;
    for (int q = m; q <= s->lmax; q++, k++) {
      a += (double)plus[k] * G[q] * p;
      b += (double)minus[k] * G[q] * p;
      double next = (double)s->a[k] * w[2] * p - (double)s->b[k] * before;
      before = p, p = next;
    }
    sum += re * a + im * b;
    double next = re * w[0] - im * w[1];
    im = re * w[1] + im * w[0], re = next;
  }
  return sum;
}

static double by_zones(const ylm_many_ask *a, const float *z, const double *G, double c) {
  double P0 = 1, P1 = c, sum = (double)z[0] * G[0];
  for (int k = 1; k <= a->o->lmax; k++) {
    sum += (double)z[k] * G[k] * P1;
    double P2 = ((2 * k + 1) * c * P1 - k * P0) / (k + 1);
    P0 = P1, P1 = P2;
  }
  return sum;
}

void ylm__many_gloss_weight(const ylm_many_lights *l, const ylm_many_ask *a,
                            const ylm_many_receiver *r, size_t i, const float x[3], double out[3]) {
  double v[3], w[3] = {0, 0, 1}, d2 = 0, along = 0, R = (double)l->radius[i];
  double G[YLM_MATERIAL_TABLE_LMAX + 1];
  int rows = r->zonal ? 3 : r->functions;
  for (int k = 0; k < 3; k++) {
    v[k] = (double)l->at[k][i] - (double)x[k];
    d2 += v[k] * v[k];
    along -= v[k] * (double)l->normal[k][i];
  }
  bool soft =
      l->form.profile != YLM_LIGHT_VIRTUAL_CAP && l->form.profile != YLM_LIGHT_VIRTUAL_POINT;
  double d = sqrt(d2), D = sqrt(d2 + (soft ? SOFT2 * R * R : 0));
  double cosine = fmax(0, (double)l->shift[i] + (D > 0 ? along / D : 0));
  if (d > 0)
    for (int k = 0; k < 3; k++)
      w[k] = (v[0] * (double)r->axis[k][0] + v[1] * (double)r->axis[k][1] +
              v[2] * (double)r->axis[k][2]) /
             d;
  if (a->o->horizon == YLM_SHADE_HORIZON_GATE && w[2] * d < -R) cosine = 0;
  degrees(l, a, i, d2, G);
  if (d == 0) /* no direction */
    for (int k = 1; k <= a->o->lmax; k++) G[k] = 0;
  double c = 0;
  for (int k = 0; k < 3; k++) c += d > 0 ? v[k] / d * (double)r->lobe[k] : 0;
  size_t row = (size_t)(a->o->lmax + 1);
  double matte = r->zonal ? by_zones(a, a->zonal, G, w[2]) : 0;
  for (int f = 0; f < rows; f++)
    out[f] = cosine * (r->zonal ? fmax(0, w[2]) * by_zones(a, r->lobes + (size_t)f * row, G, c) +
                                      (double)r->base[f] * matte
                                : by_orders(r, f, G, w));
}

double ylm__many_weight(const ylm_many_lights *l, const ylm_many_ask *a, size_t i, const float x[3],
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
  bool soft =
      l->form.profile != YLM_LIGHT_VIRTUAL_CAP && l->form.profile != YLM_LIGHT_VIRTUAL_POINT;
  if (soft) eps2 = SOFT2 * r * r;
  double D = sqrt(d2 + eps2);
  double cosine = fmax(0, (double)l->shift[i] + (D > 0 ? along / D : 0));
  if (o->horizon == YLM_SHADE_HORIZON_GATE && up < -r) return 0;
  if (o->horizon == YLM_SHADE_HORIZON_PAPER) cosine *= above(r, d2, c);
  c = fmin(1, fmax(-1, c));
  return cosine * (l->form.profile == YLM_LIGHT_VIRTUAL_CAP ? by_cap(a, r, d2, c)
                                                            : by_degrees(l, a, r, d2, c));
}
