/* surface.c - triangles as surfaces: their area within a box, random points on it. */
#include "surface.h"
#include "ylm_math.h"

#include <string.h>

struct ylm_grid_surface {
  triangle_list list;
  double lo[3], size, box[3]; /* the bounds' corner, longest edge, edges as parts of that */
  double *sum;                /* [triangles] areas up to each and with it, in units of size^2 */
  bool flat;                  /* there is no area: all triangles that are within count alike */
  ylm_grid_mesh *own;         /* copies; NULL: the meshes are the caller's */
  size_t own_bytes;
};

/* -- lists of triangles ------------------------------------------------------------------ */

ylm_status ylm__triangle_list_make(triangle_list *l, size_t meshes, const ylm_grid_mesh *mesh) {
  *l = (triangle_list){.meshes = meshes, .mesh = mesh};
  l->first = ylm_alloc(meshes + 1, sizeof *l->first);
  if (!l->first) return YLM_ENOMEM;
  for (size_t i = 0; i < meshes; i++) {
    l->first[i] = l->triangles;
    l->triangles += mesh[i].triangles;
  }
  l->first[meshes] = l->triangles;
  return YLM_OK;
}

void ylm__triangle_list_free(triangle_list *l) {
  ylm_free(l->first);
  *l = (triangle_list){0};
}

/* The mesh that has triangle i. */
static size_t mesh_of(const triangle_list *l, size_t i) {
  size_t lo = 0, hi = l->meshes;
  while (hi - lo > 1) {
    size_t mid = lo + (hi - lo) / 2;
    if (l->first[mid] <= i)
      lo = mid;
    else
      hi = mid;
  }
  return lo;
}

void ylm__triangle_list_get(const triangle_list *l, size_t i, double p[3][3]) {
  size_t k = mesh_of(l, i);
  const ylm_grid_mesh *m = &l->mesh[k];
  const uint32_t *corner = m->index + 3 * (i - l->first[k]);
  for (int c = 0; c < 3; c++)
    for (int a = 0; a < 3; a++)
      p[c][a] = ylm_get(m->dtype, m->position, 3 * (size_t)corner[c] + (size_t)a);
}

static ylm_status check_mesh(size_t number, const ylm_grid_mesh *m, ylm_error *e) {
  size_t bad;
  if (m->triangles > UINT32_MAX)
    return ylm_fail(e, YLM_EOVERFLOW, "surfaces: mesh %zu has too many triangles", number);
  if (m->triangles && (!m->position || !m->index))
    return ylm_fail(e, YLM_EINVAL, "surfaces: mesh %zu has no positions or indices", number);
  for (size_t i = 0; i < 3 * m->triangles; i++)
    if (m->index[i] >= m->vertices)
      return ylm_fail(e, YLM_ERANGE, "surfaces: triangle %zu of mesh %zu has a corner %u of %zu",
                      i / 3 + 1, number, m->index[i], m->vertices);
  if (m->triangles && !ylm_all_finite(m->dtype, m->position, 3 * m->vertices, &bad))
    return ylm_fail(e, YLM_EDOMAIN, "surfaces: vertex %zu of mesh %zu is not finite", bad / 3 + 1,
                    number);
  return YLM_OK;
}

ylm_status ylm__grid_check_meshes(size_t meshes, const ylm_grid_mesh *mesh, ylm_error *e) {
  size_t triangles = 0;
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < meshes && s == YLM_OK; i++) {
    s = check_mesh(i + 1, &mesh[i], e);
    triangles += mesh[i].triangles;
  }
  if (s != YLM_OK || triangles) return s;
  return ylm_fail(e, YLM_EINVAL, "surfaces: no triangles");
}

/* -- the part of a triangle within the box ------------------------------------------------ */

#define CORNERS 9 /* of a triangle cut by six planes, at most */

typedef struct polygon {
  int n;
  double p[CORNERS][3];
} polygon;

/* Cuts off what is beyond a plane: above `at` along an axis, or below (side -1). */
static void cut(polygon *q, int axis, double side, double at) {
  polygon old = *q;
  q->n = 0;
  for (int i = 0; i < old.n; i++) {
    const double *p = old.p[i], *next = old.p[(i + 1) % old.n];
    double here = side * (at - p[axis]), there = side * (at - next[axis]);
    if (here >= 0 && q->n < CORNERS) memcpy(q->p[q->n++], p, sizeof q->p[0]);
    if ((here >= 0) == (there >= 0) || q->n == CORNERS) continue;
    double t = here / (here - there), *cross = q->p[q->n++];
    for (int a = 0; a < 3; a++) cross[a] = p[a] + t * (next[a] - p[a]);
    cross[axis] = at;
  }
}

/* The part of triangle i within the box, whose lowest corner is 0 and whose longest edge 1. */
static void part_within(const ylm_grid_surface *s, size_t i, polygon *q) {
  double p[3][3];
  bool within = true;
  ylm__triangle_list_get(&s->list, i, p);
  q->n = 3;
  for (int c = 0; c < 3; c++)
    for (int a = 0; a < 3; a++) {
      q->p[c][a] = (p[c][a] - s->lo[a]) / s->size;
      within &= q->p[c][a] >= 0 && q->p[c][a] <= s->box[a];
    }
  for (int a = 0; a < 3 && !within; a++) {
    cut(q, a, 1, s->box[a]);
    cut(q, a, -1, 0);
  }
  for (; q->n == 1 || q->n == 2; q->n++) memcpy(q->p[q->n], q->p[0], sizeof q->p[0]);
}

static void cross_of(const double *o, const double *p, const double *q, double out[3]) {
  for (int a = 0; a < 3; a++) {
    int b = (a + 1) % 3, c = (a + 2) % 3;
    out[a] = (p[b] - o[b]) * (q[c] - o[c]) - (p[c] - o[c]) * (q[b] - o[b]);
  }
}

static double area_of(const double *o, const double *p, const double *q) {
  double n[3];
  cross_of(o, p, q, n);
  return 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

/* Of the fan of triangles about its first corner, up to corner k. */
static double fan_area(const polygon *q, int k) {
  double sum = 0;
  for (int i = 2; i <= k; i++) sum += area_of(q->p[0], q->p[i - 1], q->p[i]);
  return sum;
}

/* -- areas ---------------------------------------------------------------------------------- */

static ylm_status find_areas(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  ylm_grid_surface *s = context;
  polygon q;
  for (size_t i = begin; i < end; i++) {
    part_within(s, i, &q);
    double area = s->flat ? (double)(q.n > 0) : fan_area(&q, q.n - 1);
    s->sum[i] = isfinite(area) ? area : 0;
  }
  return YLM_OK;
}

/* Their sums, each with those before it. */
static double sum_areas(ylm_grid_surface *s, int threads) {
  double sum = 0;
  ylm_parallel(s->list.triangles, SURFACE_GRAIN, threads, find_areas, s, NULL, NULL);
  for (size_t i = 0; i < s->list.triangles; i++) s->sum[i] = sum += s->sum[i];
  return sum;
}

static ylm_status measure(ylm_grid_surface *s, int threads, ylm_error *e) {
  ylm_status status = ylm__triangle_list_make(&s->list, s->list.meshes, s->list.mesh);
  if (status == YLM_OK) s->sum = ylm_alloc(s->list.triangles, sizeof *s->sum);
  if (!s->sum) return ylm_no_memory(e);
  if (sum_areas(s, threads) > 0) return YLM_OK;
  s->flat = true;
  if (sum_areas(s, threads) > 0) return YLM_OK;
  return ylm_fail(e, YLM_EDOMAIN, "surfaces: no triangle lies within the bounds");
}

ylm_status ylm_grid_surface_create(size_t meshes, const ylm_grid_mesh *mesh, const double bounds[6],
                                   int threads, ylm_grid_surface **out, ylm_error *e) {
  *out = NULL;
  ylm_status status = ylm__grid_check_meshes(meshes, mesh, e);
  if (status != YLM_OK) return status;
  ylm_grid_surface *s = ylm_alloc_zero(1, sizeof *s);
  if (!s) return ylm_no_memory(e);
  s->list.meshes = meshes;
  s->list.mesh = mesh;
  for (int a = 0; a < 3; a++) s->size = fmax(s->size, bounds[a + 3] - bounds[a]);
  for (int a = 0; a < 3; a++) {
    s->lo[a] = bounds[a];
    s->box[a] = (bounds[a + 3] - bounds[a]) / s->size;
  }
  status = measure(s, threads, e);
  if (status == YLM_OK)
    *out = s;
  else
    ylm_grid_surface_free(s);
  return status;
}

void ylm_grid_surface_free(ylm_grid_surface *s) {
  if (!s) return;
  for (size_t i = 0; s->own && i < s->list.meshes; i++) {
    ylm_free((void *)(uintptr_t)s->own[i].position);
    ylm_free((void *)(uintptr_t)s->own[i].index);
  }
  ylm_free(s->own);
  ylm__triangle_list_free(&s->list);
  ylm_free(s->sum);
  ylm_free(s);
}

double ylm_grid_surface_area(const ylm_grid_surface *s) {
  return s->flat ? 0 : s->sum[s->list.triangles - 1] * s->size * s->size;
}

/* -- copies ----------------------------------------------------------------------------------- */

ylm_status ylm__surface_keep(ylm_grid_surface *s) {
  s->own = ylm_alloc_zero(s->list.meshes, sizeof *s->own);
  if (!s->own) return YLM_ENOMEM;
  for (size_t i = 0; i < s->list.meshes; i++) {
    const ylm_grid_mesh *m = &s->list.mesh[i];
    size_t row = 3 * ylm_dtype_size(m->dtype);
    s->own[i] = *m;
    s->own[i].position = ylm_alloc_copy(m->position, m->vertices, row);
    s->own[i].index = ylm_alloc_copy(m->index, m->triangles, 3 * sizeof *m->index);
    if (!s->own[i].position || !s->own[i].index) return YLM_ENOMEM;
    s->own_bytes += m->vertices * row + m->triangles * 3 * sizeof *m->index + sizeof *m;
  }
  s->list.mesh = s->own;
  return YLM_OK;
}

const ylm_grid_mesh *ylm__surface_meshes(const ylm_grid_surface *s) { return s->list.mesh; }

size_t ylm__surface_bytes(const ylm_grid_surface *s) {
  if (!s) return 0;
  return sizeof *s + s->own_bytes + s->list.triangles * sizeof *s->sum +
         (s->list.meshes + 1) * sizeof *s->list.first;
}

/* -- random points ---------------------------------------------------------------------------- */

/* Number j of draw k of a seed, in [0, 1). */
static double uniform(uint64_t seed, uint64_t k, uint64_t j) {
  const uint64_t step = 0x9e3779b97f4a7c15u;
  return (double)(ylm_mix64(ylm_mix64(ylm_mix64(seed + step) + k * step) + (j + 1) * step) >> 11) *
         0x1p-53;
}

/* A point of a polygon, uniform in f and g: f chooses a triangle of its fan and a distance from the
   corner that they share. */
static void point_of(const polygon *q, double f, double g, double out[3]) {
  double all = fan_area(q, q->n - 1), at = f * all;
  int k = 2, last = q->n - 1;
  while (k < last && fan_area(q, k) <= at) k++;
  double before = fan_area(q, k - 1), own = fan_area(q, k) - before;
  double t = own > 0 ? fmin(fmax((at - before) / own, 0), 1) : f;
  const double *o = q->p[0], *p = q->p[k - 1], *r = q->p[k];
  t = sqrt(t);
  for (int a = 0; a < 3; a++) out[a] = o[a] + t * ((1 - g) * (p[a] - o[a]) + g * (r[a] - o[a]));
}

/* A point of triangle i, uniform in f and g; false where nothing of it is within the bounds. */
static bool place(const ylm_grid_surface *s, size_t i, double f, double g, double position[3]) {
  polygon q;
  part_within(s, i, &q);
  if (!q.n) return false;
  point_of(&q, f, g, position);
  for (int a = 0; a < 3; a++) position[a] = s->lo[a] + s->size * position[a];
  return true;
}

static void normal_of(const ylm_grid_surface *s, size_t i, double normal[3]) {
  double p[3][3], largest = 0, length;
  ylm__triangle_list_get(&s->list, i, p);
  for (int c = 0; c < 3; c++)
    for (int a = 0; a < 3; a++) largest = fmax(largest, fabs(p[c][a] - p[0][a]));
  for (int c = 2; c >= 0; c--)
    for (int a = 0; a < 3; a++) p[c][a] = largest > 0 ? (p[c][a] - p[0][a]) / largest : 0;
  cross_of(p[0], p[1], p[2], normal);
  length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  for (int a = 0; a < 3; a++) normal[a] = length > 0 ? normal[a] / length : a == 2;
}

void ylm_grid_surface_draw(const ylm_grid_surface *s, uint64_t seed, uint64_t k, uint64_t strata,
                           double position[3], double normal[3]) {
  double u = uniform(seed, k, 0), all = s->sum[s->list.triangles - 1];
  if (strata > 1) u = ((double)(k % strata) + u) / (double)strata;
  size_t i = ylm_interval_at(s->list.triangles, s->sum, u * all);
  double before = i ? s->sum[i - 1] : 0, own = s->sum[i] - before;
  double f = own > 0 ? (u * all - before) / own : 0;
  place(s, i, f < 0 ? 0 : f > 1 ? 1 : f, uniform(seed, k, 1), position);
  normal_of(s, i, normal);
}

bool ylm__surface_draw_alike(const ylm_grid_surface *s, uint64_t seed, uint64_t k,
                             double position[3], double normal[3]) {
  size_t n = s->list.triangles, i = (size_t)(uniform(seed, k, 0) * (double)n);
  normal_of(s, i, normal);
  return place(s, i, uniform(seed, k, 1), uniform(seed, k, 2), position);
}
