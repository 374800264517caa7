/* shape.c - the shape of flat lights: what is none, and which boxes meet one. */
#include "flat.h"

#include <math.h>

#include "gen/crossing.h"

/* Every coordinate finite and within bounds; the extent of the shape about its first vertex. */
static ylm_status check_numbers(size_t index, int sides, const double *v, double *size,
                                ylm_error *e) {
  size_t rows = ylm__polygon_rows(sides);
  *size = 0;
  for (size_t i = 0; i < 3 * rows; i++) {
    if (!isfinite(v[i]))
      return ylm_fail(e, YLM_EDOMAIN, "polygon %zu: a vertex is not finite", index + 1);
    if (fabs(v[i]) > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "polygon %zu is beyond %g", index + 1, YLM_LIGHT_EXTENT);
    *size = fmax(*size, fabs(v[i] - (sides ? v[i % 3] : 0)));
  }
  return YLM_OK;
}

static ylm_status describe_ellipse(size_t index, const double *v, double *normal, double *centroid,
                                   double *radius, double *reach, ylm_error *e) {
  const double *a = v + 3, *b = v + 6;
  double la = sqrt(ylm_dot3d(a, a)), lb = sqrt(ylm_dot3d(b, b)), n[3];
  ylm_cross3d(a, b, n);
  double area = sqrt(ylm_dot3d(n, n));
  if (!(area > 1e-9 * fmax(la, lb) * fmax(la, lb)))
    return ylm_fail(e, YLM_EDOMAIN, "polygon %zu has no area", index + 1);
  for (int k = 0; k < 3; k++) normal[k] = n[k] / area, centroid[k] = v[k];
  *radius = sqrt(area);
  *reach = fabs(ylm_dot3d(a, b)) < 1e-9 * la * lb ? fmax(la, lb) : la + lb;
  return YLM_OK;
}

/* Twice the vector area of a fan from the first vertex. */
static void vector_area(int n, const double *v, double *sum) {
  sum[0] = sum[1] = sum[2] = 0;
  for (int i = 1; i + 1 < n; i++) {
    double a[3], b[3], c[3];
    for (int k = 0; k < 3; k++) a[k] = v[3 * i + k] - v[k], b[k] = v[3 * i + 3 + k] - v[k];
    ylm_cross3d(a, b, c);
    for (int k = 0; k < 3; k++) sum[k] += c[k];
  }
}

static void centre(int n, const double *v, const double *normal, double *centroid) {
  double weight = 0, sum[3] = {0, 0, 0};
  for (int i = 1; i + 1 < n; i++) {
    double a[3], b[3], c[3];
    for (int k = 0; k < 3; k++) a[k] = v[3 * i + k] - v[k], b[k] = v[3 * i + 3 + k] - v[k];
    ylm_cross3d(a, b, c);
    double area = ylm_dot3d(c, normal);
    weight += area;
    for (int k = 0; k < 3; k++) sum[k] += area * (a[k] + b[k]) / 3;
  }
  for (int k = 0; k < 3; k++) centroid[k] = v[k] + sum[k] / weight;
}

/* Turning left at every corner is not enough: a pentagram does. All corners together must turn
   once, and the outline must not cross itself. */
static ylm_status check_outline(size_t index, int n, const double *v, const double *normal,
                                double size, ylm_error *e) {
  double turned = 0, a[3], b[3], c[3];
  for (int i = 0; i < n; i++) {
    const double *p = v + 3 * i, *q = v + 3 * ((i + 1) % n), *r = v + 3 * ((i + 2) % n);
    for (int k = 0; k < 3; k++) a[k] = q[k] - p[k], b[k] = r[k] - q[k];
    ylm_cross3d(a, b, c);
    double left = ylm_dot3d(c, normal);
    if (left < -1e-9 * size * size)
      return ylm_fail(e, YLM_EDOMAIN, "polygon %zu is not convex", index + 1);
    turned += atan2(left, ylm_dot3d(a, b));
  }
  if (turned > 3 * YLM_PI) return ylm_fail(e, YLM_EDOMAIN, "polygon %zu crosses itself", index + 1);
  return YLM_OK;
}

ylm_status ylm__polygon_describe(size_t index, int sides, const double *v, double *normal,
                                 double *centroid, double *radius, double *reach, ylm_error *e) {
  double size, sum[3];
  ylm_status s = check_numbers(index, sides, v, &size, e);
  if (s != YLM_OK) return s;
  if (!sides) return describe_ellipse(index, v, normal, centroid, radius, reach, e);
  vector_area(sides, v, sum);
  double twice = sqrt(ylm_dot3d(sum, sum));
  if (!(twice > 1e-12 * size * size))
    return ylm_fail(e, YLM_EDOMAIN, "polygon %zu has no area", index + 1);
  for (int k = 0; k < 3; k++) normal[k] = sum[k] / twice;
  centre(sides, v, normal, centroid);
  *reach = 0;
  for (int i = 0; i < sides; i++) {
    double d[3];
    for (int k = 0; k < 3; k++) d[k] = v[3 * i + k] - centroid[k];
    if (fabs(ylm_dot3d(d, normal)) > 1e-5 * size)
      return ylm_fail(e, YLM_EDOMAIN, "polygon %zu is not planar", index + 1);
    *reach = fmax(*reach, sqrt(ylm_dot3d(d, d)));
  }
  *radius = sqrt(twice / 2 / YLM_PI);
  return check_outline(index, sides, v, normal, size, e);
}

/* -- boxes --------------------------------------------------------------------------------- */

/* A box as centre and half size, larger by a rounding error: lights on a box's face meet it. */
typedef struct box {
  double c[3], h[3];
} box;

/* Do the box's and the polygon's shadows on an axis overlap? */
static bool shadows_meet(const box *b, int n, const double *v, const double *axis) {
  double lo = INFINITY, hi = -INFINITY, middle = ylm_dot3d(b->c, axis);
  double half = fabs(axis[0]) * b->h[0] + fabs(axis[1]) * b->h[1] + fabs(axis[2]) * b->h[2];
  for (int i = 0; i < n; i++) {
    double t = ylm_dot3d(v + 3 * i, axis) - middle;
    lo = fmin(lo, t), hi = fmax(hi, t);
  }
  return lo <= half && hi >= -half;
}

/* Separating axes: the box's, the polygon's normal, and those across an edge of each. */
static bool polygon_meets(const box *b, int n, const double *v, const double *normal) {
  static const double unit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int a = 0; a < 3; a++)
    if (!shadows_meet(b, n, v, unit[a])) return false;
  if (!shadows_meet(b, n, v, normal)) return false;
  for (int i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) {
      double edge[3], axis[3];
      for (int k = 0; k < 3; k++) edge[k] = v[3 * ((i + 1) % n) + k] - v[3 * i + k];
      ylm_cross3d(edge, unit[a], axis);
      if (!shadows_meet(b, n, v, axis)) return false;
    }
  return true;
}

/* The bounding sphere and the plane: all there is to an ellipse here. */
static bool disk_meets(const box *b, const double *centre, const double *normal, double reach) {
  double near = 0, half = 0, away = 0;
  for (int a = 0; a < 3; a++) {
    double d = fmax(0, fabs(b->c[a] - centre[a]) - b->h[a]);
    near += d * d;
    half += fabs(normal[a]) * b->h[a];
    away += normal[a] * (b->c[a] - centre[a]);
  }
  return near <= reach * reach && fabs(away) <= half;
}

ylm_status ylm__polygon_crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_polygons *p = f->self;
  for (size_t i = 0; i < n; i++) {
    box b;
    for (int a = 0; a < 3; a++) {
      double lo = boxes[6 * i + (size_t)a], hi = boxes[6 * i + 3 + (size_t)a];
      b.c[a] = box_middle(lo, hi);
      b.h[a] = box_reach(lo, hi);
    }
    out[i] = 0;
    for (size_t k = 0; k < p->n && !out[i]; k++) {
      const double *c = p->centroid + 3 * k, *m = p->normal + 3 * k;
      if (!p->exact) /* the sphere's surface, where the light is marked as `inside` */
        out[i] = sphere_meets_wide(c, p->radius[k], b.c, b.h);
      else if (disk_meets(&b, c, m, p->reach[k]))
        out[i] = !p->sides[k] || polygon_meets(&b, p->sides[k], p->vertices + 3 * p->first[k], m);
    }
  }
  return YLM_OK;
}
