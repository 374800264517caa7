/* pole.c - intensities about a pole: a polynomial of the direction, since angles are no coordinates there. */
#include "table.h"

#include <math.h>

/* Functions of C that a ring is fitted by: 1, cos C, sin C, cos 2C, sin 2C. */
enum { PARTS = 5 };

static void parts_of(double c, double out[PARTS]) {
  out[0] = 1;
  out[1] = cos(c), out[2] = sin(c);
  out[3] = cos(2 * c), out[4] = sin(2 * c);
}

/* The share of a turn that plane k stands for. */
static double share_of(const ylm_light_photometry *p, size_t k) {
  double before = k > 0 ? p->plane[k - 1] : p->plane[p->planes - 1] - 2 * YLM_PI;
  return (p->plane[k + 1] - before) / (4 * YLM_PI);
}

/* Least squares of the values of ring j by the parts, in the order of the parts: one that the planes do not tell from those
   before it is 0 (Gram & Schmidt). */
static void fit_ring(const ylm_light_photometry *p, size_t j, double out[PARTS]) {
  double gram[PARTS][PARTS] = {{0}}, right[PARTS] = {0}, lower[PARTS][PARTS] = {{0}}, y[PARTS];
  for (size_t k = 0; k < p->planes; k++) {
    double part[PARTS], w = share_of(p, k);
    parts_of(p->plane[k], part);
    for (int a = 0; a < PARTS; a++) {
      right[a] += w * part[a] * p->grid.candela[k * p->angles + j];
      for (int b = 0; b < PARTS; b++) gram[a][b] += w * part[a] * part[b];
    }
  }
  for (int a = 0; a < PARTS; a++) { /* Cholesky, without what is left of less than 1e-9 */
    for (int b = 0; b <= a; b++) {
      double s = gram[a][b];
      for (int i = 0; i < b; i++) s -= lower[a][i] * lower[b][i];
      if (a == b)
        lower[a][a] = s > 1e-9 ? sqrt(s) : 0;
      else
        lower[a][b] = lower[b][b] > 0 ? s / lower[b][b] : 0;
    }
    double s = right[a];
    for (int i = 0; i < a; i++) s -= lower[a][i] * y[i];
    y[a] = lower[a][a] > 0 ? s / lower[a][a] : 0;
  }
  for (int a = PARTS; a-- > 0;) {
    double s = y[a];
    for (int b = a + 1; b < PARTS; b++) s -= lower[b][a] * out[b];
    out[a] = lower[a][a] > 0 ? s / lower[a][a] : 0;
  }
}

/* x[0] r^n + x[1] r^(n+2) through two rings; of one ring x[1] is 0. */
static void through(int n, const double r[2], const double f[2], bool two, double x[2]) {
  double a = f[0] / pow(r[0], n), b = two ? f[1] / pow(r[1], n) : 0;
  x[1] = two ? (b - a) / (r[1] * r[1] - r[0] * r[0]) : 0;
  x[0] = a - x[1] * r[0] * r[0];
}

void ylm__photometric_fit_pole(ylm_light_photometry *p, int k, double slope[2]) {
  ylm__photometric_pole *pole = &p->pole[k];
  size_t last = p->angles - 1, at = k ? last : 0;
  double fit[2][PARTS], t[2], r[2], centre = 0;
  for (size_t i = 0; i < p->planes; i++)
    centre += share_of(p, i) * p->grid.candela[i * p->angles + at];
  bool two = p->angles > 2;
  for (size_t i = 0; i < (two ? 2 : 1); i++) {
    size_t ring = k ? last - 1 - i : 1 + i;
    t[i] = fabs(p->angle[ring] - p->angle[at]);
    r[i] = sin(t[i]);
    fit_ring(p, ring, fit[i]);
  }
  two = two && t[1] < YLM_PI / 3;
  pole->on = t[0] < YLM_PI / 4;
  pole->end = t[0];
  pole->even[0] = centre;
  through(2, r, (const double[]){fit[0][0] - centre, two ? fit[1][0] - centre : 0}, two,
          pole->even + 1);
  for (int a = 0; a < 2; a++) {
    through(1, r, (const double[]){fit[0][1 + a], two ? fit[1][1 + a] : 0}, two, pole->odd[a]);
    through(2, r, (const double[]){fit[0][3 + a], two ? fit[1][3 + a] : 0}, two, pole->two[a]);
    slope[a] = pole->odd[a][0];
  }
}

/* A step from half of the first ring to the ring, of continuous second derivative. */
void ylm__photometric_blend(const ylm__photometric_pole *pole, double t, double w[3]) {
  double h = pole->end / 2, x = t / h - 1;
  x = x < 0 ? 0 : x > 1 ? 1 : x;
  w[0] = x * x * x * (10 + x * (-15 + 6 * x));
  w[1] = 30 * x * x * (1 - x) * (1 - x) / h;
  w[2] = 60 * x * (1 - x) * (1 - 2 * x) / (h * h);
}

/* x[0] r^n + x[1] r^(n+2), and its derivatives by r. */
static void power(int n, const double x[2], double r, double out[3]) {
  double low = n == 1 ? r : r * r;
  out[0] = low * (x[0] + x[1] * r * r);
  out[1] = (n == 1 ? 1 : r) * (n * x[0] + (n + 2) * x[1] * r * r);
  out[2] = n == 1 ? 6 * x[1] * r : 2 * x[0] + 12 * x[1] * r * r;
}

ylm__photometric_value ylm__photometric_polynomial(const ylm__photometric_pole *pole, double t,
                                                   double c) {
  double part[PARTS], r = sin(t), rt = cos(t), f[PARTS][3];
  static const int turn[PARTS] = {0, 2, 1, 4, 3}; /* d part/dC = turns[k] part[turn[k]] */
  static const double turns[PARTS] = {0, -1, 1, -2, 2}, square[PARTS] = {0, -1, -1, -4, -4};
  parts_of(c, part);
  power(2, pole->even + 1, r, f[0]);
  f[0][0] += pole->even[0];
  for (int a = 0; a < 2; a++) {
    power(1, pole->odd[a], r, f[1 + a]);
    power(2, pole->two[a], r, f[3 + a]);
  }
  ylm__photometric_value v = {0};
  for (int k = 0; k < PARTS; k++) {
    double slope = f[k][1] * rt, bend = f[k][2] * rt * rt - f[k][1] * r;
    v.f += f[k][0] * part[k];
    v.g += slope * part[k];
    v.gg += bend * part[k];
    v.c += f[k][0] * turns[k] * part[turn[k]];
    v.gc += slope * turns[k] * part[turn[k]];
    v.cc += f[k][0] * square[k] * part[k];
  }
  return v;
}
