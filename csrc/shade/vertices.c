/* vertices.c - the vertices that are needed for what is in sight. */
#include <string.h>

#include "view.h"

/* Place of a vertex and side in the map of all of them. */
static size_t key(const ylm_shade_scene *s, uint32_t mesh, uint32_t vertex, bool back) {
  return 2 * (s->mesh[mesh].first_vertex + vertex) + back;
}

static const uint32_t *triangle(const ylm_shade_view *v, size_t entry) {
  const shade_entry *e = &v->entry[entry];
  return &v->scene->mesh[e->mesh].triangle[3 * (size_t)e->element];
}

/* Marks used vertices in `map` and numbers them in the order of meshes; returns their count. */
static size_t number_vertices(const ylm_shade_view *v, uint32_t *map) {
  size_t count = 0;
  for (size_t i = 0; i < v->entries; i++)
    for (int k = 0; k < 3; k++)
      map[key(v->scene, v->entry[i].mesh, triangle(v, i)[k], v->entry[i].back)] = 1;
  for (size_t i = 0; i < 2 * v->scene->vertices; i++)
    if (map[i]) map[i] = (uint32_t)++count;
  return count;
}

static void list_vertices(const ylm_shade_view *v, const uint32_t *map, shade_vertices *out) {
  for (uint32_t m = 0; m < v->scene->meshes; m++)
    for (uint32_t k = 0; k < v->scene->mesh[m].vertices; k++)
      for (int back = 0; back < 2; back++) {
        uint32_t number = map[key(v->scene, m, k, back)];
        if (!number) continue;
        out->mesh[number - 1] = m;
        out->vertex[number - 1] = k;
        out->back[number - 1] = back;
      }
}

ylm_status ylm__shade_vertices(const ylm_shade_view *v, shade_vertices *out) {
  memset(out, 0, sizeof *out);
  uint32_t *map = ylm_alloc_zero(2 * v->scene->vertices, sizeof *map);
  if (!map) return YLM_ENOMEM;
  size_t count = out->count = number_vertices(v, map);
  out->mesh = ylm_alloc(count, sizeof *out->mesh);
  out->vertex = ylm_alloc(count, sizeof *out->vertex);
  out->back = ylm_alloc(count, sizeof *out->back);
  out->corner = ylm_alloc(v->entries, sizeof *out->corner);
  bool ok = out->mesh && out->vertex && out->back && out->corner;
  if (ok) list_vertices(v, map, out);
  for (size_t i = 0; ok && i < v->entries; i++)
    for (int k = 0; k < 3; k++)
      out->corner[i][k] =
          map[key(v->scene, v->entry[i].mesh, triangle(v, i)[k], v->entry[i].back)] - 1;
  ylm_free(map);
  if (!ok) ylm__shade_vertices_free(out);
  return ok ? YLM_OK : YLM_ENOMEM;
}

void ylm__shade_vertices_free(shade_vertices *x) {
  ylm_free(x->mesh);
  ylm_free(x->vertex);
  ylm_free(x->back);
  ylm_free(x->corner);
  memset(x, 0, sizeof *x);
}
