/* lobe.c - SH vectors as surfaces around a point. */
#include "shape.h"

#include <math.h>
#include <stdlib.h>

/* One vertex per point of the octahedron's surface lattice |x|+|y|+|z| = n: its index, or -1. */
static size_t lattice_slot(int n, int x, int y, int z) {
  return ((size_t)(z + n) * (size_t)(2 * n + 1) + (size_t)(y + n)) * (size_t)(2 * n + 1) +
         (size_t)(x + n);
}

static void collect_directions(int n, uint32_t *number, double *direction) {
  uint32_t next = 0;
  for (int z = -n; z <= n; z++)
    for (int y = -(n - abs(z)); y <= n - abs(z); y++) {
      int x = n - abs(z) - abs(y);
      for (int side = 0; side < (x ? 2 : 1); side++) {
        int sx = side ? x : -x;
        double length = sqrt((double)(sx * sx + y * y + z * z)), *d = direction + 3 * next;
        d[0] = sx / length, d[1] = y / length, d[2] = z / length;
        number[lattice_slot(n, sx, y, z)] = next++;
      }
    }
}

/* The n^2 triangles of one octant, counter-clockwise seen from outside. */
static void octant(int n, int sx, int sy, int sz, const uint32_t *number, uint32_t **t) {
  bool flip = sx * sy * sz < 0;
#define AT(i, j) number[lattice_slot(n, sx * (i), sy * (j), sz * (n - (i) - (j)))]
  for (int i = 0; i < n; i++)
    for (int j = 0; i + j < n; j++) {
      uint32_t a = AT(i, j), b = AT(i + 1, j), c = AT(i, j + 1);
      uint32_t *o = *t;
      o[0] = a, o[1] = flip ? c : b, o[2] = flip ? b : c;
      *t += 3;
      if (i + j + 2 > n) continue;
      uint32_t d = AT(i + 1, j + 1);
      o = *t;
      o[0] = b, o[1] = flip ? c : d, o[2] = flip ? d : c;
      *t += 3;
    }
#undef AT
}

ylm_status ylm_figure_sphere(int detail, size_t *points, double **direction, size_t *triangles,
                             uint32_t **index) {
  if (detail < 0 || detail > 7) return YLM_ERANGE;
  int n = 1 << detail, side = 2 * n + 1;
  *points = (size_t)(4 * n * n + 2);
  *triangles = (size_t)(8 * n * n);
  uint32_t *number = ylm_alloc((size_t)side * (size_t)side * (size_t)side, sizeof *number);
  *direction = ylm_alloc(*points, 3 * sizeof(double));
  *index = ylm_alloc(*triangles, 3 * sizeof(uint32_t));
  if (!number || !*direction || !*index) {
    ylm_free(number);
    ylm_free(*direction);
    ylm_free(*index);
    return YLM_ENOMEM;
  }
  collect_directions(n, number, *direction);
  uint32_t *t = *index;
  for (int k = 0; k < 8; k++) octant(n, k & 1 ? -1 : 1, k & 2 ? -1 : 1, k & 4 ? -1 : 1, number, &t);
  ylm_free(number);
  return YLM_OK;
}

/* f at every direction of the sphere; returns the largest |f|. */
static double evaluate(size_t points, int count, const double *basis, const double *c, double *f) {
  double largest = 0;
  for (size_t k = 0; k < points; k++) {
    double sum = 0;
    for (int i = 0; i < count; i++) sum += basis[k * (size_t)count + (size_t)i] * c[i];
    f[k] = sum;
    largest = fmax(largest, fabs(sum));
  }
  return largest;
}

ylm_status ylm_figure_add_lobes(ylm_figure_shape *s, size_t n, int count, int detail,
                                const double *basis, const double *coefficient,
                                const double *centre, const double *scale, bool fit,
                                const double positive[3], const double negative[3]) {
  size_t points, triangles;
  double *direction, *f;
  uint32_t *index;
  ylm_status status = ylm_figure_sphere(detail, &points, &direction, &triangles, &index);
  if (status != YLM_OK) return status;
  f = ylm_alloc(points, sizeof *f);
  if (!f)
    status = YLM_ENOMEM;
  else if (n > UINT32_MAX / points)
    status = YLM_EOVERFLOW;
  else
    status = ylm__figure_reserve(s, n * points, n * triangles);
  for (size_t i = 0; i < n && status == YLM_OK; i++) {
    size_t first = s->points, first_cell = s->cells;
    double largest = evaluate(points, count, basis, coefficient + i * (size_t)count, f);
    double unit = !fit ? scale[i] : largest > 0 && isfinite(largest) ? scale[i] / largest : 0;
    for (size_t k = 0; k < points; k++) {
      double r = unit * fabs(f[k]), p[3];
      for (size_t a = 0; a < 3; a++) p[a] = centre[3 * i + a] + r * direction[3 * k + a];
      ylm__figure_point(s, p, NULL, f[k] < 0 ? negative : positive, 1);
    }
    for (size_t k = 0; k < triangles; k++)
      ylm__figure_triangle(s, (uint32_t)first + index[3 * k], (uint32_t)first + index[3 * k + 1],
                           (uint32_t)first + index[3 * k + 2]);
    ylm__figure_normals(s, first, first_cell);
  }
  ylm_free(f);
  ylm_free(direction);
  ylm_free(index);
  return status;
}
