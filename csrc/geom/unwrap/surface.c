/* surface.c - the triangles of meshes as one surface: corners, normals, and the edges where two triangles join. */
#include <math.h>
#include <stdlib.h>

#include "unwrap.h"
#include "ylm_vector.h"

/* A half edge: the places of its ends, and the corner that it starts from. */
typedef struct half {
  uint32_t low, high, corner;
  bool up; /* from low to high */
} half;

static int by_ends(const void *a, const void *b) {
  const half *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  return p->corner < q->corner ? -1 : p->corner > q->corner;
}

/* Joins edges of exactly two triangles that pass them opposite ways; counts other edges of two or more. */
static size_t join(size_t n, const half *list, uint32_t *across) {
  size_t crowded = 0;
  for (size_t i = 0, end; i < n; i = end) {
    for (end = i + 1; end < n && list[end].low == list[i].low && list[end].high == list[i].high;)
      end++;
    if (end - i == 2 && list[i].up != list[i + 1].up) {
      across[list[i].corner] = list[i + 1].corner;
      across[list[i + 1].corner] = list[i].corner;
    } else
      crowded += end - i > 1;
  }
  return crowded;
}

/* Corners, normal and area of triangle t; false: it has no area. */
static bool measure(unwrap_surface *s, size_t t, const float *position, const uint32_t *index) {
  double a[3], b[3], n[3], longest = 0;
  for (size_t k = 0; k < 3; k++)
    for (size_t c = 0; c < 3; c++) s->point[t][k][c] = (double)position[3 * index[k] + c];
  for (size_t k = 0; k < 3; k++) {
    double square = 0;
    for (size_t c = 0; c < 3; c++) {
      double d = s->point[t][(k + 1) % 3][c] - s->point[t][k][c];
      square += d * d;
    }
    longest = fmax(longest, square);
  }
  for (size_t c = 0; c < 3; c++) {
    a[c] = s->point[t][1][c] - s->point[t][0][c];
    b[c] = s->point[t][2][c] - s->point[t][0][c];
  }
  ylm_cross3d(a, b, n);
  double twice = sqrt(ylm_dot3d(n, n));
  if (!(twice > 2 * DEGENERATE * longest) || !isfinite(twice) || !ylm_unit3(n)) return false;
  memcpy(s->normal[t], n, sizeof n);
  s->area[t] = twice / 2;
  s->whole += s->area[t];
  return true;
}

static ylm_status check_finite(size_t m, const ylm_unwrap_mesh *mesh, ylm_error *e) {
  size_t where;
  if (!mesh->vertices || ylm_all_finite(YLM_FLOAT, mesh->position, 3 * mesh->vertices, &where))
    return YLM_OK;
  return ylm_fail(e, YLM_EDOMAIN, "mesh %zu: vertex %zu is not finite", m + 1, where / 3 + 1);
}

/* The half edges of a mesh's triangles that have an area. */
static size_t halves(const ylm_unwrap_mesh *mesh, const double *area, const uint32_t *name,
                     half *list) {
  size_t n = 0;
  for (size_t i = 0; i < 3 * mesh->triangles; i++) {
    uint32_t a = name[mesh->index[i]], b = name[mesh->index[unwrap_next(i)]];
    if (!(area[i / 3] > 0) || a == b) continue;
    list[n++] = a < b ? (half){a, b, (uint32_t)i, true} : (half){b, a, (uint32_t)i, false};
  }
  return n;
}

/* One mesh, whose triangles follow `first` others. */
static ylm_status add_mesh(size_t m, const ylm_unwrap_mesh *mesh, size_t first, ylm_unwrap *u,
                           unwrap_surface *s, ylm_error *e) {
  ylm_status status = check_finite(m, mesh, e);
  if (status != YLM_OK || mesh->triangles == 0) return status;
  uint32_t *name = ylm_alloc(mesh->vertices, sizeof *name), *across = s->across + 3 * first;
  half *list = ylm_alloc(mesh->triangles, 3 * sizeof *list);
  size_t places;
  status = name && list ? ylm_mesh_weld(mesh->vertices, mesh->position, name, &places) : YLM_ENOMEM;
  if (status == YLM_OK) {
    for (size_t t = 0; t < mesh->triangles; t++)
      u->stats.degenerate += !measure(s, first + t, mesh->position, mesh->index + 3 * t);
    size_t n = halves(mesh, s->area + first, name, list);
    qsort(list, n, sizeof *list, by_ends);
    u->stats.crowded += join(n, list, across);
    for (size_t i = 0; i < 3 * mesh->triangles; i++)
      if (across[i] != UNWRAP_NONE) across[i] += (uint32_t)(3 * first);
  }
  ylm_free(name);
  ylm_free(list);
  return status;
}

ylm_status ylm__unwrap_surface(size_t meshes, const ylm_unwrap_mesh *mesh, ylm_unwrap *u,
                               unwrap_surface *s, ylm_error *e) {
  size_t n = u->triangles;
  s->triangles = n;
  s->of = u->of;
  s->point = ylm_alloc(n, sizeof *s->point);
  s->normal = ylm_alloc_zero(n, sizeof *s->normal);
  s->area = ylm_alloc_zero(n, sizeof *s->area);
  s->across = u->across;
  if (!s->point || !s->normal || !s->area) return ylm_no_memory(e);
  memset(s->across, 0xff, 3 * n * sizeof *s->across);
  ylm_status status = YLM_OK;
  for (size_t m = 0; status == YLM_OK && m < meshes; m++)
    status = add_mesh(m, &mesh[m], u->first[m], u, s, e);
  if (status == YLM_OK && u->stats.degenerate == n)
    return ylm_fail(e, YLM_EDOMAIN, "none of the %zu triangles has an area", n);
  return status;
}

void ylm__unwrap_surface_free(unwrap_surface *s) {
  ylm_free(s->point);
  ylm_free(s->normal);
  ylm_free(s->area);
}
