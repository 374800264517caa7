/* contour_ellipse.c - disks and ellipses by their rims: there is no closed form off the axis. */
#include "calibration.h"
#include "contour.h"

#include <math.h>
#include <string.h>

typedef struct rim {
  const ylm__contour *k;
  const double *c, *u, *v, *normal; /* centre, half axes; the normal as seen from x: n.c > 0 */
  double sign, size, solid_angle;   /* size: an upper bound of |y'| */
} rim;

static void place(const rim *r, double phi, double *y, double *dy) {
  double c = cos(phi), s = sin(phi);
  for (int a = 0; a < 3; a++) {
    y[a] = r->c[a] + c * r->u[a] + s * r->v[a];
    dy[a] = c * r->v[a] - s * r->u[a];
  }
}

/* Fills node i at angle phi with the weight. */
static void node(rim *r, double phi, double weight, double *s, double *m, double *inverse) {
  double y[3], dy[3], c[3];
  place(r, phi, y, dy);
  ylm_cross3d(y, dy, c);
  double r2 = ylm_dot3d(y, y);
  *inverse = 1 / sqrt(r2);
  for (int a = 0; a < 3; a++) {
    s[a] = y[a] * *inverse;
    m[a] = r->sign * weight * c[a] / r2;
  }
  r->solid_angle += ylm_dot3d(r->normal, m) / (1 + ylm_dot3d(r->normal, s));
}

static ylm_status panel(rim *r, double from, double to) {
  const ylm__rule *rule = ylm__rule_for(r->k->lmax + 3, 1.2, 24);
  double s[YLM__MOST_NODES][3], m[YLM__MOST_NODES][3], inverse[YLM__MOST_NODES];
  for (int i = 0; i < rule->n; i++)
    node(r, 0.5 * (from + to) + 0.5 * (to - from) * rule->x[i], 0.5 * (to - from) * rule->w[i],
         s[i], m[i], inverse + i);
  return ylm__contour_nodes(r->k, rule->n, (const double(*)[3])s, (const double(*)[3])m, inverse,
                            true);
}

/* The rim between two angles, in panels that shrink towards x. */
static ylm_status part(rim *r, double from, double to) {
  double stack[YLM__RIM_PANELS][2];
  int top = 0;
  stack[top][0] = from, stack[top++][1] = to;
  while (top > 0) {
    double a = stack[--top][0], b = stack[top][1], y[3], dy[3];
    place(r, 0.5 * (a + b), y, dy);
    double half = 0.5 * (b - a) * r->size;
    bool small = half * YLM__RIM_RATIO <= sqrt(ylm_dot3d(y, y)) && b - a <= 1.6;
    if (!small && top + 2 <= YLM__RIM_PANELS && b - a > 1e-13) {
      stack[top][0] = 0.5 * (a + b), stack[top++][1] = b;
      stack[top][0] = a, stack[top++][1] = 0.5 * (a + b);
      continue;
    }
    ylm_status s = panel(r, a, b);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

int ylm__equal_steps(double across, double swing, int lmax, double digits) {
  double ratio = across / fmax(swing, 1e-300);
  double n = (digits + 1.5 * lmax) / (0.7 * acosh(fmax(1, ratio))) + 4, least = lmax + 12;
  n = fmax(n, least);
  return n <= YLM__STEPS ? (int)ceil(n) : 0;
}

static int whole_steps(const rim *r) {
  double cu = ylm_dot3d(r->c, r->u), cv = ylm_dot3d(r->c, r->v);
  return ylm__equal_steps(ylm_dot3d(r->c, r->c) + r->size * r->size, 2 * sqrt(cu * cu + cv * cv),
                          r->k->lmax, 37);
}

/* |y'| is at most the longer half axis, where these are at right angles. */
double ylm__rim_speed(const double *u, const double *v) {
  double uu = ylm_dot3d(u, u), vv = ylm_dot3d(v, v), size = sqrt(uu + vv);
  return fabs(ylm_dot3d(u, v)) <= 1e-9 * size * size ? sqrt(fmax(uu, vv)) : size;
}

static ylm_status full(rim *r, int n) {
  double s[YLM__STEPS][3], m[YLM__STEPS][3], inverse[YLM__STEPS];
  for (int i = 0; i < n; i++) node(r, 2 * YLM_PI * i / n, 2 * YLM_PI / n, s[i], m[i], inverse + i);
  return ylm__contour_nodes(r->k, n, (const double(*)[3])s, (const double(*)[3])m, inverse, true);
}

/* The part above the horizon, between the angles from and to, and the chord that closes it. */
static ylm_status above(rim *r, double from, double to, const double *up) {
  double a[3], b[3], da[3], db[3], sides[3][3];
  ylm_status s = part(r, from, to);
  place(r, from, a, da);
  place(r, to, b, db);
  if (s == YLM_OK) ylm__contour_arc(r->k, b, a, r->sign, false, &s);
  if (s == YLM_OK) s = ylm__contour_cut(r->k, b, db, up, r->sign);
  if (s == YLM_OK) s = ylm__contour_cut(r->k, a, da, up, -r->sign);
  /* the solid angle's integral along the chord: that of the arc a to b on its great circle */
  for (int q = 0; q < 3; q++) sides[0][q] = r->normal[q];
  double la = sqrt(ylm_dot3d(a, a)), lb = sqrt(ylm_dot3d(b, b));
  for (int q = 0; q < 3; q++) sides[1][q] = b[q] / lb, sides[2][q] = a[q] / la;
  double cross[3];
  ylm_cross3d(sides[1], sides[2], cross);
  r->solid_angle += r->sign * 2 *
                    atan2(ylm_dot3d(cross, sides[0]), 1 + ylm_dot3d(sides[0], sides[1]) +
                                                          ylm_dot3d(sides[1], sides[2]) +
                                                          ylm_dot3d(sides[2], sides[0]));
  return s;
}

/* Seven points, exact to degree 5 (Stroud 1971, S2 5-1). */
static ylm_status from_far(const rim *r) {
  double y[7][3], w[7], n[3];
  ylm_cross3d(r->u, r->v, n);
  double area = YLM_PI * sqrt(ylm_dot3d(n, n));
  memcpy(y[0], r->c, sizeof y[0]);
  w[0] = area / 4;
  for (int i = 0; i < 6; i++) {
    double c = sqrt(2.0 / 3) * cos(YLM_PI * i / 3), s = sqrt(2.0 / 3) * sin(YLM_PI * i / 3);
    for (int q = 0; q < 3; q++) y[1 + i][q] = r->c[q] + c * r->u[q] + s * r->v[q];
    w[1 + i] = area / 8;
  }
  return ylm__contour_points(r->k, 7, (const double(*)[3])y, w, r->normal);
}

/* Does x, in the ellipse's plane, lie in it? */
static bool holds(const double *c, const double *u, const double *v) {
  double uu = ylm_dot3d(u, u), uv = ylm_dot3d(u, v), vv = ylm_dot3d(v, v), det = uu * vv - uv * uv;
  double cu = ylm_dot3d(c, u), cv = ylm_dot3d(c, v);
  double a = (cu * vv - cv * uv) / det, b = (cv * uu - cu * uv) / det;
  return a * a + b * b <= 1 + 1e-14;
}

ylm_status ylm__contour_ellipse(const ylm__contour *k, const double (*ellipse)[3],
                                const double *normal, const double *horizon) {
  const double *c = ellipse[0], *u = ellipse[1], *v = ellipse[2];
  double height = ylm_dot3d(c, normal), sign = height < 0 ? -1 : 1, facing[3], turn[3];
  ylm__contour_clear(k);
  for (int a = 0; a < 3; a++) facing[a] = sign * normal[a];
  ylm_cross3d(u, v, turn);
  if (ylm_dot3d(turn, normal) < 0) sign = -sign; /* counter-clockwise about `facing` counts */
  double uu = ylm_dot3d(u, u), vv = ylm_dot3d(v, v), size = sqrt(uu + vv);
  double distance = sqrt(ylm_dot3d(c, c));
  if (fabs(height) <= YLM__EDGE_ON * (distance + size))
    return holds(c, u, v) ? ylm__contour_touched(k) : YLM_OK;
  rim r = {k, c, u, v, facing, sign, ylm__rim_speed(u, v), 0};
  double h = 0, hu = 0, hv = 0, swing = 0;
  if (horizon) {
    h = ylm_dot3d(c, horizon), hu = ylm_dot3d(u, horizon), hv = ylm_dot3d(v, horizon);
    swing = sqrt(hu * hu + hv * hv);
    if (h <= -swing) return YLM_OK;
  }
  ylm_status s;
  if (horizon && h < swing) {
    double middle = atan2(hv, hu), wide = acos(-h / swing);
    s = above(&r, middle - wide, middle + wide, horizon);
  } else if ((k->lmax + 4) * r.size < YLM__FAR * distance) {
    return from_far(&r);
  } else {
    int n = whole_steps(&r);
    s = n ? full(&r, n) : part(&r, 0, 2 * YLM_PI);
  }
  k->value[0] = fabs(r.solid_angle) * sqrt(1 / (4 * YLM_PI));
  return s;
}
