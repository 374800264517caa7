/*
** reference.c - the short scalar evaluation that judges the fast kernels.
**
** Iwasaki & Dobashi 2025, Eqs. 10-19, with Q normalised so that nothing overflows:
**   S_lm = N_lm Q_l^m(z, r) c_m(x, y)    m >= 0, and s_m for m < 0
**   dQ_l^m/dx = x Q_(l-1)^(m+1),  dQ_l^m/dz = (l+m) Q_(l-1)^m
** at the unit vector w; then the derivatives of Y from those of S, scaled by 1/|v|.
*/
#include "sh_eval.h"

#include <math.h>
#include <string.h>

/* n! / k! */
static double factorials(int n, int k) {
  double f = 1;
  for (int i = k + 1; i <= n; i++) f *= i;
  for (int i = n + 1; i <= k; i++) f /= i;
  return f;
}

/* N_lm / N_kp, N_lm = sqrt((2l+1)/4pi (l-m)!/(l+m)!) times sqrt2 where m > 0. */
static double norm_ratio(int l, int m, int k, int p) {
  double f = (2.0 * l + 1) / (2.0 * k + 1) * factorials(l - m, k - p) / factorials(l + m, k + p);
  return sqrt(f * (m > 0 ? 2 : 1) / (p > 0 ? 2 : 1));
}

/* Rows of N_lm Q_l^m at the degrees l, l-1, l-2. */
typedef struct rows {
  double *q[3];
  double *c, *s;
} rows;

/* N_lm Q_k^p, which is 0 unless 0 <= p <= k; k is l, l-1 or l-2. */
static double q(const rows *w, int l, int m, int k, int p) {
  return p < 0 || k < p ? 0 : norm_ratio(l, m, k, p) * w->q[l - k][p];
}

/* Replaces the row of degree l-3 by that of degree l (Eq. 13) at r = 1. */
static void next_degree(rows *w, int l, double z) {
  double *row = w->q[2];
  w->q[2] = w->q[1], w->q[1] = w->q[0], w->q[0] = row;
  for (int m = 0; m < l; m++)
    row[m] =
        ((2 * l - 1) * z * q(w, l, m, l - 1, m) - (l + m - 1) * q(w, l, m, l - 2, m)) / (l - m);
  row[l] = l == 0 ? 0.28209479177387814347
                  : (1 - 2 * l) * norm_ratio(l, l, l - 1, l - 1) * w->q[1][l - 1];
}

/* c_m or s_m and their derivatives c[0], x, y, xx, xy (yy = -xx). */
static void azimuth(const rows *w, int m, bool sine, double a[5]) {
  const double *f = sine ? w->s : w->c, *g = sine ? w->c : w->s;
  double sign = sine ? 1 : -1, m1 = m, m2 = (double)m * (m - 1);
  a[0] = f[m];
  a[1] = m > 0 ? m1 * f[m - 1] : 0;
  a[2] = m > 0 ? sign * m1 * g[m - 1] : 0;
  a[3] = m > 1 ? m2 * f[m - 2] : 0;
  a[4] = m > 1 ? sign * m2 * g[m - 2] : 0;
}

/* S_lm with gradient and Hessian at the unit vector v: s[0], s[1..3], s[4..9]. */
static void solid_harmonic(const rows *w, int l, int m, bool sine, const double v[3],
                           double s[10]) {
  double x = v[0], y = v[1], a[5];
  double q0 = q(w, l, m, l, m), qr = q(w, l, m, l - 1, m + 1), qrr = q(w, l, m, l - 2, m + 2);
  double qz = (l + m) * q(w, l, m, l - 1, m), qrz = (l + m) * q(w, l, m, l - 2, m + 1);
  double qzz = (double)(l + m) * (l + m - 1) * q(w, l, m, l - 2, m);
  azimuth(w, m, sine, a);
  s[0] = q0 * a[0];
  s[1] = x * qr * a[0] + q0 * a[1];
  s[2] = y * qr * a[0] + q0 * a[2];
  s[3] = qz * a[0];
  s[4] = (x * x * qrr + qr) * a[0] + 2 * x * qr * a[1] + q0 * a[3];
  s[5] = x * y * qrr * a[0] + qr * (x * a[2] + y * a[1]) + q0 * a[4];
  s[6] = x * qrz * a[0] + qz * a[1];
  s[7] = (y * y * qrr + qr) * a[0] + 2 * y * qr * a[2] - q0 * a[3];
  s[8] = y * qrz * a[0] + qz * a[2];
  s[9] = qzz * a[0];
}

/* From S at w = v/d to S at v = d w. */
void ylm__sh_scale_solid(int l, double d, double s[10]) {
  double d0 = pow(d, l), d1 = l > 0 ? pow(d, l - 1) : 0, d2 = l > 1 ? pow(d, l - 2) : 0;
  s[0] *= d0;
  for (int i = 1; i < 4; i++) s[i] *= d1;
  for (int i = 4; i < 10; i++) s[i] *= d2;
}

/* From S at w = v/d to Y(v/|v|) at v, Eq. 17 and the one after it. */
void ylm__sh_surface(int l, double d, const double w[3], double s[10]) {
  static const int at[3][3] = {{4, 5, 6}, {5, 7, 8}, {6, 8, 9}};
  double g[3];
  for (int i = 0; i < 3; i++) g[i] = s[1 + i] - l * s[0] * w[i];
  for (int i = 0; i < 3; i++)
    for (int j = i; j < 3; j++)
      s[at[i][j]] = (s[at[i][j]] -
                     l * (s[0] * ((i == j) + (l - 2) * w[i] * w[j]) + g[i] * w[j] + w[i] * g[j])) /
                    d / d;
  for (int i = 0; i < 3; i++) s[1 + i] = g[i] / d;
}

void ylm__sh_unit(const double v[3], double w[3], double *d) {
  double largest = fmax(fmax(fabs(v[0]), fabs(v[1])), fabs(v[2]));
  if (largest == 0) {
    w[0] = w[1] = 0, w[2] = 1;
    *d = 0;
    return;
  }
  int e = ilogb(largest);
  for (int i = 0; i < 3; i++) w[i] = scalbn(v[i], -e);
  double norm = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  for (int i = 0; i < 3; i++) w[i] /= norm;
  *d = scalbn(norm, e);
}

/* Stores `width` numbers as element `at` of an array, if it is wanted. */
static void store(void *out, ylm_dtype t, size_t at, size_t width, const double *s) {
  for (size_t i = 0; out && i < width; i++) {
    if (t == YLM_DOUBLE)
      ((double *)out)[at * width + i] = s[i];
    else
      ((float *)out)[at * width + i] = (float)s[i];
  }
}

/* Writes value, gradient, Hessian s[0], s[1..3], s[4..9] of coefficient (l, m) of point i. */
static void put(const ylm__sh_job *job, ylm_dtype t, size_t i, int l, int m, const double s[10]) {
  size_t at = i * ylm_sh_count(job->lmax) + ylm_sh_index(l, m);
  store(job->y, t, at, 1, s);
  store(job->dy, t, at, 3, s + 1);
  store(job->ddy, t, at, 6, s + 4);
}

/* Point i, as double. */
static void point(const ylm__sh_job *job, ylm_dtype t, size_t i, double v[3]) {
  const float *f = job->p;
  const double *d = job->p;
  for (size_t c = 0; c < 3; c++) v[c] = t == YLM_DOUBLE ? d[3 * i + c] : (double)f[3 * i + c];
}

static void one_point(const ylm__sh_job *job, ylm_dtype t, size_t i, rows *r) {
  double v[3], w[3], d, s[10];
  point(job, t, i, v);
  ylm__sh_unit(v, w, &d);
  r->c[0] = 1, r->s[0] = 0;
  for (int m = 1; m <= job->lmax; m++) { /* Eq. 14 */
    r->c[m] = w[0] * r->c[m - 1] - w[1] * r->s[m - 1];
    r->s[m] = w[0] * r->s[m - 1] + w[1] * r->c[m - 1];
  }
  for (int l = 0; l <= job->lmax; l++) {
    next_degree(r, l, w[2]);
    for (int m = -l; m <= l; m++) {
      solid_harmonic(r, l, m < 0 ? -m : m, m < 0, w, s);
      if (job->solid)
        ylm__sh_scale_solid(l, d, s);
      else
        ylm__sh_surface(l, d, w, s);
      put(job, t, i, l, m, s);
    }
  }
}

static void reference(const ylm__sh_job *job, ylm_dtype t, size_t begin, size_t end,
                      double *scratch) {
  size_t n = (size_t)job->lmax + 1;
  rows r = {{scratch, scratch + n, scratch + 2 * n}, scratch + 3 * n, scratch + 4 * n};
  memset(scratch, 0, 5 * n * sizeof *scratch);
  for (size_t i = begin; i < end; i++) one_point(job, t, i, &r);
}

void ylm__sh_reference_float(const ylm__sh_job *job, size_t begin, size_t end, void *scratch) {
  reference(job, YLM_FLOAT, begin, end, scratch);
}

void ylm__sh_reference_double(const ylm__sh_job *job, size_t begin, size_t end, void *scratch) {
  reference(job, YLM_DOUBLE, begin, end, scratch);
}
