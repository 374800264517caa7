/*
** eval.c - other ways to evaluate, scalar, kept to compare with: "polynomial", "direct",
** "sloan", "scd".
**
** The last three work in (theta, phi) at the unit vector w and go to x, y, z by the chain rule. The
** chain rule divides by sin(theta): where x = y = 0 their derivatives are NaN, and close by they
** lose digits.
**   direct   dP/dtheta by Mezieres et al. 2022, Eq. 19, with cos(m phi) from libm
**   sloan    P / sin^m and its derivative T by recurrence, Eqs. 7, 8, 17, 21-23
**   scd      the same carried to second derivatives
*/
#include "rival.h"

#include <math.h>
#include <string.h>

#define YLM_T double
#define YLM_K(c) (c)
#define YLM_SET(c) (c)
#include "gen/polynomial.h"

#define POLYNOMIAL_LMAX 6

/* Three rows of q[m], the normalised P_l^m / sin^m(theta), and of its derivatives by theta. */
typedef struct rows {
  double *q[3], *t[3], *tt[3]; /* at degrees l, l-1, l-2 */
  double *c, *s;               /* sin^m cos(m phi), sin^m sin(m phi); direct: without sin^m */
} rows;

/* Derivatives by theta and phi: value, theta, phi, theta theta, theta phi, phi phi. */
typedef struct angular {
  double y, t, p, tt, tp, pp;
} angular;

static void turn(double *row[3]) {
  double *r = row[2];
  row[2] = row[1], row[1] = row[0], row[0] = r;
}

/* q, t, tt of degree l from those of the two degrees below (Eqs. 8 and 22, normalised). */
static void next_degree(rows *r, int l, double z, double st) {
  turn(r->q), turn(r->t), turn(r->tt);
  for (int m = 0; m < l; m++) {
    double d = (double)(l - m) * (l + m), n = 2.0 * l + 1, a = sqrt(n * (n - 2) / d);
    double b = m == l - 1 ? 0 : sqrt(n * (l - 1.0 - m) * (l - 1.0 + m) / ((n - 4) * d));
    double q = r->q[1][m], t = r->t[1][m], tt = r->tt[1][m];
    r->q[0][m] = a * z * q - b * r->q[2][m];
    r->t[0][m] = a * (z * t - st * q) - b * r->t[2][m];
    r->tt[0][m] = a * (z * tt - 2 * st * t - z * q) - b * r->tt[2][m];
  }
  r->q[0][l] = l == 0 ? 0.28209479177387814347
                      : -r->q[1][l - 1] * sqrt((2.0 * l + 1) / (2.0 * l) * (l == 1 ? 2 : 1));
  r->t[0][l] = r->tt[0][l] = 0;
}

/* Y_lm by (theta, phi): products of q with c_m or s_m. */
static angular by_recurrence(const rows *r, int m, double z, double st) {
  int k = m < 0 ? -m : m;
  double f = m < 0 ? r->s[k] : r->c[k], g = k == 0 ? 0 : m < 0 ? r->c[k] : r->s[k];
  double q = r->q[0][k], t = r->t[0][k], tt = r->tt[0][k], cot = z / st;
  double pt = k * cot * q + t, ptt = (k * (k - 1.0) * cot * cot - k) * q + 2 * k * cot * t + tt;
  if (k == 0) pt = t, ptt = tt;
  return (angular){q * f, pt * f, -m * q * g, ptt * f, -m * pt * g, -(double)k * k * q * f};
}

/* Normalised P_l^m, 0 beyond m = l. */
static double legendre(const rows *r, int l, int m, double st) {
  return m > l ? 0 : r->q[0][m] * pow(st, m);
}

/* Y_lm with dP/dtheta from neighbours in m (Eq. 19). */
static angular by_neighbours(const rows *r, int l, int m, double st) {
  int k = m < 0 ? -m : m;
  double f = m < 0 ? r->s[k] : r->c[k], g = k == 0 ? 0 : m < 0 ? r->c[k] : r->s[k];
  double p = legendre(r, l, k, st), up = legendre(r, l, k + 1, st), pt;
  if (k == 0)
    pt = sqrt(0.5 * l * (l + 1)) * up;
  else
    pt = -0.5 * (sqrt((l - k + 1.0) * (l + k) * (k == 1 ? 2 : 1)) * legendre(r, l, k - 1, st) -
                 sqrt((l + k + 1.0) * (l - k)) * up);
  return (angular){.y = p * f, .t = pt * f, .p = -m * p * g};
}

/* From derivatives by theta and phi to those by x, y, z at v = d w (2022, Eq. 23, and its
 * derivative). */
static void to_cartesian(const angular *a, const double w[3], double d, int order, double s[10]) {
  double x = w[0], y = w[1], z = w[2], r2 = x * x + y * y, r = sqrt(r2);
  double theta[3] = {x * z / r, y * z / r, -r}, phi[3] = {-y / r2, x / r2, 0};
  s[0] = a->y;
  for (int i = 0; i < 3; i++) s[1 + i] = (a->t * theta[i] + a->p * phi[i]) / d;
  if (order < 2) return;
  double r3 = r * r2;
  double theta2[6] = {z * (y * y / r3 - 2 * x * x / r), -x * y * z * (1 / r3 + 2 / r),
                      x / r * (1 - 2 * z * z),          z * (x * x / r3 - 2 * y * y / r),
                      y / r * (1 - 2 * z * z),          2 * z * r};
  double phi2[6] = {
      2 * x * y / (r2 * r2), (y * y - x * x) / (r2 * r2), 0, -2 * x * y / (r2 * r2), 0, 0};
  for (int i = 0, k = 0; i < 3; i++)
    for (int j = i; j < 3; j++, k++)
      s[4 + k] = (a->tt * theta[i] * theta[j] + a->tp * (theta[i] * phi[j] + theta[j] * phi[i]) +
                  a->pp * phi[i] * phi[j] + a->t * theta2[k] + a->p * phi2[k]) /
                 d / d;
}

/* v of point i = d w. */
static void unit_point(const ylm_sh_job *job, size_t i, double w[3], double *d) {
  double v[3];
  for (size_t c = 0; c < 3; c++) v[c] = ylm_get(job->dtype, job->p, 3 * i + c);
  ylm_sh_unit(v, w, d);
}

/* Writes value, gradient, Hessian s[0], s[1..3], s[4..9] of coefficient (l, m) of point i. */
static void put(const ylm_sh_job *job, size_t i, int l, int m, const double s[10]) {
  size_t at = i * ylm_sh_count(job->lmax) + ylm_sh_index(l, m);
  if (job->y) ylm_put(job->dtype, job->y, at, s[0]);
  for (size_t k = 0; job->dy && k < 3; k++) ylm_put(job->dtype, job->dy, 3 * at + k, s[1 + k]);
  for (size_t k = 0; job->ddy && k < 6; k++) ylm_put(job->dtype, job->ddy, 6 * at + k, s[4 + k]);
}

static void spherical_point(const ylm_sh_job *job, size_t i, bool direct, rows *r) {
  double w[3], d, s[10];
  unit_point(job, i, w, &d);
  double st = sqrt(w[0] * w[0] + w[1] * w[1]), angle = atan2(w[1], w[0]);
  r->c[0] = 1, r->s[0] = 0;
  for (int m = 1; m <= job->lmax; m++) {
    r->c[m] = direct ? cos(m * angle) : w[0] * r->c[m - 1] - w[1] * r->s[m - 1];
    r->s[m] = direct ? sin(m * angle) : w[0] * r->s[m - 1] + w[1] * r->c[m - 1];
  }
  for (int l = 0; l <= job->lmax; l++) {
    next_degree(r, l, w[2], st);
    for (int m = -l; m <= l; m++) {
      angular a = direct ? by_neighbours(r, l, m, st) : by_recurrence(r, m, w[2], st);
      to_cartesian(&a, w, d, job->derivatives, s);
      put(job, i, l, m, s);
    }
  }
}

/* Degree l as explicit polynomials at w: s[10 * (l + m)] ... */
static void polynomial_degree(int l, int order, const double w[3], double *s) {
  typedef void polynomial(double x, double y, double z, double *restrict s);
  static polynomial *const degrees[3][POLYNOMIAL_LMAX + 1] = {
#define ROW(order)                                                                                 \
  {polynomial_0_##order, polynomial_1_##order, polynomial_2_##order, polynomial_3_##order,         \
   polynomial_4_##order, polynomial_5_##order, polynomial_6_##order}
      ROW(0), ROW(1), ROW(2)};
#undef ROW
  degrees[order][l](w[0], w[1], w[2], s);
}

static void polynomial_point(const ylm_sh_job *job, size_t i) {
  double w[3], d, s[10 * (2 * POLYNOMIAL_LMAX + 1)] = {0};
  unit_point(job, i, w, &d);
  for (int l = 0; l <= job->lmax; l++) {
    polynomial_degree(l, job->derivatives, w, s);
    for (int m = -l; m <= l; m++) {
      double *one = s + 10 * (l + m);
      if (job->solid)
        ylm_sh_scale_solid(l, d, one);
      else if (job->derivatives > 0)
        ylm_sh_surface(l, d, w, one);
      put(job, i, l, m, one);
    }
  }
}

static void spherical(const ylm_sh_job *job, bool direct, size_t begin, size_t end,
                      double *scratch) {
  size_t n = (size_t)job->lmax + 2;
  rows r;
  memset(scratch, 0, 11 * n * sizeof *scratch);
  for (size_t i = 0; i < 3; i++) {
    r.q[i] = scratch + i * n;
    r.t[i] = scratch + (3 + i) * n;
    r.tt[i] = scratch + (6 + i) * n;
  }
  r.c = scratch + 9 * n, r.s = scratch + 10 * n;
  for (size_t i = begin; i < end; i++) spherical_point(job, i, direct, &r);
}

/* -- the methods ------------------------------------------------------------------------------ */

static void direct(const ylm_sh_job *job, size_t begin, size_t end, void *scratch) {
  spherical(job, true, begin, end, scratch);
}

static void sloan(const ylm_sh_job *job, size_t begin, size_t end, void *scratch) {
  spherical(job, false, begin, end, scratch);
}

static void polynomial(const ylm_sh_job *job, size_t begin, size_t end, void *scratch) {
  (void)scratch;
  for (size_t i = begin; i < end; i++) polynomial_point(job, i);
}

/* Bytes of the rows. */
static size_t row_bytes(int lmax) { return ((size_t)lmax + 2) * 11 * sizeof(double); }

static size_t no_bytes(int lmax) { return (void)lmax, 0; }

const ylm_sh_rival_eval ylm__rival_polynomial = {POLYNOMIAL_LMAX, 2, true, no_bytes, polynomial};
const ylm_sh_rival_eval ylm__rival_direct = {YLM_LMAX, 1, false, row_bytes, direct};
const ylm_sh_rival_eval ylm__rival_sloan = {YLM_LMAX, 1, false, row_bytes, sloan};
const ylm_sh_rival_eval ylm__rival_scd = {YLM_LMAX, 2, false, row_bytes, sloan};
