/* spline.c - slopes of cubic splines, along planes and around the axis (de Boor 1978; Fritsch & Carlson 1980). */
#include "table.h"

#include <math.h>
#include <string.h>

/* Neighbours that differ by more than this factor, and this part of the peak, are a cut-off. */
#define CUT_FACTOR 4
#define CUT_PART 0.1
/* Nodes that tell how a plane bends at its end. */
#define END_NODES 5

/* The second derivative at node i, an end, of the polynomial through it and the four nodes behind it in the order `step`: by
   divided differences. 0 where there are fewer, or a cut-off is among them: the end is natural. */
static double end_bend(size_t n, const double *x, const double *f, const bool *fixed, size_t i,
                       int step) {
  double c[END_NODES], t[END_NODES];
  if (n < END_NODES) return 0;
  for (int k = 0; k < END_NODES; k++) {
    size_t at = step > 0 ? i + (size_t)k : i - (size_t)k;
    if (fixed[at]) return 0;
    c[k] = f[at], t[k] = x[i] - x[at];
  }
  for (int j = 1; j < END_NODES; j++)
    for (int k = END_NODES - 1; k >= j; k--) c[k] = (c[k] - c[k - 1]) / (t[k - j] - t[k]);
  return 2 * (c[2] + c[3] * (t[1] + t[2]) + c[4] * (t[1] * t[2] + t[1] * t[3] + t[2] * t[3]));
}

/* Slopes m [n] of the spline through f [n]; those that are fixed stand in m and cut it into parts, other ends bend as the nodes
   near to them do; work [2 n]. */
static void open_slopes(size_t n, const double *x, const double *f, const bool *fixed, double *m,
                        double *work) {
  double *upper = work, *right = work + n;
  for (size_t i = 0; i < n; i++) {
    double before = i > 0 ? x[i] - x[i - 1] : 0, behind = i + 1 < n ? x[i + 1] - x[i] : 0;
    double d0 = i > 0 ? (f[i] - f[i - 1]) / before : 0;
    double d1 = i + 1 < n ? (f[i + 1] - f[i]) / behind : 0;
    double a, b, c, r;
    if (fixed[i]) {
      a = 0, b = 1, c = 0, r = m[i];
    } else if (i == 0) {
      a = 0, b = 2, c = 1, r = 3 * d1 - behind / 2 * end_bend(n, x, f, fixed, i, 1);
    } else if (i + 1 == n) {
      a = 1, b = 2, c = 0, r = 3 * d0 + before / 2 * end_bend(n, x, f, fixed, i, -1);
    } else {
      a = 1 / before, c = 1 / behind, b = 2 * (a + c), r = 3 * (d0 * a + d1 * c);
    }
    double pivot = b - (i > 0 ? a * upper[i - 1] : 0);
    upper[i] = c / pivot;
    right[i] = (r - (i > 0 ? a * right[i - 1] : 0)) / pivot;
  }
  for (size_t i = n; i-- > 0;) m[i] = right[i] - (i + 1 < n ? upper[i] * m[i + 1] : 0);
}

/* Slopes around: x [n + 1], the last a turn behind the first; work [4 n]. The cyclic system by Sherman & Morrison. */
static void round_slopes(size_t n, const double *x, const double *f, double *m, double *work) {
  if (n < 3) {
    for (size_t i = 0; i < n; i++) m[i] = 0;
    return;
  }
  double *upper = work, *right = work + n, *unit = work + 2 * n, *z = work + 3 * n;
  double last = 1 / (x[n] - x[n - 1]), gamma = -1;
  for (size_t i = 0; i < n; i++) {
    double a = i > 0 ? 1 / (x[i] - x[i - 1]) : last, c = 1 / (x[i + 1] - x[i]);
    double before = f[i > 0 ? i - 1 : n - 1], behind = f[i + 1 < n ? i + 1 : 0];
    double b = 2 * (a + c), r = 3 * ((f[i] - before) * a * a + (behind - f[i]) * c * c);
    double u = 0;
    if (i == 0) gamma = -b, u = gamma, b -= gamma;
    if (i + 1 == n) b -= last * last / gamma, u = last;
    double pivot = b - (i > 0 ? a * upper[i - 1] : 0);
    upper[i] = i + 1 < n ? c / pivot : 0;
    right[i] = (r - (i > 0 ? a * right[i - 1] : 0)) / pivot;
    unit[i] = (u - (i > 0 ? a * unit[i - 1] : 0)) / pivot;
  }
  for (size_t i = n; i-- > 0;) {
    m[i] = right[i] - (i + 1 < n ? upper[i] * m[i + 1] : 0);
    z[i] = unit[i] - (i + 1 < n ? upper[i] * z[i + 1] : 0);
  }
  double over = last / gamma, part = (m[0] + over * m[n - 1]) / (1 + z[0] + over * z[n - 1]);
  for (size_t i = 0; i < n; i++) m[i] -= part * z[i];
}

/* The monotone slope at node i: 0 at extrema, else a weighted harmonic mean of both sides. */
static double monotone(size_t n, const double *x, const double *f, size_t i) {
  if (i == 0) return (f[1] - f[0]) / (x[1] - x[0]);
  if (i + 1 == n) return (f[n - 1] - f[n - 2]) / (x[n - 1] - x[n - 2]);
  double h0 = x[i] - x[i - 1], h1 = x[i + 1] - x[i];
  double d0 = (f[i] - f[i - 1]) / h0, d1 = (f[i + 1] - f[i]) / h1;
  if (!(d0 * d1 > 0)) return 0;
  double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / d0 + w1 / d1);
}

static void fix(size_t i, double slope, bool *fixed, double *m) {
  fixed[i] = true;
  m[i] = slope;
}

/* Both nodes beside a cut-off of a plane take monotone slopes, but those that are fixed. */
static void soften(const ylm_light_photometry *p, const double *f, double largest, bool *fixed,
                   double *m) {
  size_t n = p->angles;
  for (size_t i = 0; i + 1 < n; i++) {
    double hi = fmax(f[i], f[i + 1]), lo = fmin(f[i], f[i + 1]);
    if (!(hi > CUT_FACTOR * lo && hi - lo > CUT_PART * largest)) continue;
    for (size_t k = i; k < i + 2; k++)
      if (!fixed[k]) fix(k, monotone(n, p->angle, f, k), fixed, m);
  }
}

/* The slope of plane k at a pole with these slopes along C0 and C90, by the angle to the pole. */
static double at_pole(const ylm_light_photometry *p, const double slope[2], size_t k) {
  return slope[0] * cos(p->plane[k]) + slope[1] * sin(p->plane[k]);
}

/* Slopes along gamma; m and work have 3 numbers for each angle. */
static void along(ylm_light_photometry *p, const bool poles[2], double slope[2][2], bool *fixed,
                  double *m, double *work) {
  double largest = 0;
  size_t n = p->angles;
  for (size_t i = 0; i < p->planes * n; i++) largest = fmax(largest, p->grid.candela[i]);
  for (size_t k = 0; k < p->planes; k++) {
    const double *f = p->grid.candela + k * n;
    memset(fixed, 0, n * sizeof *fixed);
    if (poles[0]) fix(0, at_pole(p, slope[0], k), fixed, m);
    if (poles[1]) fix(n - 1, -at_pole(p, slope[1], k), fixed, m);
    soften(p, f, largest, fixed, m);
    open_slopes(n, p->angle, f, fixed, m, work);
    for (size_t j = 0; j < n; j++) {
      p->node[k * n + j].f = f[j];
      p->node[k * n + j].g = m[j];
    }
  }
}

/* Slopes around the axis, of values and of slopes along gamma. */
static void around(ylm_light_photometry *p, double *f, double *m, double *work) {
  for (size_t j = 0; j < p->angles && p->planes > 1; j++) {
    ylm__photometric_node *n = p->node + j;
    for (size_t k = 0; k < p->planes; k++) f[k] = n[k * p->angles].f;
    round_slopes(p->planes, p->plane, f, m, work);
    for (size_t k = 0; k < p->planes; k++) n[k * p->angles].c = m[k], f[k] = n[k * p->angles].g;
    round_slopes(p->planes, p->plane, f, m, work);
    for (size_t k = 0; k < p->planes; k++) n[k * p->angles].gc = m[k];
  }
}

ylm_status ylm__photometric_spline(ylm_light_photometry *p) {
  size_t n = p->angles > p->planes ? p->angles : p->planes;
  double *work = ylm_alloc(6 * n, sizeof *work), slope[2][2] = {{0, 0}, {0, 0}};
  bool *fixed = ylm_alloc(n, sizeof *fixed);
  bool poles[2] = {p->grid.angle[0] == 0, p->grid.angle[p->angles - 1] == 180};
  ylm_status s = work && fixed ? YLM_OK : YLM_ENOMEM;
  for (int k = 0; s == YLM_OK && k < 2; k++)
    if (poles[k] && p->planes > 1 && !p->grid.linear) ylm__photometric_fit_pole(p, k, slope[k]);
  if (s == YLM_OK) {
    along(p, poles, slope, fixed, work, work + n);
    around(p, work, work + n, work + 2 * n);
  }
  ylm_free(work);
  ylm_free(fixed);
  return s;
}
