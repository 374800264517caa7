/*
** fine.c - triangles of sheets cut into n^2 alike, so that charts can end within them.
**
** Rows run along the first edge, the longest first: cell i of row j has a triangle as its whole has it, and, but for the last,
** one that is turned by half a turn.
*/
#include "map.h"

ylm_status ylm__map_count(map_sheet *s) {
  ylm_free(s->first), ylm_free(s->of);
  s->of = NULL;
  s->first = ylm_alloc(s->triangles + 1, sizeof *s->first);
  if (!s->first) return YLM_ENOMEM;
  s->first[0] = 0;
  for (size_t t = 0; t < s->triangles; t++)
    s->first[t + 1] = s->first[t] + (uint32_t)s->parts[t] * s->parts[t];
  s->fine = s->first[s->triangles];
  s->of = ylm_alloc(s->fine, sizeof *s->of);
  if (!s->of) return YLM_ENOMEM;
  for (size_t t = 0; t < s->triangles; t++)
    for (uint32_t i = s->first[t]; i < s->first[t + 1]; i++) s->of[i] = (uint32_t)t;
  return YLM_OK;
}

size_t ylm__map_fine(const map_sheet *s, size_t triangle, double *u, double *v) {
  int n = s->parts[triangle];
  if (n == 1) return s->first[triangle];
  int j = (int)fmin(fmax(n * *v, 0), n - 1), i = (int)fmin(fmax(n * *u, 0), n - 1 - j);
  *u = n * *u - i;
  *v = n * *v - j;
  bool turned = *u + *v > 1 && i + j < n - 1;
  if (turned) {
    *u = 1 - *u;
    *v = 1 - *v;
  }
  return s->first[triangle] + (size_t)(n * n - (n - j) * (n - j) + 2 * i + turned);
}

size_t ylm__map_whole(const map_sheet *s, size_t fine, double *u, double *v) {
  size_t triangle = s->of[fine];
  int n = s->parts[triangle], k = (int)(fine - s->first[triangle]), j = 0;
  while (n * n - (n - j - 1) * (n - j - 1) <= k) j++;
  k -= n * n - (n - j) * (n - j);
  *u = (k / 2 + (k % 2 ? 1 - *u : *u)) / n;
  *v = (j + (k % 2 ? 1 - *v : *v)) / n;
  return triangle;
}

/* Fine triangles of one whose lattice begins with vertex `base`. */
static void add_fine(int n, uint32_t base, uint32_t *index) {
  for (int j = 0; j < n; j++) {
    uint32_t row = base + (uint32_t)(j * (n + 1) - j * (j - 1) / 2);
    uint32_t next = row + (uint32_t)(n + 1 - j);
    for (uint32_t i = 0; i < (uint32_t)(n - j); i++) {
      *index++ = row + i, *index++ = row + i + 1, *index++ = next + i;
      if (i + 1 < (uint32_t)(n - j))
        *index++ = next + i + 1, *index++ = next + i, *index++ = row + i + 1;
    }
  }
}

size_t ylm__map_lattice(const ylm_surface_map *m, const map_sheet *s, size_t vertices,
                        uint32_t (*at)[3], uint32_t *index) {
  size_t more = 0;
  for (size_t t = 0; t < s->triangles; t++) {
    int n = s->parts[t];
    uint32_t *to = index ? index + 3 * (size_t)s->first[t] : NULL;
    if (n == 1) {
      const uint32_t *of = ylm_scene_triangle(m->scene, s->mesh, t);
      for (int k = 0; to && k < 3; k++) to[k] = of[map_corner(s->back, k)];
      continue;
    }
    if (to) add_fine(n, (uint32_t)(vertices + more), to);
    for (int j = 0; j <= n; j++)
      for (int i = 0; i <= n - j; i++, more++)
        if (at) at[more][0] = (uint32_t)t, at[more][1] = (uint32_t)i, at[more][2] = (uint32_t)j;
  }
  return more;
}

/* How the vertices of a sheet's fine triangles mix those of its mesh: from [n] vertices of the mesh, and of the lattices. */
static ylm_status find_mix(const ylm_surface_map *m, const map_sheet *s, size_t old,
                           const uint32_t *from, map_split *split) {
  uint32_t(*at)[3] = ylm_alloc(ylm__map_lattice(m, s, old, NULL, NULL), sizeof *at);
  split->mix = ylm_alloc(split->vertices, sizeof *split->mix);
  ylm_status status = at && split->mix ? YLM_OK : YLM_ENOMEM;
  if (status == YLM_OK) ylm__map_lattice(m, s, old, at, NULL);
  for (size_t i = 0; status == YLM_OK && i < split->vertices; i++) {
    ylm_mesh_mix *mix = &split->mix[i];
    *mix = (ylm_mesh_mix){{from[i], 0, 0}, {1, 0, 0}};
    if (from[i] < old) continue;
    const uint32_t *a = at[from[i] - old], *t = ylm_scene_triangle(m->scene, s->mesh, a[0]);
    for (int k = 0; k < 3; k++) mix->of[k] = t[map_corner(s->back, k)];
    mix->part[0] = s->parts[a[0]] - a[1] - a[2];
    mix->part[1] = a[1];
    mix->part[2] = a[2];
  }
  ylm_free(at);
  return status;
}

ylm_status ylm_surface_map_split(const ylm_surface_map *m, size_t sheet, const ylm_mesh *mesh,
                                 ylm_mesh **out, float **uv, ylm_error *e) {
  const map_sheet *s = &m->sheet[sheet];
  map_split x = {.triangles = s->fine};
  uint32_t *from = NULL;
  *uv = NULL;
  ylm_status status = ylm_unwrap_split(m->charts, sheet, &x.vertices, &from, &x.uv, &x.index, e);
  if (status != YLM_OK) return status;
  status = find_mix(m, s, mesh->vertices, from, &x);
  if (status == YLM_OK) status = ylm__map_merge(m, sheet, mesh, &x);
  if (status == YLM_ENOMEM) ylm_no_memory(e);
  if (status == YLM_OK)
    status = ylm_mesh_blend(mesh, x.vertices, x.mix, x.triangles, x.index, s->back, out, e);
  ylm_free(x.mix), ylm_free(from), ylm_free(x.index);
  if (status == YLM_OK)
    *uv = x.uv;
  else
    ylm_free(x.uv);
  return status;
}
