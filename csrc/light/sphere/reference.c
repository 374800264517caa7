/*
** reference.c - sphere lights by the product rule, one light at a time, in double.
**
** Short and plain; it judges the moment kernels and is the fallback where there are none.
** With v = y - x, d = |v|, h^2 = d^2 - r^2, alpha = h/d, L_lm = F_l(d) Y_lm(v/d):
**
**   F_l   = 2 pi (r/d)^2 P_l'(alpha) / (l(l+1)),  F_0 = 2 pi (r/d)^2 / (1 + alpha)
**   F_l'  = -2 pi P_l(alpha) u,                   u = dalpha/dd = r^2/(d^2 h)
**   F_l'' = -2 pi u (P_l'(alpha) u - P_l(alpha) (2/d + d/h^2))
**
** Source  Iwasaki & Dobashi 2025, Eqs. 2-8 and 15-20, in forms that do not cancel.
*/
#include "../light.h"

#include <math.h>
#include <string.h>

#include "ylm_sh.h"

/* Scratch of one block: the basis at one direction and the sums at one point. */
typedef struct work {
  int lmax, count;
  double *Y, *dY, *ddY;               /* [count], [count][3], [count][6] with respect to v */
  double *P, *dP;                     /* [lmax+1] */
  double *value, *gradient, *hessian; /* [channels][count], ..[3], ..[6] */
} work;

static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};

/* Y(v/|v|) with its derivatives at v, by the reference of csrc/sh. */
static ylm_status basis(const work *k, const double *v) {
  ylm_sh_how how = {.derivatives = 2, .isa = YLM_ISA_reference, .threads = 1};
  return ylm_sh_eval_how(&how, k->lmax, YLM_DOUBLE, 1, v, k->Y, k->dY, k->ddY, NULL);
}

/* P_l and P_l' at alpha. */
static void legendre(int lmax, double alpha, double *P, double *dP) {
  P[0] = 1, dP[0] = 0;
  if (lmax > 0) P[1] = alpha, dP[1] = 1;
  for (int l = 2; l <= lmax; l++) {
    P[l] = ((2 * l - 1) * alpha * P[l - 1] - (l - 1) * P[l - 2]) / l;
    dP[l] = dP[l - 2] + (2 * l - 1) * P[l - 1];
  }
}

/* Channel c of `channels` of a light's radiance. */
static double emission(const ylm__lamp_d *lamp, int channels, int c) {
  return channels == 3 ? lamp->rgb[c] : lamp->luminance;
}

/* Adds one light's radiance times (value, gradient, Hessian) of coefficient i. */
static void add(work *k, int i, const double *w, double d, const double F[3],
                const ylm__lamp_d *lamp, ylm__channels ch) {
  double Y = k->Y[i], *g = k->dY + 3 * i, *H = k->ddY + 6 * i;
  for (int c = 0; c < ch.value; c++)
    k->value[c * k->count + i] += emission(lamp, ch.value, c) * F[0] * Y;
  for (int c = 0; c < ch.gradient; c++)
    for (int a = 0; a < 3; a++)
      k->gradient[3 * (c * k->count + i) + a] -=
          emission(lamp, ch.gradient, c) * (F[0] * g[a] + F[1] * w[a] * Y);
  for (int j = 0; ch.hessian && j < 6; j++) {
    int a = row[j], b = column[j];
    double radial = F[2] * w[a] * w[b] + F[1] / d * ((a == b) - w[a] * w[b]);
    double h = F[0] * H[j] + F[1] * (g[a] * w[b] + w[a] * g[b]) + radial * Y;
    for (int c = 0; c < ch.hessian; c++)
      k->hessian[6 * (c * k->count + i) + j] += emission(lamp, ch.hessian, c) * h;
  }
}

/* Adds one light at point x; sets *inside if x lies in or on it. */
static ylm_status add_light(work *k, const ylm_field_query *q, const ylm__lamp_d *lamp,
                            const double *x, ylm__channels ch, bool *inside) {
  double v[3], d2 = 0, r = lamp->radius;
  for (int a = 0; a < 3; a++) v[a] = lamp->at[a] - x[a], d2 += v[a] * v[a];
  double d = sqrt(d2), h2 = (d - r) * (d + r);
  if (!(h2 > 0)) {
    for (int c = 0; c < ch.value; c++)
      k->value[c * k->count] += emission(lamp, ch.value, c) * sqrt(4 * YLM_PI);
    *inside = true;
    return YLM_OK;
  }
  double h = sqrt(h2), alpha = h / d, s2 = r * r / d2, u = s2 / h;
  double w[3] = {v[0] / d, v[1] / d, v[2] / d};
  legendre(q->lmax, alpha, k->P, k->dP);
  if (basis(k, v) != YLM_OK) return YLM_ERANGE;
  for (int l = 0, i = 0; l <= q->lmax; l++) {
    double F[3] = {2 * YLM_PI * s2 * (l ? k->dP[l] / (l * (l + 1.0)) : 1 / (1 + alpha)),
                   -2 * YLM_PI * k->P[l] * u,
                   -2 * YLM_PI * u * (k->dP[l] * u - k->P[l] * (2 / d + d / h2))};
    for (int m = -l; m <= l; m++, i++) add(k, i, w, d, F, lamp, ch);
  }
  return YLM_OK;
}

/* The largest absolute eigenvalue of xx xy xz yy yz zz, by Jacobi rotations. */
static double largest_eigenvalue(const double H[6]) {
  double A[3][3] = {{H[0], H[1], H[2]}, {H[1], H[3], H[4]}, {H[2], H[4], H[5]}};
  for (int sweep = 0; sweep < 12; sweep++)
    for (int p = 0; p < 2; p++)
      for (int q = p + 1; q < 3; q++) {
        if (A[p][q] == 0) continue;
        double theta = 0.5 * atan2(2 * A[p][q], A[q][q] - A[p][p]), c = cos(theta), s = sin(theta);
        for (int j = 0; j < 3; j++) {
          double x = A[j][p], y = A[j][q];
          A[j][p] = c * x - s * y, A[j][q] = s * x + c * y;
        }
        for (int j = 0; j < 3; j++) {
          double x = A[p][j], y = A[q][j];
          A[p][j] = c * x - s * y, A[q][j] = s * x + c * y;
        }
      }
  return fmax(fabs(A[0][0]), fmax(fabs(A[1][1]), fabs(A[2][2])));
}

/* Writes `width` numbers for each of `n`, `channels` sums given as `have` channels. */
static void put(ylm_dtype t, void *out, size_t point, int channels, int have, size_t n,
                const double *sum) {
  for (int c = 0; c < channels; c++)
    for (size_t i = 0; i < n; i++) {
      size_t k = (point * (size_t)channels + (size_t)c) * n + i;
      double x = sum[(size_t)c * n + i];
      if (have == 3 && channels == 1) {
        double rgb[3] = {sum[i], sum[n + i], sum[2 * n + i]};
        x = ylm__emission(rgb, 1, 0);
      }
      if (t == YLM_DOUBLE)
        ((double *)out)[k] = x;
      else
        ((float *)out)[k] = (float)x;
    }
}

/* lambda and norm of one point from its sums. */
static void metric(const work *k, const ylm_field_query *q, ylm__channels ch, size_t point,
                   ylm_field_result *r) {
  double lambda2 = 0, norm2 = 0;
  for (int c = 0; c < q->metric_channels; c++)
    for (int i = 0; i < k->count; i++) {
      double H[6], L;
      for (int j = 0; j < 6; j++) {
        const double *h = k->hessian + 6 * i + j;
        double rgb[3] = {h[0], ch.hessian == 3 ? h[6 * k->count] : 0,
                         ch.hessian == 3 ? h[12 * k->count] : 0};
        H[j] = ch.hessian == q->metric_channels ? h[6 * c * k->count] : ylm__emission(rgb, 1, 0);
      }
      double e = largest_eigenvalue(H);
      lambda2 += e * e;
      const double *v = k->value + i;
      double rgb[3] = {v[0], ch.value == 3 ? v[k->count] : 0, ch.value == 3 ? v[2 * k->count] : 0};
      L = ch.value == q->metric_channels ? v[c * k->count] : ylm__emission(rgb, 1, 0);
      norm2 += L * L;
    }
  double lambda = sqrt(lambda2), norm = sqrt(norm2);
  if (r->lambda) put(q->dtype, r->lambda, point, 1, 1, 1, &lambda);
  if (r->norm) put(q->dtype, r->norm, point, 1, 1, 1, &norm);
}

static ylm_status work_create(work *k, int lmax) {
  size_t n = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  double *p = ylm_alloc(n * 40 + 2 * (size_t)(lmax + 1), sizeof *p);
  if (!p) return YLM_ENOMEM;
  *k = (work){.lmax = lmax,
              .count = (int)n,
              .value = p,
              .gradient = p + 3 * n,
              .hessian = p + 12 * n,
              .Y = p + 30 * n,
              .dY = p + 31 * n,
              .ddY = p + 34 * n,
              .P = p + 40 * n,
              .dP = p + 40 * n + lmax + 1};
  return YLM_OK;
}

ylm_status ylm__reference_range(const ylm_lights *lights, const ylm_field_query *q, size_t begin,
                                size_t end, const void *points, ylm_field_result *r) {
  work k;
  if (work_create(&k, q->lmax) != YLM_OK) return YLM_ENOMEM;
  ylm__channels ch = ylm__channels_of(q);
  ylm_status s = YLM_OK;
  for (size_t p = begin; s == YLM_OK && p < end; p++) {
    double x[3];
    bool inside = false;
    for (int a = 0; a < 3; a++) x[a] = ylm_get(q->dtype, points, 3 * p + (size_t)a);
    memset(k.value, 0, 30 * (size_t)k.count * sizeof(double));
    for (size_t i = 0; s == YLM_OK && i < lights->active; i++) {
      ylm__lamp_d lamp = lights->lamp_d[i];
      if (q->dtype == YLM_FLOAT) { /* the inputs rounded as the kernels see them */
        const ylm__lamp_f *f = &lights->lamp_f[i];
        lamp = (ylm__lamp_d){{f->at[0], f->at[1], f->at[2]},
                             f->radius,
                             f->luminance,
                             {f->rgb[0], f->rgb[1], f->rgb[2]}};
      }
      s = add_light(&k, q, &lamp, x, ch, &inside);
    }
    size_t n = (size_t)k.count;
    if (q->want & YLM_WANT_VALUE) put(q->dtype, r->value, p, q->channels, ch.value, n, k.value);
    if (q->want & YLM_WANT_GRADIENT)
      put(q->dtype, r->gradient, p, q->channels, ch.gradient, 3 * n, k.gradient);
    if (q->want & YLM_WANT_HESSIAN)
      put(q->dtype, r->hessian, p, q->channels, ch.hessian, 6 * n, k.hessian);
    if (q->want & YLM_WANT_METRIC) metric(&k, q, ch, p, r);
    if (r->inside) r->inside[p] = inside;
  }
  ylm_free(k.value);
  return s;
}
