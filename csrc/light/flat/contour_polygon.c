/* contour_polygon.c - a convex polygon, whole or cut at a horizon, by its edges. */
#include "contour.h"

#include <math.h>
#include <string.h>

#define MAX_VERTICES (2 * YLM_POLYGON_VERTICES)

/* A polygon cut at the plane across `up`; edge[i]: from i to i+1 is part of the light's rim,
   cut[i]: i lies where edge end[i] of the light meets the plane. */
typedef struct clipped {
  int n;
  double v[MAX_VERTICES][3], along[MAX_VERTICES][3];
  bool edge[MAX_VERTICES], cut[MAX_VERTICES];
} clipped;

static void clip(int n, const double (*v)[3], const double *up, clipped *out) {
  out->n = 0;
  for (int i = 0; i < n; i++) {
    const double *a = v[i], *b = v[(i + 1) % n];
    double ha = ylm_dot3d(a, up), hb = ylm_dot3d(b, up);
    if (ha >= 0) {
      int m = out->n++;
      memcpy(out->v[m], a, sizeof out->v[m]);
      out->edge[m] = true, out->cut[m] = false;
    }
    if ((ha >= 0) == (hb >= 0)) continue;
    int m = out->n++;
    double t = ha / (ha - hb);
    for (int c = 0; c < 3; c++) {
      out->along[m][c] = b[c] - a[c];
      out->v[m][c] = a[c] + t * (b[c] - a[c]);
    }
    out->edge[m] = ha < 0; /* leaving: the next edge runs along the horizon */
    out->cut[m] = true;
  }
}

/* Does x, in the polygon's plane, lie in the polygon or on its rim? */
static bool holds(int n, const double (*v)[3], const double *normal) {
  bool left = true, right = true;
  for (int i = 0; i < n; i++) {
    const double *a = v[i], *b = v[(i + 1) % n];
    double c[3], d[3];
    for (int q = 0; q < 3; q++) d[q] = b[q] - a[q];
    ylm_cross3d(a, d, c);
    double side = ylm_dot3d(c, normal), slack = 1e-15 * sqrt(ylm_dot3d(a, a) * ylm_dot3d(d, d));
    left &= side >= -slack;
    right &= side <= slack;
  }
  return left || right;
}

/* Solid angle of a fan of triangles, as the argument of a product of complex numbers (Van Oosterom
   & Strackee 1983): with sign, the determinants without cancellation. */
static double solid_angle(int n, const double (*v)[3]) {
  double re = 1, im = 0, a[3], b[3], c[3], r0 = sqrt(ylm_dot3d(v[0], v[0]));
  for (int i = 1; i + 1 < n; i++) {
    const double *p = v[i], *q = v[i + 1];
    for (int k = 0; k < 3; k++) a[k] = p[k] - v[0][k], b[k] = q[k] - v[0][k];
    ylm_cross3d(a, b, c);
    double r1 = sqrt(ylm_dot3d(p, p)), r2 = sqrt(ylm_dot3d(q, q));
    double x = 1 + ylm_dot3d(v[0], p) / (r0 * r1) + ylm_dot3d(p, q) / (r1 * r2) +
               ylm_dot3d(q, v[0]) / (r2 * r0);
    double y = ylm_dot3d(c, v[0]) / (r0 * r1 * r2);
    double next = re * x - im * y;
    im = re * y + im * x;
    re = next;
    double size = fmax(fabs(re), fabs(im));
    if (size > 0) re /= size, im /= size;
  }
  return 2 * atan2(im, re);
}

/* Seven points in each triangle of the fan, exact to degree 5 (Radon 1948). */
static ylm_status from_far(const ylm__contour *k, int n, const double (*v)[3],
                           const double *normal) {
  static const double at[2] = {0.10128650732345633, 0.47014206410511509},
                      share[2] = {0.12593918054482715, 0.13239415278850618};
  for (int i = 1; i + 1 < n; i++) {
    const double *p[3] = {v[0], v[i], v[i + 1]};
    double y[7][3], w[7], a[3], b[3], c[3];
    for (int q = 0; q < 3; q++) a[q] = p[1][q] - p[0][q], b[q] = p[2][q] - p[0][q];
    ylm_cross3d(a, b, c);
    double area = 0.5 * ylm_dot3d(c, normal);
    for (int q = 0; q < 3; q++) y[0][q] = (p[0][q] + p[1][q] + p[2][q]) / 3;
    w[0] = 0.225 * area;
    for (int j = 0; j < 6; j++) {
      double s = at[j / 3];
      for (int q = 0; q < 3; q++)
        y[1 + j][q] = s * (p[(j + 1) % 3][q] + p[(j + 2) % 3][q]) + (1 - 2 * s) * p[j % 3][q];
      w[1 + j] = share[j / 3] * area;
    }
    ylm_status s = ylm__contour_points(k, 7, (const double(*)[3])y, w, normal);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

/* Vertices' mean, the largest distance from it and that of x. */
static bool is_far(const ylm__contour *k, int n, const double (*v)[3]) {
  double c[3] = {0, 0, 0}, reach = 0;
  for (int i = 0; i < n; i++)
    for (int q = 0; q < 3; q++) c[q] += v[i][q] / n;
  for (int i = 0; i < n; i++) {
    double d[3] = {v[i][0] - c[0], v[i][1] - c[1], v[i][2] - c[2]};
    reach = fmax(reach, ylm_dot3d(d, d));
  }
  return (k->lmax + 4) * sqrt(reach) < YLM__FAR * sqrt(ylm_dot3d(c, c));
}

ylm_status ylm__contour_polygon(const ylm__contour *k, int n, const double (*v)[3],
                                const double *normal, const double *horizon) {
  ylm__contour_clear(k);
  double height = 0, nearest = INFINITY, farthest = 0;
  for (int i = 0; i < n; i++) {
    double d = ylm_dot3d(v[i], v[i]);
    if (d < nearest) nearest = d, height = ylm_dot3d(v[i], normal);
    farthest = fmax(farthest, d);
  }
  if (fabs(height) <= YLM__EDGE_ON * sqrt(farthest))
    return holds(n, v, normal) ? ylm__contour_touched(k) : YLM_OK;
  clipped cut;
  bool whole = true;
  if (horizon) {
    clip(n, v, horizon, &cut);
    for (int i = 0; i < cut.n; i++) whole &= !cut.cut[i];
    if (cut.n < 3) return YLM_OK;
  }
  if (whole && is_far(k, n, v)) return from_far(k, n, v, normal);
  if (whole) {
    cut.n = n;
    memcpy(cut.v, v, (size_t)n * sizeof cut.v[0]);
    for (int i = 0; i < n; i++) cut.edge[i] = true, cut.cut[i] = false;
  }
  double omega = solid_angle(cut.n, (const double(*)[3])cut.v), sign = height < 0 ? -1 : 1;
  k->value[0] = fabs(omega) * sqrt(1 / (4 * YLM_PI));
  for (int i = 0; i < cut.n; i++) {
    const double *a = cut.v[i], *b = cut.v[(i + 1) % cut.n];
    ylm_status s = YLM_OK;
    /* an edge whose line passes through x, beyond its ends, or that clipping left no length */
    ylm__contour_arc(k, a, b, sign, cut.edge[i], &s);
    if (s == YLM_OK && cut.cut[i])
      s = ylm__contour_cut(k, a, cut.along[i], horizon, cut.edge[i] ? -sign : sign);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}
