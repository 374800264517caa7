/* sheets.c - sides of meshes that have light, their charts, and where places are looked up. */
#include "map.h"

/* Whether a side of mesh m has light: its first triangle with an element, or any side of a mesh that is only seen. */
static bool has_light(const ylm_transfer *t, size_t m, bool back) {
  for (size_t i = 0; i < ylm_scene_triangles(ylm_transfer_scene(t), m); i++) {
    ylm_scene_place p = {(uint32_t)m, (uint32_t)i, 0, 0, back};
    if (ylm__surface_is_lit(t, &p)) return true;
  }
  return false;
}

static ylm_status list_sheets(ylm_surface_map *m, const ylm_transfer *t) {
  size_t meshes = ylm_scene_meshes(m->scene);
  m->sheet = ylm_alloc(meshes, 2 * sizeof *m->sheet);
  m->of = ylm_alloc(meshes, 2 * sizeof *m->of);
  if (!m->sheet || !m->of) return YLM_ENOMEM;
  for (size_t i = 0; i < 2 * meshes; i++) {
    m->of[i] = MAP_NONE;
    if (!has_light(t, i / 2, i % 2)) continue;
    m->of[i] = (uint32_t)m->sheets;
    m->sheet[m->sheets++] = (map_sheet){(uint32_t)(i / 2), i % 2};
  }
  return YLM_OK;
}

/* Triangles of all sheets, one after the other, as their sides have them. */
static void copy_triangles(const ylm_surface_map *m, uint32_t *index) {
  for (size_t s = 0; s < m->sheets; s++) {
    const map_sheet *sheet = &m->sheet[s];
    for (size_t i = 0; i < ylm_scene_triangles(m->scene, sheet->mesh); i++, index += 3) {
      const uint32_t *t = ylm_scene_triangle(m->scene, sheet->mesh, i);
      for (int k = 0; k < 3; k++) index[k] = t[map_corner(sheet->back, k)];
    }
  }
}

ylm_status ylm__map_sheets(ylm_surface_map *m, const ylm_radiosity *r,
                           const ylm_surface_map_form *form, ylm_error *e) {
  ylm_status s = list_sheets(m, ylm_radiosity_transfer(r));
  if (s != YLM_OK) return s;
  size_t triangles = 0, n = 0;
  for (size_t i = 0; i < m->sheets; i++)
    triangles += ylm_scene_triangles(m->scene, m->sheet[i].mesh);
  float *position = ylm_alloc(ylm_scene_vertices(m->scene, NULL), 3 * sizeof *position);
  uint32_t *index = ylm_alloc(triangles, 3 * sizeof *index);
  ylm_unwrap_mesh *mesh = ylm_alloc(m->sheets, sizeof *mesh);
  s = position && index && mesh ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    ylm_scene_vertices(m->scene, position);
    copy_triangles(m, index);
    for (size_t i = 0; i < m->sheets; i++) {
      size_t of = m->sheet[i].mesh, first = ylm_scene_first_vertex(m->scene, of);
      mesh[i] =
          (ylm_unwrap_mesh){ylm_scene_first_vertex(m->scene, of + 1) - first,
                            ylm_scene_triangles(m->scene, of), position + 3 * first, index + 3 * n};
      n += mesh[i].triangles;
    }
    ylm_unwrap_form f = {form->angle, form->stretch, form->light.threads, form->light.progress};
    s = ylm_unwrap_create(m->sheets, mesh, &f, &m->charts, e);
  }
  ylm_free(position);
  ylm_free(index);
  ylm_free(mesh);
  return s;
}

/* -- look-ups ------------------------------------------------------------------------------------------ */

void ylm__map_tap_at(const ylm_surface_map *m, const double at[2], map_tap *tap) {
  const ylm_unwrap_stats *s = &m->stats.charts;
  double x = fmin(fmax(at[0] - 0.5, 0), (double)s->width - 1),
         y = fmin(fmax(at[1] - 0.5, 0), (double)s->height - 1);
  size_t i = (size_t)x, j = (size_t)y;
  double u = x - (double)i, v = y - (double)j;
  for (size_t k = 0; k < 4; k++) {
    size_t a = i + k % 2, b = j + k / 2;
    tap->weight[k] = (float)((k % 2 ? u : 1 - u) * (k / 2 ? v : 1 - v));
    if (tap->weight[k] < 2e-5f)
      tap->weight[k] = 0, a = i, b = j; /* no texel of this chart, maybe */
    tap->texel[k] = (uint32_t)(b * s->width + a);
  }
  if (tap->weight[0] == 0) /* nor is the first */
    for (int k = 1; k < 4; k++)
      if (tap->weight[k] > 0)
        for (int z = 0; z < 4; z++)
          if (tap->weight[z] == 0) tap->texel[z] = tap->texel[k];
}

bool ylm__map_tap(const ylm_surface_map *m, const ylm_scene_place *p, map_tap *tap) {
  uint32_t sheet = m->of[2 * p->mesh + p->back];
  double corner[3][2], at[2];
  if (sheet == MAP_NONE || ylm_unwrap_chart(m->charts, sheet, p->element) == YLM_UNWRAP_NONE)
    return false;
  ylm_unwrap_corners(m->charts, sheet, p->element, corner);
  const double *a = corner[0], *b = corner[map_corner(p->back, 1)],
               *c = corner[map_corner(p->back, 2)];
  for (int k = 0; k < 2; k++)
    at[k] = a[k] + (double)p->u * (b[k] - a[k]) + (double)p->v * (c[k] - a[k]);
  ylm__map_tap_at(m, at, tap);
  return true;
}
