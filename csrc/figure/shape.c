/* shape.c - shapes grow: meshes, spheres, arrows, tubes, segments. */
#include "shape.h"

#include <math.h>
#include <string.h>

#include "ylm_list.h"
#include "ylm_vector.h"

void ylm_figure_shape_init(ylm_figure_shape *s, int corners) {
  memset(s, 0, sizeof *s);
  s->corners = corners;
}

void ylm_figure_shape_clear(ylm_figure_shape *s) {
  int corners = s->corners;
  ylm_free(s->position);
  ylm_free(s->normal);
  ylm_free(s->colour);
  ylm_free(s->index);
  ylm_figure_shape_init(s, corners);
}

bool ylm_figure_shape_bounds(const ylm_figure_shape *s, double b[6]) {
  for (size_t i = 0; i < s->points; i++)
    for (int a = 0; a < 3; a++) {
      double x = s->position[3 * i + (size_t)a];
      if (i == 0 || x < b[a]) b[a] = x;
      if (i == 0 || x > b[3 + a]) b[3 + a] = x;
    }
  return s->points > 0;
}

void ylm_figure_shape_reach(const ylm_figure_shape *s, size_t n, const double *d, double *out) {
  for (size_t k = 0; k < n; k++) out[k] = -INFINITY;
  for (size_t i = 0; i < s->points; i++) {
    const float *p = s->position + 3 * i;
    for (size_t k = 0; k < n; k++)
      out[k] = fmax(out[k], d[3 * k] * (double)p[0] + d[3 * k + 1] * (double)p[1] +
                                d[3 * k + 2] * (double)p[2]);
  }
}

ylm_status ylm__figure_reserve(ylm_figure_shape *s, size_t points, size_t cells) {
  if (points > UINT32_MAX - s->points || cells > SIZE_MAX / 4 - s->cells) return YLM_EOVERFLOW;
  points += s->points;
  cells += s->cells;
  if (points > s->point_room) {
    size_t room = ylm_list_room(s->point_room, points);
    if (!ylm_list_resize(&s->position, s->points, room, 3 * sizeof(float)) ||
        !ylm_list_resize(&s->colour, s->points, room, 4) ||
        (s->corners == 3 && !ylm_list_resize(&s->normal, s->points, room, 3 * sizeof(float))))
      return YLM_ENOMEM;
    s->point_room = room;
  }
  if (cells > s->cell_room) {
    size_t room = ylm_list_room(s->cell_room, cells);
    if (!ylm_list_resize(&s->index, s->cells, room, (size_t)s->corners * sizeof(uint32_t)))
      return YLM_ENOMEM;
    s->cell_room = room;
  }
  return YLM_OK;
}

static uint8_t byte(double x) { return x >= 1 ? 255 : x > 0 ? (uint8_t)(x * 255 + 0.5) : 0; }

uint32_t ylm__figure_point(ylm_figure_shape *s, const double p[3], const double n[3],
                           const double rgb[3], double alpha) {
  size_t k = s->points++;
  for (size_t a = 0; a < 3; a++) {
    s->position[3 * k + a] = (float)p[a];
    if (s->normal) s->normal[3 * k + a] = n ? (float)n[a] : 0;
    s->colour[4 * k + a] = byte(rgb[a]);
  }
  s->colour[4 * k + 3] = byte(alpha);
  return (uint32_t)k;
}

void ylm__figure_triangle(ylm_figure_shape *s, uint32_t a, uint32_t b, uint32_t c) {
  uint32_t *t = s->index + 3 * s->cells++;
  t[0] = a, t[1] = b, t[2] = c;
}

void ylm__figure_normals(ylm_figure_shape *s, size_t first_point, size_t first_cell) {
  memset(s->normal + 3 * first_point, 0, (s->points - first_point) * 3 * sizeof(float));
  for (size_t i = first_cell; i < s->cells; i++) {
    const uint32_t *t = s->index + 3 * i;
    const float *a = s->position + 3 * (size_t)t[0], *b = s->position + 3 * (size_t)t[1],
                *c = s->position + 3 * (size_t)t[2];
    float u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    float v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    for (int k = 0; k < 3; k++)
      for (size_t x = 0; x < 3; x++) s->normal[3 * (size_t)t[k] + x] += n[x];
  }
  for (size_t i = first_point; i < s->points; i++) {
    float *n = s->normal + 3 * i, d = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (d > 0)
      n[0] /= d, n[1] /= d, n[2] /= d;
    else
      n[2] = 1;
  }
}

ylm_status ylm_figure_add_mesh(ylm_figure_shape *s, size_t n, const double *position,
                               const double *normal, const double *colour, bool one_colour,
                               size_t m, const uint32_t *triangle, double opacity) {
  for (size_t i = 0; i < 3 * m; i++)
    if (triangle[i] >= n) return YLM_ERANGE;
  ylm_status status = ylm__figure_reserve(s, n, m);
  if (status != YLM_OK) return status;
  size_t first = s->points, first_cell = s->cells;
  for (size_t i = 0; i < n; i++)
    ylm__figure_point(s, position + 3 * i, normal ? normal + 3 * i : NULL,
                      colour + (one_colour ? 0 : 3 * i), opacity);
  for (size_t i = 0; i < m; i++)
    ylm__figure_triangle(s, (uint32_t)(first + triangle[3 * i]),
                         (uint32_t)(first + triangle[3 * i + 1]),
                         (uint32_t)(first + triangle[3 * i + 2]));
  if (!normal) ylm__figure_normals(s, first, first_cell);
  return YLM_OK;
}

ylm_status ylm_figure_add_spheres(ylm_figure_shape *s, size_t n, const double *centre,
                                  const double *radius, const double *colour, int detail) {
  size_t points, triangles;
  double *direction;
  uint32_t *index;
  ylm_status status = ylm_figure_sphere(detail, &points, &direction, &triangles, &index);
  if (status != YLM_OK) return status;
  if (n > UINT32_MAX / points)
    status = YLM_EOVERFLOW;
  else
    status = ylm__figure_reserve(s, n * points, n * triangles);
  for (size_t i = 0; i < n && status == YLM_OK; i++) {
    uint32_t first = (uint32_t)s->points;
    for (size_t k = 0; k < points; k++) {
      const double *d = direction + 3 * k, *c = centre + 3 * i;
      double p[3] = {c[0] + radius[i] * d[0], c[1] + radius[i] * d[1], c[2] + radius[i] * d[2]};
      ylm__figure_point(s, p, d, colour + 3 * i, 1);
    }
    for (size_t k = 0; k < triangles; k++)
      ylm__figure_triangle(s, first + index[3 * k], first + index[3 * k + 1],
                           first + index[3 * k + 2]);
  }
  ylm_free(direction);
  ylm_free(index);
  return status;
}

/* Two unit vectors orthogonal to the unit vector d and to each other. */
static void frame(const double d[3], double u[3], double v[3]) {
  int k = fabs(d[0]) < fabs(d[1]) ? (fabs(d[0]) < fabs(d[2]) ? 0 : 2)
                                  : (fabs(d[1]) < fabs(d[2]) ? 1 : 2);
  double dot = d[k], length = 0;
  for (int a = 0; a < 3; a++) u[a] = (a == k) - dot * d[a];
  for (int a = 0; a < 3; a++) length += u[a] * u[a];
  for (int a = 0; a < 3; a++) u[a] /= sqrt(length);
  v[0] = d[1] * u[2] - d[2] * u[1];
  v[1] = d[2] * u[0] - d[0] * u[2];
  v[2] = d[0] * u[1] - d[1] * u[0];
}

#define SIDES 10

/* A ring of SIDES points around `at`; normals point outwards, tilted by `slope` along d. */
static uint32_t ring(ylm_figure_shape *s, const double at[3], const double d[3], const double u[3],
                     const double v[3], double radius, double slope, const double rgb[3]) {
  uint32_t first = (uint32_t)s->points;
  for (int i = 0; i < SIDES; i++) {
    double t = 2 * YLM_PI * i / SIDES, p[3], n[3];
    for (int a = 0; a < 3; a++) {
      double out = cos(t) * u[a] + sin(t) * v[a];
      p[a] = at[a] + radius * out;
      n[a] = (out + slope * d[a]) / sqrt(1 + slope * slope);
    }
    ylm__figure_point(s, p, n, rgb, 1);
  }
  return first;
}

/* The band between two rings. */
static void band(ylm_figure_shape *s, uint32_t a, uint32_t b) {
  for (uint32_t i = 0; i < SIDES; i++) {
    uint32_t j = (i + 1) % SIDES;
    ylm__figure_triangle(s, a + i, a + j, b + j);
    ylm__figure_triangle(s, a + i, b + j, b + i);
  }
}

/* A flat disc facing back along d. */
static void disc(ylm_figure_shape *s, const double at[3], const double d[3], const double u[3],
                 const double v[3], double radius, const double rgb[3]) {
  double back[3] = {-d[0], -d[1], -d[2]};
  uint32_t middle = ylm__figure_point(s, at, back, rgb, 1);
  uint32_t first = (uint32_t)s->points;
  for (int i = 0; i < SIDES; i++) {
    double t = 2 * YLM_PI * i / SIDES, p[3];
    for (int a = 0; a < 3; a++) p[a] = at[a] + radius * (cos(t) * u[a] + sin(t) * v[a]);
    ylm__figure_point(s, p, back, rgb, 1);
  }
  for (uint32_t i = 0; i < SIDES; i++)
    ylm__figure_triangle(s, middle, first + (i + 1) % SIDES, first + i);
}

/* One arrow: a shaft of 70 % of the length and a head. */
static void arrow(ylm_figure_shape *s, const double at[3], const double along[3],
                  const double rgb[3]) {
  double length = sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
  if (!(length > 0) || isinf(length)) return;
  double d[3] = {along[0] / length, along[1] / length, along[2] / length}, u[3], v[3];
  double neck[3], tip[3], shaft = 0.042 * length, head = 0.125 * length;
  frame(d, u, v);
  for (int a = 0; a < 3; a++) neck[a] = at[a] + 0.68 * along[a], tip[a] = at[a] + along[a];
  disc(s, at, d, u, v, shaft, rgb);
  uint32_t r0 = ring(s, at, d, u, v, shaft, 0, rgb), r1 = ring(s, neck, d, u, v, shaft, 0, rgb);
  band(s, r0, r1);
  disc(s, neck, d, u, v, head, rgb);
  uint32_t r2 = ring(s, neck, d, u, v, head, 0.34, rgb);
  uint32_t r3 = ring(s, tip, d, u, v, 0, 0.34, rgb);
  band(s, r2, r3);
}

ylm_status ylm_figure_add_arrows(ylm_figure_shape *s, size_t n, const double *at,
                                 const double *along, const double *colour) {
  if (n > UINT32_MAX / (6 * SIDES + 2)) return YLM_EOVERFLOW;
  ylm_status status = ylm__figure_reserve(s, n * (6 * SIDES + 2), n * 6 * SIDES);
  for (size_t i = 0; i < n && status == YLM_OK; i++)
    arrow(s, at + 3 * i, along + 3 * i, colour + 3 * i);
  return status;
}

/* The unit direction of a polyline at its point i; false where points coincide. */
static bool tangent(const double *p, size_t n, size_t i, double d[3]) {
  const double *a = p + 3 * (i ? i - 1 : 0), *b = p + 3 * (i + 1 < n ? i + 1 : i);
  for (int k = 0; k < 3; k++) d[k] = b[k] - a[k];
  return ylm_unit3(d);
}

ylm_status ylm_figure_add_tube(ylm_figure_shape *s, size_t n, const double *point,
                               const double *colour, double radius) {
  if (n < 2) return YLM_OK;
  if (n > UINT32_MAX / SIDES) return YLM_EOVERFLOW;
  ylm_status status = ylm__figure_reserve(s, n * SIDES, (n - 1) * 2 * SIDES);
  if (status != YLM_OK) return status;
  double d[3], u[3] = {0, 0, 0}, v[3];
  uint32_t before = 0;
  bool begun = false;
  for (size_t i = 0; i < n; i++) {
    if (!tangent(point, n, i, d)) continue;
    double dot = u[0] * d[0] + u[1] * d[1] + u[2] * d[2], length = 0, carried[3];
    for (int a = 0; a < 3; a++) carried[a] = u[a] - dot * d[a], length += carried[a] * carried[a];
    if (length > 1e-6) { /* carry the frame along, so that the tube does not twist */
      for (int a = 0; a < 3; a++) u[a] = carried[a] / sqrt(length);
      v[0] = d[1] * u[2] - d[2] * u[1];
      v[1] = d[2] * u[0] - d[0] * u[2];
      v[2] = d[0] * u[1] - d[1] * u[0];
    } else
      frame(d, u, v);
    uint32_t r = ring(s, point + 3 * i, d, u, v, radius, 0, colour + 3 * i);
    if (begun) band(s, before, r);
    before = r;
    begun = true;
  }
  return YLM_OK;
}

ylm_status ylm_figure_add_segments(ylm_figure_shape *s, size_t n, const double *from,
                                   const double *to, const double colour[4]) {
  if (n > UINT32_MAX / 2) return YLM_EOVERFLOW;
  ylm_status status = ylm__figure_reserve(s, 2 * n, n);
  for (size_t i = 0; i < n && status == YLM_OK; i++) {
    uint32_t a = ylm__figure_point(s, from + 3 * i, NULL, colour, colour[3]);
    uint32_t b = ylm__figure_point(s, to + 3 * i, NULL, colour, colour[3]);
    uint32_t *t = s->index + 2 * s->cells++;
    t[0] = a, t[1] = b;
  }
  return status;
}
