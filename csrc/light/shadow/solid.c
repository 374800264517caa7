/* solid.c - is a mesh a closed convex solid? Its faces, planes, size. */
#include "shadow.h"
#include "ylm_geom.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the size of the solid: vertices that are nearer to a plane lie in it. */
#define FLAT 1e-6
#define RECORD 7 /* numbers of a polygon's record before its vertices */

typedef struct mesh {
  size_t vertices, triangles;
  double *at;      /* [vertices][3] each place once */
  uint32_t *index; /* [triangles][3] of these */
  double size;
} mesh;

static void cross(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/* -- places ---------------------------------------------------------------------------------- */

/* Vertices at one place become one; triangles without an area go. How many edges are open? */
static ylm_status weld(size_t vertices, const float *position, size_t triangles,
                       const uint32_t *index, mesh *m, size_t *open) {
  uint32_t *name = ylm_alloc(vertices, sizeof *name);
  m->at = ylm_alloc(vertices, 3 * sizeof *m->at);
  m->index = ylm_alloc(triangles, 3 * sizeof *m->index);
  ylm_status s = name && m->at && m->index ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_mesh_weld(vertices, position, name, &m->vertices);
  if (s == YLM_OK) s = ylm_mesh_open_edges(triangles, index, name, open);
  for (size_t i = 0; s == YLM_OK && i < vertices; i++)
    for (size_t a = 0; a < 3; a++)
      m->at[3 * (size_t)name[i] + a] = (double)(position[3 * i + a] + 0.0f); /* no -0 */
  for (size_t t = 0; s == YLM_OK && t < triangles; t++) {
    uint32_t *to = m->index + 3 * m->triangles;
    for (size_t k = 0; k < 3; k++) to[k] = name[index[3 * t + k]];
    if (to[0] != to[1] && to[1] != to[2] && to[2] != to[0]) m->triangles++;
  }
  ylm_free(name);
  return s;
}

/* -- convex ---------------------------------------------------------------------------------- */

static double plane_of(const mesh *m, size_t t, double sign, double plane[4]) {
  const double *p = m->at + 3 * m->index[3 * t], *q = m->at + 3 * m->index[3 * t + 1],
               *r = m->at + 3 * m->index[3 * t + 2];
  double u[3], v[3];
  for (int a = 0; a < 3; a++) u[a] = q[a] - p[a], v[a] = r[a] - p[a];
  cross(u, v, plane);
  double twice = sqrt(plane[0] * plane[0] + plane[1] * plane[1] + plane[2] * plane[2]);
  for (int a = 0; a < 3; a++) plane[a] = twice > 0 ? sign * plane[a] / twice : 0;
  plane[3] = plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2];
  return twice / 2;
}

static double above(const double plane[4], const double p[3]) {
  return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] - plane[3];
}

/* Six times the volume, negative where triangles are seen clockwise from outside. */
static double volume6(const mesh *m) {
  double sum = 0, n[3];
  for (size_t t = 0; t < m->triangles; t++) {
    const double *p = m->at + 3 * m->index[3 * t];
    cross(m->at + 3 * m->index[3 * t + 1], m->at + 3 * m->index[3 * t + 2], n);
    sum += p[0] * n[0] + p[1] * n[1] + p[2] * n[2];
  }
  return sum;
}

/* A corner of a face, and where it stands in the face's plane. */
typedef struct corner {
  double x, y;
  const double *at;
} corner;

static int by_xy(const void *a, const void *b) {
  const corner *p = a, *q = b;
  if (p->x != q->x) return p->x < q->x ? -1 : 1;
  return p->y < q->y ? -1 : p->y > q->y;
}

/* Does c stand to the left of the way from a to b, by more than rounding? */
static bool turns_left(const corner *a, const corner *b, const corner *c, double least) {
  return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x) > least;
}

/* The hull of n corners to `hull`, counter-clockwise: Andrew's monotone chain. Returns the number of its corners. */
static size_t hull_of(corner *c, size_t n, double least, corner *hull) {
  size_t k = 0;
  qsort(c, n, sizeof *c, by_xy);
  for (size_t i = 0; i < n; i++) {
    while (k >= 2 && !turns_left(&hull[k - 2], &hull[k - 1], &c[i], least)) k--;
    hull[k++] = c[i];
  }
  for (size_t i = n - 1, lower = k + 1; i-- > 0;) {
    while (k >= lower && !turns_left(&hull[k - 2], &hull[k - 1], &c[i], least)) k--;
    hull[k++] = c[i];
  }
  return k - 1;
}

/* The outline of the face in a plane, in the second half of c [2 * vertices + 1]. Returns the number of its corners. */
static size_t list_corners(const mesh *m, const double plane[4], corner *c) {
  size_t n = 0;
  double u[3] = {0}, v[3], length = 0;
  int least = fabs(plane[0]) < fabs(plane[1]) ? 0 : 1;
  if (fabs(plane[2]) < fabs(plane[least])) least = 2;
  v[0] = v[1] = v[2] = 0;
  v[least] = 1;
  cross(v, plane, u);
  for (int a = 0; a < 3; a++) length += u[a] * u[a];
  for (int a = 0; a < 3; a++) u[a] /= sqrt(length);
  cross(plane, u, v);
  for (size_t i = 0; i < m->vertices; i++) {
    const double *p = m->at + 3 * i;
    if (fabs(above(plane, p)) > FLAT * m->size) continue;
    c[n++] = (corner){u[0] * p[0] + u[1] * p[1] + u[2] * p[2],
                      v[0] * p[0] + v[1] * p[1] + v[2] * p[2], p};
  }
  return hull_of(c, n, FLAT * m->size * m->size, c + m->vertices);
}

/* Appends a face as polygons of radiance 1/2. */
static void add_face(const corner *c, size_t n, ylm__solid *s) {
  for (size_t from = 1; from + 1 < n; from += YLM_POLYGON_VERTICES - 2) {
    size_t rest = n - from,
           sides = 1 + (rest < YLM_POLYGON_VERTICES - 1 ? rest : YLM_POLYGON_VERTICES - 1);
    double *to = s->record + s->numbers;
    for (int a = 0; a < 3; a++) to[a] = 0.5, to[3 + a] = 0;
    to[6] = (double)sides;
    memcpy(to + RECORD, c[0].at, 3 * sizeof *to);
    for (size_t k = 1; k < sides; k++)
      memcpy(to + RECORD + 3 * k, c[from + k - 1].at, 3 * sizeof *to);
    s->numbers += RECORD + 3 * sides;
  }
}

/* Planes and faces; YLM_EDOMAIN where a corner stands out of a plane. */
static ylm_status list_faces(const mesh *m, ylm__solid *s, corner *c, ylm_error *e) {
  double sign = volume6(m) < 0 ? -1 : 1;
  for (size_t t = 0; t < m->triangles; t++) {
    double plane[4], area = plane_of(m, t, sign, plane);
    s->area += area;
    if (area <= 1e-12 * m->size * m->size) continue; /* its neighbours have its plane */
    bool known = false;
    for (size_t k = 0; k < s->planes && !known; k++) {
      const double *p = s->plane + 4 * k;
      known = true;
      for (size_t i = 0; i < 3 && known; i++)
        known = fabs(above(p, m->at + 3 * m->index[3 * t + i])) <= FLAT * m->size;
      known = known && p[0] * plane[0] + p[1] * plane[1] + p[2] * plane[2] > 0;
    }
    if (known) continue;
    for (size_t i = 0; i < m->vertices; i++)
      if (above(plane, m->at + 3 * i) > FLAT * m->size)
        return ylm_fail(e, YLM_EDOMAIN,
                        "the body is not convex: a corner at (%.4g, %.4g, %.4g) stands out of a "
                        "face by %.2g: give rays",
                        m->at[3 * i], m->at[3 * i + 1], m->at[3 * i + 2],
                        above(plane, m->at + 3 * i));
    memcpy(s->plane + 4 * s->planes++, plane, sizeof plane);
    size_t n = list_corners(m, plane, c);
    if (n >= 3) add_face(c + m->vertices, n, s);
  }
  return YLM_OK;
}

static void measure(mesh *m, ylm__solid *s) {
  double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < 3 * m->vertices; i++) {
    lo[i % 3] = fmin(lo[i % 3], m->at[i]);
    hi[i % 3] = fmax(hi[i % 3], m->at[i]);
  }
  for (int a = 0; a < 3; a++) s->centre[a] = (lo[a] + hi[a]) / 2;
  for (size_t i = 0; i < 3 * m->vertices; i++) s->middle[i % 3] += m->at[i] / (double)m->vertices;
  for (size_t i = 0; i < m->vertices; i++)
    s->radius = fmax(s->radius, ylm__distance(s->centre, m->at + 3 * i));
  m->size = s->radius;
}

static ylm_status check(mesh *m, size_t open, ylm__solid *s, ylm_error *e) {
  if (open)
    return ylm_fail(e, YLM_EDOMAIN, "the mesh has %zu open edge%s: what is inside of it?", open,
                    open == 1 ? "" : "s");
  measure(m, s);
  if (!(fabs(volume6(m)) > 1e-9 * m->size * m->size * m->size))
    return ylm_fail(e, YLM_EDOMAIN, "the mesh is flat: nothing is inside of it");
  if (s->radius > YLM_LIGHT_EXTENT)
    return ylm_fail(e, YLM_ERANGE, "the mesh is too large (the limit is %g)", YLM_LIGHT_EXTENT);
  return YLM_OK;
}

/* The mesh without doubles, checked: it is closed and has a size. m is the caller's to free. */
static ylm_status read_mesh(size_t vertices, const float *position, size_t triangles,
                            const uint32_t *index, mesh *m, ylm__solid *s, ylm_error *e) {
  size_t where;
  memset(s, 0, sizeof *s);
  memset(m, 0, sizeof *m);
  if (!triangles) return ylm_fail(e, YLM_EDOMAIN, "the mesh has no triangles");
  for (size_t i = 0; i < 3 * triangles; i++)
    if (index[i] >= vertices)
      return ylm_fail(e, YLM_EDOMAIN, "the mesh has no vertex %u", index[i]);
  if (!ylm_all_finite(YLM_FLOAT, position, 3 * vertices, &where))
    return ylm_fail(e, YLM_EDOMAIN, "vertex %zu is not finite", where / 3 + 1);
  size_t open;
  ylm_status status = weld(vertices, position, triangles, index, m, &open);
  return status == YLM_OK ? check(m, open, s, e) : status;
}

ylm_status ylm__solid_create(size_t vertices, const float *position, size_t triangles,
                             const uint32_t *index, ylm__solid *s, ylm_error *e) {
  mesh m;
  memset(s, 0, sizeof *s);
  if (triangles > YLM_OCCLUDER_TRIANGLES)
    return ylm_fail(e, YLM_ERANGE,
                    "the mesh has %zu triangles, at most %d expected, since each point asks all "
                    "its faces: give rays",
                    triangles, YLM_OCCLUDER_TRIANGLES);
  ylm_status status = read_mesh(vertices, position, triangles, index, &m, s, e);
  if (status == YLM_OK) {
    corner *c = ylm_alloc(2 * m.vertices + 2, sizeof *c);
    s->plane = ylm_alloc(m.triangles, 4 * sizeof *s->plane);
    /* a face has at most two corners more than triangles, so all have at most thrice as many */
    s->record = ylm_alloc(m.triangles, (RECORD + 18) * sizeof *s->record);
    status = c && s->plane && s->record ? list_faces(&m, s, c, e) : YLM_ENOMEM;
    ylm_free(c);
  }
  ylm_free(m.at);
  ylm_free(m.index);
  if (status == YLM_OK) return status;
  ylm_free(s->plane);
  ylm_free(s->record);
  return status == YLM_ENOMEM ? ylm_no_memory(e) : status;
}

ylm_status ylm_light_body_measure(size_t vertices, const float *position, size_t triangles,
                                  const uint32_t *index, ylm_light_body *out, ylm_error *e) {
  mesh m;
  ylm__solid s;
  double plane[4];
  ylm_status status = read_mesh(vertices, position, triangles, index, &m, &s, e);
  if (status == YLM_OK) {
    *out = (ylm_light_body){.radius = s.radius, .volume = volume6(&m) / 6};
    memcpy(out->at, s.centre, sizeof out->at);
    for (size_t t = 0; t < m.triangles; t++) out->area += plane_of(&m, t, 1, plane);
  }
  ylm_free(m.at);
  ylm_free(m.index);
  return status == YLM_ENOMEM ? ylm_no_memory(e) : status;
}
