/* flatten.c - a chart on a plane: its vertices, their places, its stretch. */
#include <math.h>

#include "unwrap.h"
#include "ylm_list.h"
#include "ylm_vector.h"

/* -- vertices: corners that the chart's own edges join ---------------------------------------------- */

static void unite(uint32_t *parent, uint32_t a, uint32_t b) {
  a = ylm_list_root(parent, a), b = ylm_list_root(parent, b);
  if (a < b)
    parent[b] = a;
  else
    parent[a] = b;
}

/* Numbers the vertices of a chart in u->corner; a place where two fans of triangles meet is two of them. */
static void number(const ylm_unwrap *u, const unwrap_surface *s, unwrap_chart *c,
                   uint32_t *root /* [c->triangles * 3] */) {
  uint32_t chart = s->of[u->list[c->first]], *parent = u->corner;
  for (size_t i = 0; i < c->triangles; i++)
    for (uint32_t k = 0; k < 3; k++)
      parent[3 * u->list[c->first + i] + k] = 3 * u->list[c->first + i] + k;
  for (size_t i = 0; i < c->triangles; i++)
    for (uint32_t k = 3 * u->list[c->first + i], end = k + 3; k < end; k++) {
      uint32_t other = s->across[k];
      if (other == UNWRAP_NONE || s->of[other / 3] != chart) continue;
      unite(parent, k, (uint32_t)unwrap_next(other));
      unite(parent, (uint32_t)unwrap_next(k), other);
    }
  for (size_t i = 0; i < 3 * c->triangles; i++)
    root[i] = ylm_list_root(parent, 3 * u->list[c->first + i / 3] + (uint32_t)(i % 3));
  c->vertices = 0;
  for (size_t i = 0; i < 3 * c->triangles;
       i++) /* a root is the first corner of its set in the mesh */
    if (root[i] == 3 * u->list[c->first + i / 3] + i % 3) u->corner[root[i]] = c->vertices++;
  for (size_t i = 0; i < 3 * c->triangles; i++) {
    uint32_t corner = 3 * u->list[c->first + i / 3] + (uint32_t)(i % 3);
    if (root[i] != corner) u->corner[corner] = u->corner[root[i]];
  }
}

/* -- a plane ---------------------------------------------------------------------------------------- */

/* The mean normal of a chart, and the least cosine of a triangle's with it. */
static double facing(const ylm_unwrap *u, const unwrap_surface *s, const unwrap_chart *c,
                     double mean[3]) {
  double least = 1;
  memset(mean, 0, 3 * sizeof *mean);
  for (size_t i = c->first; i < c->first + c->triangles; i++)
    for (int k = 0; k < 3; k++) mean[k] += s->area[u->list[i]] * s->normal[u->list[i]][k];
  if (!ylm_unit3(mean)) return -1;
  for (size_t i = c->first; i < c->first + c->triangles; i++)
    least = fmin(least, ylm_dot3d(s->normal[u->list[i]], mean));
  return least;
}

static void project(const ylm_unwrap *u, const unwrap_surface *s, unwrap_chart *c,
                    const double normal[3]) {
  double x[3] = {0, 0, 0}, y[3];
  int least = fabs(normal[0]) <= fabs(normal[1]) ? 0 : 1;
  if (fabs(normal[2]) < fabs(normal[least])) least = 2;
  x[least] = 1;
  ylm_cross3d(normal, x, y);
  ylm_unit3(y);
  ylm_cross3d(y, normal, x);
  const double *origin = s->point[u->list[c->first]][0];
  for (size_t i = c->first; i < c->first + c->triangles; i++)
    for (size_t k = 0; k < 3; k++) {
      double *at = c->flat[u->corner[3 * u->list[i] + k]], d[3];
      for (int a = 0; a < 3; a++) d[a] = s->point[u->list[i]][k][a] - origin[a];
      at[0] = ylm_dot3d(d, x);
      at[1] = ylm_dot3d(d, y);
    }
}

/* -- stretch ---------------------------------------------------------------------------------------- */

/* Half of the squares of the singular values of the map from flat to surface, of a triangle; `twice`: its flat area, twice. */
static double stretch_of(const ylm_unwrap *u, const unwrap_surface *s, const unwrap_chart *c,
                         size_t t, double *twice) {
  const double *p = c->flat[u->corner[3 * t]], *q = c->flat[u->corner[3 * t + 1]],
               *r = c->flat[u->corner[3 * t + 2]];
  double across[3], along[3];
  *twice = (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]);
  for (int a = 0; a < 3; a++) {
    double b = s->point[t][1][a] - s->point[t][0][a], d = s->point[t][2][a] - s->point[t][0][a];
    across[a] = (b * (r[1] - p[1]) - d * (q[1] - p[1])) / *twice;
    along[a] = (d * (q[0] - p[0]) - b * (r[0] - p[0])) / *twice;
  }
  return (ylm_dot3d(across, across) + ylm_dot3d(along, along)) / 2;
}

/* Scales a chart to its area on the surface, and measures its stretch. */
static void scale(const ylm_unwrap *u, const unwrap_surface *s, unwrap_chart *c) {
  double flat = 0, square = 0, twice;
  c->area = 0;
  for (size_t i = c->first; i < c->first + c->triangles; i++) {
    double one = stretch_of(u, s, c, u->list[i], &twice);
    c->area += s->area[u->list[i]];
    flat += twice / 2;
    square += s->area[u->list[i]] * one;
  }
  double factor = sqrt(c->area / flat);
  for (size_t i = 0; i < c->vertices; i++)
    for (int a = 0; a < 2; a++) c->flat[i][a] *= factor;
  c->stretch = sqrt(square / c->area) / factor;
}

ylm_status ylm__unwrap_flatten(ylm_unwrap *u, const unwrap_surface *s, unwrap_chart *c,
                               bool *valid) {
  double normal[3], least = facing(u, s, c, normal);
  uint32_t *root = ylm_alloc(3 * c->triangles, sizeof *root);
  *valid = false;
  if (!root) return YLM_ENOMEM;
  number(u, s, c, root);
  ylm_free(root);
  ylm_free(c->flat);
  c->flat = NULL;
  if (!(least > 0)) return YLM_OK;
  c->flat = ylm_alloc(c->vertices, sizeof *c->flat);
  if (!c->flat) return YLM_ENOMEM;
  project(u, s, c, normal);
  c->curved = least < NEARLY_FLAT;
  ylm_status status = c->curved ? ylm__unwrap_rigid(u, s, c) : YLM_OK;
  if (status == YLM_OK) status = ylm__unwrap_valid(u, s, c, valid);
  if (status == YLM_OK && *valid) scale(u, s, c);
  return status == YLM_OK && *valid ? ylm__unwrap_turn(c) : status;
}
