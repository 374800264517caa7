/* mesh.c - meshes: memory, bounds, normals, transforms. */
#include "ylm_geom.h"

#include <math.h>
#include <string.h>

#include "ylm_vector.h"

ylm_status ylm_mesh_create(size_t vertices, size_t triangles, bool normals, bool uvs,
                           ylm_mesh **out, ylm_error *e) {
  *out = NULL;
  if (vertices > YLM_MESH_MAX || triangles > YLM_MESH_MAX)
    return ylm_fail(e, YLM_EOVERFLOW, "a mesh of %zu vertices and %zu triangles is too large",
                    vertices, triangles);
  ylm_mesh *m = ylm_alloc_zero(1, sizeof *m);
  if (m) {
    m->vertices = vertices;
    m->triangles = triangles;
    m->position = ylm_alloc_zero(vertices * 3, sizeof(float));
    m->index = ylm_alloc_zero(triangles * 3, sizeof(uint32_t));
    if (normals) m->normal = ylm_alloc_zero(vertices * 3, sizeof(float));
    if (uvs) m->uv = ylm_alloc_zero(vertices * 2, sizeof(float));
  }
  if (!m || !m->position || !m->index || (normals && !m->normal) || (uvs && !m->uv)) {
    ylm_mesh_free(m);
    return ylm_fail(e, YLM_ENOMEM, "no memory for a mesh of %zu vertices and %zu triangles",
                    vertices, triangles);
  }
  *out = m;
  return YLM_OK;
}

void ylm_mesh_free(ylm_mesh *m) {
  if (!m) return;
  ylm_free(m->position);
  ylm_free(m->normal);
  ylm_free(m->uv);
  ylm_free(m->index);
  ylm_free(m->colour);
  ylm_free(m);
}

void ylm_mesh_bounds(const ylm_mesh *m, double lo[3], double hi[3]) {
  for (int a = 0; a < 3; a++) lo[a] = hi[a] = m->vertices ? m->position[a] : 0;
  for (size_t i = 1; i < m->vertices; i++)
    for (int a = 0; a < 3; a++) {
      double x = m->position[3 * i + (size_t)a];
      if (x < lo[a]) lo[a] = x;
      if (x > hi[a]) hi[a] = x;
    }
  for (int a = 0; a < 3; a++) lo[a] += m->origin[a], hi[a] += m->origin[a];
}

void ylm_mesh_set_places(ylm_mesh *m, const double *place) {
  double box[6] = {0};
  for (size_t i = 0; i < 3 * m->vertices; i++) {
    size_t a = i % 3;
    box[a] = i < 3 || place[i] < box[a] ? place[i] : box[a];
    box[a + 3] = i < 3 || place[i] > box[a + 3] ? place[i] : box[a + 3];
  }
  ylm_origin(box, m->origin);
  for (size_t i = 0; i < 3 * m->vertices; i++)
    m->position[i] = (float)(place[i] - m->origin[i % 3]);
}

void ylm_mesh_area_vector(const ylm_mesh *m, size_t t, double n[3]) {
  const float *a = m->position + 3 * (size_t)m->index[3 * t];
  const float *b = m->position + 3 * (size_t)m->index[3 * t + 1];
  const float *c = m->position + 3 * (size_t)m->index[3 * t + 2];
  double u[3], v[3];
  for (int k = 0; k < 3; k++) u[k] = (double)b[k] - a[k], v[k] = (double)c[k] - a[k];
  n[0] = u[1] * v[2] - u[2] * v[1];
  n[1] = u[2] * v[0] - u[0] * v[2];
  n[2] = u[0] * v[1] - u[1] * v[0];
}

double ylm_mesh_area(const ylm_mesh *m) {
  double sum = 0, n[3];
  for (size_t t = 0; t < m->triangles; t++) {
    ylm_mesh_area_vector(m, t, n);
    sum += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  }
  return sum;
}

ylm_status ylm_mesh_make_normals(ylm_mesh *m) {
  double *sum = ylm_alloc_zero(m->vertices * 3, sizeof(double)), n[3];
  float *normal = m->normal ? m->normal : ylm_alloc_zero(m->vertices * 3, sizeof(float));
  if (!sum || !normal) {
    ylm_free(sum);
    if (!m->normal) ylm_free(normal);
    return YLM_ENOMEM;
  }
  for (size_t t = 0; t < m->triangles; t++) {
    ylm_mesh_area_vector(m, t, n);
    for (int k = 0; k < 3; k++)
      for (int a = 0; a < 3; a++) sum[3 * (size_t)m->index[3 * t + (size_t)k] + (size_t)a] += n[a];
  }
  for (size_t i = 0; i < m->vertices; i++) {
    double *s = sum + 3 * i;
    if (ylm_unit3(s))
      for (int a = 0; a < 3; a++) normal[3 * i + (size_t)a] = (float)s[a];
    else
      normal[3 * i] = normal[3 * i + 1] = 0, normal[3 * i + 2] = 1;
  }
  ylm_free(sum);
  m->normal = normal;
  return YLM_OK;
}

/* -- transforms ----------------------------------------------------------------- */

void ylm_transform_identity(double m[12]) {
  static const double one[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  memcpy(m, one, sizeof one);
}

void ylm_transform_rotate(double m[12], const double axis[3], double radians) {
  double u[3] = {axis[0], axis[1], axis[2]}, c = cos(radians), s = sin(radians), k = 1 - c;
  ylm_unit3(u);
  double x = u[0], y = u[1], z = u[2];
  double r[12] = {c + k * x * x,     k * x * y - s * z, k * x * z + s * y, 0,
                  k * x * y + s * z, c + k * y * y,     k * y * z - s * x, 0,
                  k * x * z - s * y, k * y * z + s * x, c + k * z * z,     0};
  memcpy(m, r, sizeof r);
}

void ylm_transform_compose(double out[12], const double a[12], const double b[12]) {
  double r[12];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++) {
      r[4 * i + j] = j == 3 ? a[4 * i + 3] : 0;
      for (int k = 0; k < 3; k++) r[4 * i + j] += a[4 * i + k] * b[4 * k + j];
    }
  memcpy(out, r, sizeof r);
}

/* The matrix of cofactors of the linear part (det * inverse transpose); returns the determinant. */
static double cofactors(const double m[12], double c[9]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c[3 * i + j] = m[4 * i1 + j1] * m[4 * i2 + j2] - m[4 * i1 + j2] * m[4 * i2 + j1];
    }
  return m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
}

ylm_status ylm_mesh_transform(ylm_mesh *mesh, const double m[12], ylm_error *e) {
  double c[9], det = cofactors(m, c);
  if (!isfinite(det) || det == 0)
    return ylm_fail(e, YLM_EDOMAIN, "the transform is singular (determinant %g)", det);
  double *moved = ylm_alloc(mesh->vertices * 3, sizeof(double));
  if (!moved) return ylm_no_memory(e);
  bool finite = true;
  for (size_t i = 0; i < mesh->vertices; i++) {
    double p[3];
    ylm_mesh_place(mesh, i, p);
    for (int a = 0; a < 3; a++) {
      const double *r = m + 4 * a;
      double x = r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3];
      moved[3 * i + (size_t)a] = x;
      if (finite && !isfinite((float)x)) {
        ylm_fail(e, YLM_EDOMAIN, "the transform moves vertex %zu to infinity", i + 1);
        finite = false;
      }
    }
  }
  if (finite) ylm_mesh_set_places(mesh, moved);
  ylm_free(moved);
  if (!finite) return YLM_EDOMAIN;
  double sign = det < 0 ? -1 : 1;
  for (size_t i = 0; mesh->normal && i < mesh->vertices; i++) {
    float *n = mesh->normal + 3 * i;
    double r[3];
    for (int a = 0; a < 3; a++)
      r[a] = sign * (c[3 * a] * n[0] + c[3 * a + 1] * n[1] + c[3 * a + 2] * n[2]);
    if (ylm_unit3(r))
      for (int a = 0; a < 3; a++) n[a] = (float)r[a];
  }
  for (size_t t = 0; det < 0 && t < mesh->triangles; t++) {
    uint32_t k = mesh->index[3 * t + 1];
    mesh->index[3 * t + 1] = mesh->index[3 * t + 2];
    mesh->index[3 * t + 2] = k;
  }
  return YLM_OK;
}

/* A mesh of n vertices that have what those of another have, around its origin, with these triangles. */
static ylm_status begin_like(const ylm_mesh *mesh, size_t n, size_t triangles,
                             const uint32_t *index, ylm_mesh **out, ylm_error *e) {
  ylm_status s = ylm_mesh_create(n, triangles, mesh->normal != NULL, mesh->uv != NULL, out, e);
  ylm_mesh *to = *out;
  if (s != YLM_OK) return s;
  if (mesh->colour && !(to->colour = ylm_alloc(3 * n, sizeof(float)))) {
    ylm_mesh_free(to);
    *out = NULL;
    return ylm_no_memory(e);
  }
  memcpy(to->index, index, 3 * triangles * sizeof *index);
  memcpy(to->origin, mesh->origin, sizeof mesh->origin);
  return YLM_OK;
}

ylm_status ylm_mesh_pick(const ylm_mesh *mesh, size_t n, const uint32_t *from,
                         const uint32_t *index, bool turned, ylm_mesh **out, ylm_error *e) {
  ylm_status s = begin_like(mesh, n, mesh->triangles, index, out, e);
  ylm_mesh *to = *out;
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < n; i++) {
    size_t of = from[i];
    memcpy(to->position + 3 * i, mesh->position + 3 * of, 3 * sizeof(float));
    for (size_t a = 0; mesh->normal && a < 3; a++)
      to->normal[3 * i + a] = turned ? -mesh->normal[3 * of + a] : mesh->normal[3 * of + a];
    if (mesh->uv) memcpy(to->uv + 2 * i, mesh->uv + 2 * of, 2 * sizeof(float));
    if (mesh->colour) memcpy(to->colour + 3 * i, mesh->colour + 3 * of, 3 * sizeof(float));
  }
  return YLM_OK;
}

/* Numbers [width] of a vertex between others. */
static void mix(const ylm_mesh_mix *m, size_t width, const float *of, float *out) {
  double sum = (double)m->part[0] + (double)m->part[1] + (double)m->part[2];
  for (size_t a = 0; a < width; a++) {
    double x = 0;
    for (int k = 0; k < 3; k++)
      if (m->part[k]) x += (double)m->part[k] * (double)of[width * m->of[k] + a];
    out[a] = (float)(x / sum);
  }
}

ylm_status ylm_mesh_blend(const ylm_mesh *mesh, size_t n, const ylm_mesh_mix *from,
                          size_t triangles, const uint32_t *index, bool turned, ylm_mesh **out,
                          ylm_error *e) {
  ylm_status s = begin_like(mesh, n, triangles, index, out, e);
  ylm_mesh *to = *out;
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < n; i++) {
    bool old = !from[i].part[1] && !from[i].part[2];
    mix(&from[i], 3, mesh->position, to->position + 3 * i);
    if (mesh->uv) mix(&from[i], 2, mesh->uv, to->uv + 2 * i);
    if (mesh->colour) mix(&from[i], 3, mesh->colour, to->colour + 3 * i);
    if (!mesh->normal) continue;
    float *normal = to->normal + 3 * i;
    mix(&from[i], 3, mesh->normal, normal);
    float length = sqrtf(ylm_dot3(normal, normal)), scale = old || !(length > 0) ? 1 : 1 / length;
    for (size_t a = 0; a < 3; a++) normal[a] *= turned ? -scale : scale;
  }
  return YLM_OK;
}
