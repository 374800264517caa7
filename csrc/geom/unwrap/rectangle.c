/* rectangle.c - the smallest rectangle of a flat chart: one of its sides lies on an edge of the convex hull. */
#include <math.h>
#include <stdlib.h>

#include "unwrap.h"

static int by_x(const void *a, const void *b) {
  const double *p = a, *q = b;
  if (p[0] != q[0]) return p[0] < q[0] ? -1 : 1;
  return p[1] < q[1] ? -1 : p[1] > q[1];
}

static double turn(const double p[2], const double q[2], const double r[2]) {
  return (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]);
}

/* The convex hull of n points, counter-clockwise; how many it has. Points are sorted; hull [2 n]. Source: Andrew 1979 */
static size_t hull_of(size_t n, double (*point)[2], double (*hull)[2]) {
  size_t h = 0;
  qsort(point, n, sizeof *point, by_x);
  for (size_t pass = 0; pass < 2; pass++) {
    size_t least = h + 1;
    for (size_t i = 0; i < n; i++) {
      const double *p = point[pass ? n - 1 - i : i];
      while (h > least && turn(hull[h - 2], hull[h - 1], p) <= 0) h--;
      memcpy(hull[h++], p, sizeof *hull);
    }
    h--;
  }
  return h;
}

/* The box of points turned so that (x, y) lies along the first axis. */
static void box_of(size_t n, const double (*point)[2], double x, double y, double low[2],
                   double high[2]) {
  low[0] = low[1] = INFINITY;
  high[0] = high[1] = -INFINITY;
  for (size_t i = 0; i < n; i++) {
    double at[2] = {x * point[i][0] + y * point[i][1], x * point[i][1] - y * point[i][0]};
    for (int a = 0; a < 2; a++) low[a] = fmin(low[a], at[a]), high[a] = fmax(high[a], at[a]);
  }
}

/* The direction whose box is smallest. */
static void choose(size_t h, const double (*hull)[2], double best[2]) {
  double least = INFINITY, low[2], high[2];
  size_t step = 1 + h / HULL_EDGES;
  for (size_t i = 0; i < h; i += step) {
    double x = hull[(i + 1) % h][0] - hull[i][0], y = hull[(i + 1) % h][1] - hull[i][1];
    double length = hypot(x, y);
    if (!(length > 0)) continue;
    box_of(h, hull, x / length, y / length, low, high);
    double area = (high[0] - low[0]) * (high[1] - low[1]);
    if (area < least * (1 - 1e-9)) least = area, best[0] = x / length, best[1] = y / length;
  }
}

ylm_status ylm__unwrap_turn(unwrap_chart *c) {
  size_t n = c->vertices;
  double(*point)[2] = ylm_alloc(n, sizeof *point), (*hull)[2] = ylm_alloc(n, 2 * sizeof *hull);
  double best[2] = {1, 0}, low[2], high[2];
  ylm_status s = point && hull ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    memcpy(point, c->flat, n * sizeof *point);
    size_t h = hull_of(n, point, hull);
    choose(h, (const double(*)[2])hull, best);
    box_of(n, (const double(*)[2])c->flat, best[0], best[1], low, high);
    for (size_t i = 0; i < n; i++) {
      double x = c->flat[i][0], y = c->flat[i][1];
      c->flat[i][0] = fmax(0, best[0] * x + best[1] * y - low[0]);
      c->flat[i][1] = fmax(0, best[0] * y - best[1] * x - low[1]);
    }
    for (int a = 0; a < 2; a++) c->size[a] = high[a] - low[a];
  }
  ylm_free(point);
  ylm_free(hull);
  return s;
}
