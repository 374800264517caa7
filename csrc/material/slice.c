/* slice.c - the slice f wi.z of a view in spherical harmonics, by quadrature about the mirror direction. */
#include "slice.h"

#include <math.h>

#include "ylm_sh.h"

#define PI 3.14159265358979323846
/* Nodes in angle from the mirror direction: doubled from the least to the most. Twice as many in azimuth. */
#define LEAST_NODES 24
#define MOST_NODES 192
/* The change of coefficients, relative to the slice's norm, at which they are enough. */
#define SETTLED 1e-4
/* Nodes crowd towards the mirror direction as sinh(CROWD u): the first tenth of them lies within a fiftieth of
   the angle. */
#define CROWD 6.0

struct slice_room {
  int lmax;
  double x[MOST_NODES], weight[MOST_NODES]; /* Gauss's rule on 0 .. 1, */
  int nodes;                                /* of so many nodes */
  float wi[MOST_NODES][3], wo[MOST_NODES][3], f[MOST_NODES][3], turned[MOST_NODES][3];
  double *y;      /* [MOST_NODES][count] */
  double *before; /* [3][count] */
  double d[MOST_NODES][3], measure[MOST_NODES];
};

slice_room *ylm__slice_room(int lmax) {
  slice_room *r = ylm_alloc_zero(1, sizeof *r);
  size_t count = ylm_sh_count(lmax);
  if (!r) return NULL;
  r->lmax = lmax;
  r->y = ylm_alloc(MOST_NODES * count, sizeof *r->y);
  r->before = ylm_alloc(3 * count, sizeof *r->before);
  if (r->y && r->before) return r;
  ylm__slice_room_free(r);
  return NULL;
}

void ylm__slice_room_free(slice_room *r) {
  if (!r) return;
  ylm_free(r->y);
  ylm_free(r->before);
  ylm_free(r);
}

/* The nodes of a half plane through the mirror direction of a view, at azimuth `phi` about it: directions from
   there to the horizon, and what their values count. */
static void half_plane(slice_room *r, double angle, double phi) {
  double s = sin(angle), c = cos(angle), end = atan2(c, -cos(phi) * s);
  for (int i = 0; i < r->nodes; i++) {
    double t = end * sinh(CROWD * r->x[i]) / sinh(CROWD);
    double slope = end * CROWD * cosh(CROWD * r->x[i]) / sinh(CROWD);
    double st = sin(t), ct = cos(t), along = st * cos(phi);
    r->d[i][0] = along * c - ct * s;
    r->d[i][1] = st * sin(phi);
    r->d[i][2] = along * s + ct * c;
    r->measure[i] = st * slope * r->weight[i];
  }
}

/* Adds a half plane, whose nodes count `step` times. */
static ylm_status add(const ylm_material *m, slice_room *r, double azimuth, bool cosine,
                      double step, material_slice *out) {
  size_t count = ylm_sh_count(r->lmax), n = (size_t)r->nodes;
  double ca = cos(azimuth), sa = sin(azimuth);
  for (size_t i = 0; i < n; i++) {
    const double *d = r->d[i];
    r->wi[i][0] = (float)(ca * d[0] - sa * d[1]);
    r->wi[i][1] = (float)(sa * d[0] + ca * d[1]);
    r->wi[i][2] = (float)d[2];
  }
  ylm_material_eval(m, n, (const float(*)[3])r->wi, (const float(*)[3])r->wo, r->f);
  ylm_status s = ylm_sh_eval(r->lmax, 0, false, YLM_DOUBLE, n, r->d, r->y, NULL, NULL, 1, NULL);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    double w = r->measure[i] * step, z = cosine ? r->d[i][2] : 1;
    const double *y = r->y + i * count;
    for (size_t c = 0; c < 3; c++) {
      double value = (double)r->f[i][c] * z, part = w * value;
      double *to = out->c + c * count;
      if (value == 0) continue;
      out->total[c] += part * value;
      for (size_t k = 0; k < count; k++) to[k] += part * y[k];
    }
  }
  return s;
}

/* The slice by so many nodes. */
static ylm_status integrate(const ylm_material *m, slice_room *r, int nodes, double angle,
                            double azimuth, bool cosine, material_slice *out) {
  size_t count = ylm_sh_count(r->lmax);
  ylm_status s = YLM_OK;
  r->nodes = nodes;
  ylm_sh_gauss_legendre(nodes, r->x, r->weight);
  for (int i = 0; i < nodes; i++) {
    r->x[i] = (r->x[i] + 1) / 2, r->weight[i] /= 2;
    r->wo[i][0] = (float)(sin(angle) * cos(azimuth));
    r->wo[i][1] = (float)(sin(angle) * sin(azimuth));
    r->wo[i][2] = (float)cos(angle);
  }
  for (size_t k = 0; k < 3 * count; k++) out->c[k] = 0;
  for (int c = 0; c < 3; c++) out->total[c] = 0;
  bool symmetric = ylm_material_isotropic(m);
  int planes = symmetric ? nodes : 2 * nodes;
  for (int k = 0; s == YLM_OK && k < planes; k++) {
    half_plane(r, angle, PI * (k + 0.5) / nodes);
    s = add(m, r, azimuth, cosine, PI / nodes * (symmetric ? 2 : 1), out);
  }
  if (symmetric) /* the other half has the other sign */
    for (size_t c = 0; c < 3; c++)
      for (int l = 1; l <= r->lmax; l++)
        for (int q = 1; q <= l; q++) out->c[c * count + (size_t)(l * l + l - q)] = 0;
  return s;
}

ylm_status ylm__slice(const ylm_material *m, slice_room *r, double angle, double azimuth,
                      bool cosine, material_slice *out) {
  size_t n = 3 * ylm_sh_count(r->lmax);
  ylm_status s = integrate(m, r, LEAST_NODES, angle, azimuth, cosine, out);
  for (int nodes = 2 * LEAST_NODES; s == YLM_OK && nodes <= MOST_NODES; nodes *= 2) {
    double change = 0, total = 0;
    for (size_t k = 0; k < n; k++) r->before[k] = out->c[k];
    s = integrate(m, r, nodes, angle, azimuth, cosine, out);
    for (size_t k = 0; k < n; k++)
      change += (out->c[k] - r->before[k]) * (out->c[k] - r->before[k]);
    for (int c = 0; c < 3; c++) total += out->total[c];
    if (change <= SETTLED * SETTLED * total) break;
  }
  return s;
}
