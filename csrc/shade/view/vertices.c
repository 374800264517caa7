/* vertices.c - the vertices that are needed for what is in sight. */
#include <string.h>

#include "../view.h"

/* Rays that pass between triangles of a closed mesh meet it from within: of more than one in so many the
   vertices of the other side are wanted. */
#define CRACKS 1000

/* Place of corner k of an entry's triangle, and of the side that is seen, in the map of all
   vertices from both sides. */
static size_t place_of(const ylm_shade_view *v, size_t entry, int k) {
  const ylm_scene_place *at = &v->entry[entry].at;
  size_t first = ylm_scene_first_vertex(v->scene, at->mesh);
  return 2 * (first + ylm_scene_triangle(v->scene, at->mesh, at->element)[k]) + at->back;
}

/* Marks all vertices from outside, and from within those of meshes that are seen so. */
static void mark_all(const ylm_shade_view *v, uint32_t *map) {
  size_t meshes = ylm_scene_meshes(v->scene);
  for (size_t i = 0; i < 2 * ylm_scene_vertices(v->scene, NULL); i += 2) map[i] = 1;
  for (size_t i = 0; i < v->entries; i++) {
    const ylm_scene_place *at = &v->entry[i].at;
    if (at->back) map[2 * ylm_scene_first_vertex(v->scene, at->mesh) + 1] = 1;
  }
  for (size_t m = 0; m < meshes; m++) {
    size_t first = ylm_scene_first_vertex(v->scene, m);
    for (size_t i = first; i < ylm_scene_first_vertex(v->scene, m + 1); i++)
      map[2 * i + 1] = map[2 * first + 1];
  }
}

/* Marks used vertices in `map` and numbers them in the order of meshes; returns their count. */
static size_t number_vertices(const ylm_shade_view *v, uint32_t *map) {
  size_t count = 0, vertices = ylm_scene_vertices(v->scene, NULL);
  if (v->o.all_vertices)
    mark_all(v, map);
  else
    for (size_t i = 0; i < v->entries; i++)
      for (int k = 0; k < 3; k++) map[place_of(v, i, k)] = 1;
  for (size_t i = 0; i < 2 * vertices; i++)
    if (map[i]) map[i] = (uint32_t)++count;
  return count;
}

static void list_vertices(const ylm_shade_view *v, const uint32_t *map, shade_vertices *out) {
  size_t meshes = ylm_scene_meshes(v->scene);
  for (size_t m = 0; m < meshes; m++) {
    size_t first = ylm_scene_first_vertex(v->scene, m);
    size_t behind = ylm_scene_first_vertex(v->scene, m + 1);
    for (size_t i = 2 * first; i < 2 * behind; i++) {
      if (!map[i]) continue;
      out->mesh[map[i] - 1] = (uint32_t)m;
      out->vertex[map[i] - 1] = (uint32_t)(i / 2 - first);
      out->back[map[i] - 1] = i % 2;
    }
  }
}

ylm_status ylm__shade_vertices(const ylm_shade_view *v, shade_vertices *out) {
  memset(out, 0, sizeof *out);
  uint32_t *map = ylm_alloc_zero(2 * ylm_scene_vertices(v->scene, NULL), sizeof *map);
  if (!map) return YLM_ENOMEM;
  size_t count = out->count = number_vertices(v, map);
  out->mesh = ylm_alloc(count, sizeof *out->mesh);
  out->vertex = ylm_alloc(count, sizeof *out->vertex);
  out->back = ylm_alloc(count, sizeof *out->back);
  out->corner = ylm_alloc(v->entries, sizeof *out->corner);
  bool ok = out->mesh && out->vertex && out->back && out->corner;
  if (ok) list_vertices(v, map, out);
  for (size_t i = 0; ok && i < v->entries; i++)
    for (int k = 0; k < 3; k++) out->corner[i][k] = map[place_of(v, i, k)] - 1;
  for (size_t i = 0; i < 2 * ylm_scene_vertices(v->scene, NULL); i++) map[i]--; /* 0: nowhere */
  out->place = map;
  if (!ok) ylm__shade_vertices_free(out);
  return ok ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm__shade_corners(ylm_shade_view *v, ylm_error *e) {
  size_t within = 0, mesh = 0;
  v->corner = ylm_alloc(v->entries, sizeof *v->corner);
  if (!v->corner) return YLM_ENOMEM;
  for (size_t i = 0; i < v->entries; i++)
    for (int k = 0; k < 3; k++) {
      size_t at = place_of(v, i, k);
      v->corner[i][k] = v->vertex[at];
      if (v->vertex[at] != YLM_SHADE_NOWHERE) continue;
      v->corner[i][k] = v->vertex[at ^ 1];
      mesh = v->entry[i].at.mesh;
      within += k == 0;
    }
  if (within <= v->entries / CRACKS) return YLM_OK;
  return ylm_fail(e, YLM_EINVAL,
                  "the camera sees mesh %zu from within, where the prepared view has no vertices: "
                  "prepare it with a camera that sees this side too",
                  mesh + 1);
}

void ylm__shade_vertices_free(shade_vertices *x) {
  ylm_free(x->mesh);
  ylm_free(x->vertex);
  ylm_free(x->back);
  ylm_free(x->corner);
  ylm_free(x->place);
  memset(x, 0, sizeof *x);
}
