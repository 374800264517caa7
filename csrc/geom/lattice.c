/*
** lattice.c - the inside of a closed mesh at the points of a lattice.
**
** A line along z through each column of points meets triangles; a point has as many windings as the triangles before
** it turn one way less those that turn the other way. An edge has one formula for both of its triangles, so no line
** passes between them.
*/
#include "lattice.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Points beside the mesh, in parts of its longest side. */
#define MARGIN 0.2

/* -- closed ------------------------------------------------------------------------------------- */

static ylm_status check_closed(const ylm_mesh *m, ylm_error *e) {
  uint32_t *name = ylm_alloc(m->vertices, sizeof *name);
  size_t places, open = 0;
  ylm_status s = name ? ylm_mesh_weld(m->vertices, m->position, name, &places) : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_mesh_open_edges(m->triangles, m->index, name, &open);
  ylm_free(name);
  if (s != YLM_OK) return ylm_fail_plain(e, s);
  if (!open) return s;
  return ylm_fail(e, YLM_EDOMAIN,
                  "the mesh has %zu edge%s that %s open, or between triangles that turn opposite "
                  "ways: what is inside of it?",
                  open, open == 1 ? "" : "s", open == 1 ? "is" : "are");
}

/* The volume within a closed mesh, without a sign. */
static double volume_of(const ylm_mesh *m, const double middle[3]) {
  double sum = 0;
  for (size_t t = 0; t < m->triangles; t++) {
    double v[3][3];
    for (size_t k = 0; k < 3; k++)
      for (size_t a = 0; a < 3; a++)
        v[k][a] = (double)m->position[3 * (size_t)m->index[3 * t + k] + a] - middle[a];
    sum += v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
           v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
           v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
  }
  return fabs(sum) / 6;
}

/* -- windings ------------------------------------------------------------------------------------ */

/* The side of the line from a to b, seen along z, on which p is. A line from b to a has the opposite sign. */
static int side(const double *a, const double *b, const double p[2]) {
  bool turned = a[0] > b[0] || (a[0] == b[0] && a[1] > b[1]);
  const double *from = turned ? b : a, *to = turned ? a : b;
  double area = (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]);
  return (area >= 0) != turned ? 1 : -1;
}

/* Lattice indices around [lo, hi] along an axis: first .. last - 1. */
static void range(const ylm__lattice *l, int axis, double lo, double hi, size_t *first,
                  size_t *last) {
  double a = floor((lo - l->low[axis]) / l->step), b = ceil((hi - l->low[axis]) / l->step) + 1;
  double n = (double)l->n[axis];
  *first = (size_t)fmin(n, fmax(0, a));
  *last = (size_t)fmin(n, fmax(0, b));
}

/* Notes where columns meet a triangle: at the first point above it. */
static void add_triangle(const ylm__lattice *l, double v[3][3], int8_t *winding) {
  size_t from[2], to[2];
  for (int a = 0; a < 2; a++)
    range(l, a, fmin(v[0][a], fmin(v[1][a], v[2][a])), fmax(v[0][a], fmax(v[1][a], v[2][a])),
          &from[a], &to[a]);
  double u[2][3];
  for (int a = 0; a < 3; a++) {
    u[0][a] = v[1][a] - v[0][a];
    u[1][a] = v[2][a] - v[0][a];
  }
  double nx = u[0][1] * u[1][2] - u[0][2] * u[1][1], ny = u[0][2] * u[1][0] - u[0][0] * u[1][2],
         nz = u[0][0] * u[1][1] - u[0][1] * u[1][0];
  for (size_t j = from[1]; j < to[1]; j++)
    for (size_t i = from[0]; i < to[0]; i++) {
      double p[2] = {l->low[0] + l->step * (double)i, l->low[1] + l->step * (double)j};
      int turn = side(v[0], v[1], p);
      if (side(v[1], v[2], p) != turn || side(v[2], v[0], p) != turn || nz == 0) continue;
      double z = v[0][2] - (nx * (p[0] - v[0][0]) + ny * (p[1] - v[0][1])) / nz;
      double k = ceil((z - l->low[2]) / l->step);
      if (!(k < (double)l->n[2])) continue;
      winding[lattice_at(l, i, j, k > 0 ? (size_t)k : 0)] += (int8_t)turn;
    }
}

static ylm_status fill(const ylm_mesh *m, ylm__lattice *l) {
  l->in = ylm_alloc_zero(l->points, 1);
  if (!l->in) return YLM_ENOMEM;
  int8_t *winding = (int8_t *)l->in;
  for (size_t t = 0; t < m->triangles; t++) {
    double v[3][3];
    for (size_t k = 0; k < 3; k++)
      for (size_t a = 0; a < 3; a++)
        v[k][a] = (double)m->position[3 * (size_t)m->index[3 * t + k] + a];
    add_triangle(l, v, winding);
  }
  l->inside = 0;
  for (size_t j = 0; j < l->n[1]; j++)
    for (size_t i = 0; i < l->n[0]; i++) {
      int sum = 0;
      for (size_t k = 0; k < l->n[2]; k++) {
        size_t at = lattice_at(l, i, j, k);
        sum += winding[at];
        l->in[at] = sum != 0;
        l->inside += sum != 0;
      }
    }
  return YLM_OK;
}

ylm_status ylm__lattice_create(const ylm_mesh *m, size_t inside, ylm__lattice *l, ylm_error *e) {
  double lo[3], hi[3], middle[3], longest = 0, box = 1;
  *l = (ylm__lattice){.step = 0};
  if (!m->triangles) return ylm_fail(e, YLM_EDOMAIN, "the mesh has no triangles");
  if (!ylm_all_finite(YLM_FLOAT, m->position, 3 * m->vertices, NULL))
    return ylm_fail(e, YLM_EDOMAIN, "the mesh is not finite");
  ylm_status s = check_closed(m, e);
  if (s != YLM_OK) return s;
  ylm_mesh_bounds(m, lo, hi);
  for (int a = 0; a < 3; a++) {
    middle[a] = (lo[a] + hi[a]) / 2;
    longest = fmax(longest, hi[a] - lo[a]);
  }
  double volume = volume_of(m, middle), margin = MARGIN * longest;
  for (int a = 0; a < 3; a++) box *= hi[a] - lo[a] + 2 * margin;
  if (!(volume > 1e-9 * longest * longest * longest))
    return ylm_fail(e, YLM_EDOMAIN, "the mesh encloses no volume");
  l->step = fmax(cbrt(volume / (double)inside), cbrt(box / (double)LATTICE_MOST * 1.1));
  l->volume = volume;
  l->points = 1;
  for (int a = 0; a < 3; a++) {
    l->n[a] = (size_t)ceil((hi[a] - lo[a] + 2 * margin) / l->step) + 1;
    l->low[a] = middle[a] - l->step * (double)(l->n[a] - 1) / 2;
    l->points *= l->n[a];
  }
  s = fill(m, l);
  if (s == YLM_OK && !l->inside)
    s = ylm_fail(e, YLM_EDOMAIN,
                 "the mesh is too thin: no point of a lattice of %.3g is inside of it", l->step);
  if (s == YLM_ENOMEM) ylm_no_memory(e);
  if (s != YLM_OK) {
    ylm_free(l->in);
    l->in = NULL;
  }
  return s;
}

/* -- depth ---------------------------------------------------------------------------------------- */

/*
** The square of the distance to the nearest zero along a line, plus the value there: the lower envelope of parabolas.
** Source  Felzenszwalb & Huttenlocher 2012
*/
static void envelope(size_t n, float *x, size_t stride, double *f, double *from, size_t *top) {
  size_t k = 0;
  for (size_t i = 0; i < n; i++) f[i] = (double)x[i * stride];
  top[0] = 0;
  from[0] = -INFINITY;
  for (size_t i = 1; i < n; i++) {
    double q = (double)i, s;
    for (;; k--) {
      double p = (double)top[k];
      s = (f[i] + q * q - f[top[k]] - p * p) / (2 * (q - p));
      if (s > from[k] || k == 0) break;
    }
    if (s > from[k]) k++;
    top[k] = i;
    from[k] = s;
  }
  for (size_t i = 0, j = 0; i < n; i++) {
    while (j < k && from[j + 1] < (double)i) j++;
    double d = (double)i - (double)top[j];
    x[i * stride] = (float)(d * d + f[top[j]]);
  }
}

float *ylm__lattice_depth(const ylm__lattice *l) {
  size_t longest = l->n[0] > l->n[1] ? l->n[0] : l->n[1];
  if (l->n[2] > longest) longest = l->n[2];
  float *depth = ylm_alloc(l->points, sizeof *depth);
  double *room = ylm_alloc(2 * longest, sizeof *room);
  size_t *top = ylm_alloc(longest, sizeof *top), across = l->n[0] * l->n[1];
  bool ok = depth && room && top;
  for (size_t i = 0; ok && i < l->points; i++) depth[i] = l->in[i] ? 1e12f : 0;
  for (size_t i = 0; ok && i < l->n[1] * l->n[2]; i++)
    envelope(l->n[0], depth + i * l->n[0], 1, room, room + longest, top);
  for (size_t i = 0; ok && i < l->n[0] * l->n[2]; i++)
    envelope(l->n[1], depth + i / l->n[0] * across + i % l->n[0], l->n[0], room, room + longest,
             top);
  for (size_t i = 0; ok && i < across; i++)
    envelope(l->n[2], depth + i, across, room, room + longest, top);
  for (size_t i = 0; ok && i < l->points; i++) depth[i] = (float)l->step * sqrtf(depth[i]);
  ylm_free(room);
  ylm_free(top);
  if (ok) return depth;
  ylm_free(depth);
  return NULL;
}
