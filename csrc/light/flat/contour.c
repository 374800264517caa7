/* contour.c - sums along the rims of flat lights, plain and in double; they judge the kernels. */
#include "contour.h"

#include <math.h>
#include <string.h>

#include "ylm_sh.h"

static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};

ylm_status ylm__contour_make(ylm__contour *k, int lmax) {
  size_t count = ylm_sh_count(lmax);
  *k = (ylm__contour){.lmax = lmax, .count = count};
  k->y = ylm_alloc(YLM__BATCH * count * 10, sizeof *k->y);
  if (!k->y) return YLM_ENOMEM;
  k->dy = k->y + YLM__BATCH * count;
  k->ddy = k->dy + 3 * YLM__BATCH * count;
  return YLM_OK;
}

void ylm__contour_clear(const ylm__contour *k) {
  memset(k->value, 0, k->count * sizeof *k->value);
  if (k->gradient) memset(k->gradient, 0, 3 * k->count * sizeof *k->gradient);
  if (k->hessian) memset(k->hessian, 0, 6 * k->count * sizeof *k->hessian);
}

ylm_status ylm__contour_touched(const ylm__contour *k) {
  ylm__contour_clear(k);
  k->value[0] = sqrt(YLM_PI);
  return YLM_EDOMAIN;
}

/* Adds one node where the basis is y, dy. */
static void add_node(const ylm__contour *k, const double *y, const double *dy, const double *s,
                     const double *m, double inverse, bool moves) {
  for (int l = 1; l <= k->lmax; l++)
    for (size_t i = (size_t)l * (size_t)l; i < (size_t)(l + 1) * (size_t)(l + 1); i++)
      k->value[i] += ylm_dot3d(m, dy + 3 * i) / (l * (l + 1));
  if (!moves) return;
  for (size_t i = 0; k->gradient && i < k->count; i++)
    for (size_t a = 0; a < 3; a++) k->gradient[3 * i + a] += m[a] * y[i] * inverse;
  for (size_t i = 0; k->hessian && i < k->count; i++) {
    double g[3];
    for (size_t a = 0; a < 3; a++)
      g[a] = -0.5 * inverse * inverse * (dy[3 * i + a] - 3 * s[a] * y[i]);
    for (size_t q = 0; q < 6; q++)
      k->hessian[6 * i + q] += m[row[q]] * g[column[q]] + m[column[q]] * g[row[q]];
  }
}

ylm_status ylm__contour_nodes(const ylm__contour *k, int n, const double (*s)[3],
                              const double (*m)[3], const double *inverse, bool moves) {
  for (int begin = 0; begin < n; begin += YLM__BATCH) {
    int some = n - begin < YLM__BATCH ? n - begin : YLM__BATCH;
    ylm_status status = ylm_sh_eval(k->lmax, 1, false, YLM_DOUBLE, (size_t)some, s + begin, k->y,
                                    k->dy, NULL, 1, NULL);
    if (status != YLM_OK) return status;
    for (int i = 0; i < some; i++)
      add_node(k, k->y + (size_t)i * k->count, k->dy + 3 * (size_t)i * k->count, s[begin + i],
               m[begin + i], inverse[begin + i], moves);
  }
  return YLM_OK;
}

bool ylm__contour_arc(const ylm__contour *k, const double *v, const double *w, double sign,
                      bool moves, ylm_status *status) {
  double n[3], d[3], a[3], b[3], along[3], foot[3], lv = sqrt(ylm_dot3d(v, v));
  for (int c = 0; c < 3; c++) d[c] = w[c] - v[c];
  ylm_cross3d(v, d, n); /* = v x w, with less cancellation */
  double ln = sqrt(ylm_dot3d(n, n)), ld = sqrt(ylm_dot3d(d, d));
  if (!(ln > 1e-15 * lv * ld) || !(ld > 0)) return false;
  for (int c = 0; c < 3; c++) a[c] = v[c] / lv, n[c] /= ln, along[c] = d[c] / ld;
  ylm_cross3d(n, a, b);
  ylm_cross3d(along, n, foot); /* the foot of the perpendicular: at distance ln/ld, this way */
  double angle = atan2(ln / lv, ylm_dot3d(w, a));
  const ylm__rule *rule = ylm__rule_for(k->lmax + 3, angle, 8);
  double s[YLM__MOST_NODES][3], m[YLM__MOST_NODES][3], inverse[YLM__MOST_NODES];
  for (int i = 0; i < rule->n; i++) {
    double t = 0.5 * angle * (rule->x[i] + 1), cosine = cos(t), sine = sin(t);
    double weight = sign * 0.5 * angle * rule->w[i];
    for (int c = 0; c < 3; c++) {
      s[i][c] = cosine * a[c] + sine * b[c];
      m[i][c] = weight * n[c];
    }
    inverse[i] = ylm_dot3d(s[i], foot) * ld / ln;
  }
  *status =
      ylm__contour_nodes(k, rule->n, (const double(*)[3])s, (const double(*)[3])m, inverse, moves);
  return true;
}

ylm_status ylm__contour_cut(const ylm__contour *k, const double *y, const double *dy,
                            const double *up, double sign) {
  if (!k->hessian) return YLM_OK;
  double across[3], rho = sqrt(ylm_dot3d(y, y)), run = ylm_dot3d(dy, up);
  if (run == 0) return YLM_OK; /* the rim runs along the horizon: nothing is cut */
  ylm_cross3d(y, dy, across);
  ylm_status s = ylm_sh_eval(k->lmax, 0, false, YLM_DOUBLE, 1, y, k->y, NULL, NULL, 1, NULL);
  for (size_t i = 0; s == YLM_OK && i < k->count; i++) {
    double f = 0.5 * sign * k->y[i] / (run * rho * rho * rho);
    for (size_t q = 0; q < 6; q++)
      k->hessian[6 * i + q] +=
          f * (across[row[q]] * up[column[q]] + across[column[q]] * up[row[q]]);
  }
  return s;
}

/* Adds w Y g and its derivatives, g = |n.y|/|y|^3. */
static void add_point(const ylm__contour *k, const double *v, double w, const double *n,
                      const double *y, const double *dy, const double *ddy) {
  double h = ylm_dot3d(n, v), r2 = ylm_dot3d(v, v), g, gg[3], hh[6];
  double f = (h < 0 ? -w : w) / (r2 * sqrt(r2));
  g = f * h;
  for (int a = 0; a < 3; a++) gg[a] = f * (n[a] - 3 * h * v[a] / r2);
  for (int q = 0; q < 6; q++) {
    int a = row[q], b = column[q];
    hh[q] = f * (-3 * (n[a] * v[b] + v[a] * n[b]) / r2 - (a == b ? 3 * h / r2 : 0) +
                 15 * h * v[a] * v[b] / (r2 * r2));
  }
  for (size_t i = 0; i < k->count; i++) {
    const double *d = dy + 3 * i;
    k->value[i] += g * y[i];
    for (size_t a = 0; k->gradient && a < 3; a++) k->gradient[3 * i + a] -= g * d[a] + gg[a] * y[i];
    for (size_t q = 0; k->hessian && q < 6; q++)
      k->hessian[6 * i + q] +=
          g * ddy[6 * i + q] + d[row[q]] * gg[column[q]] + gg[row[q]] * d[column[q]] + y[i] * hh[q];
  }
}

ylm_status ylm__contour_points(const ylm__contour *k, int n, const double (*y)[3], const double *w,
                               const double *normal) {
  for (int begin = 0; begin < n; begin += YLM__BATCH) {
    int some = n - begin < YLM__BATCH ? n - begin : YLM__BATCH;
    ylm_status s = ylm_sh_eval(k->lmax, 2, false, YLM_DOUBLE, (size_t)some, y + begin, k->y, k->dy,
                               k->ddy, 1, NULL);
    if (s != YLM_OK) return s;
    for (int i = 0; i < some; i++)
      add_point(k, y[begin + i], w[begin + i], normal, k->y + (size_t)i * k->count,
                k->dy + 3 * (size_t)i * k->count, k->ddy + 6 * (size_t)i * k->count);
  }
  return YLM_OK;
}
