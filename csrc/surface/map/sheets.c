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
  m->sheet = ylm_alloc_zero(meshes, 2 * sizeof *m->sheet);
  m->of = ylm_alloc(meshes, 2 * sizeof *m->of);
  if (!m->sheet || !m->of) return YLM_ENOMEM;
  for (size_t i = 0; i < 2 * meshes; i++) {
    m->of[i] = MAP_NONE;
    if (!has_light(t, i / 2, i % 2)) continue;
    size_t n = ylm_scene_triangles(m->scene, i / 2);
    map_sheet *s = &m->sheet[m->sheets];
    *s = (map_sheet){.mesh = (uint32_t)(i / 2), .back = i % 2, .triangles = n};
    m->of[i] = (uint32_t)m->sheets++;
    s->parts = ylm_alloc(n, 1);
    if (!s->parts) return YLM_ENOMEM;
    memset(s->parts, 1, n);
    if (ylm__map_count(s) != YLM_OK) return YLM_ENOMEM;
  }
  return YLM_OK;
}

/* Positions of vertices between those of a sheet's mesh. */
static void place(const ylm_surface_map *m, const map_sheet *s, size_t n, const uint32_t (*at)[3],
                  const float *old, float *position) {
  for (size_t i = 0; i < n; i++) {
    const uint32_t *t = ylm_scene_triangle(m->scene, s->mesh, at[i][0]);
    uint32_t cuts = s->parts[at[i][0]], part[3] = {cuts - at[i][1] - at[i][2], at[i][1], at[i][2]};
    for (size_t a = 0; a < 3; a++) {
      double sum = 0;
      for (int k = 0; k < 3; k++)
        if (part[k]) sum += (double)part[k] * (double)old[3 * t[map_corner(s->back, k)] + a];
      position[3 * i + a] = (float)(sum / cuts);
    }
  }
}

/* The mesh of a sheet's fine triangles; memory: to be freed. */
static ylm_status fine_mesh(const ylm_surface_map *m, const map_sheet *s, const float *all,
                            ylm_unwrap_mesh *out, float **memory, uint32_t **index) {
  size_t first = ylm_scene_first_vertex(m->scene, s->mesh);
  size_t old = ylm_scene_first_vertex(m->scene, s->mesh + 1) - first;
  size_t more = ylm__map_lattice(m, s, old, NULL, NULL);
  uint32_t(*at)[3] = ylm_alloc(more, sizeof *at);
  *memory = ylm_alloc(old + more, 3 * sizeof **memory);
  *index = ylm_alloc(s->fine, 3 * sizeof **index);
  ylm_status status = at && *memory && *index ? YLM_OK : YLM_ENOMEM;
  if (status == YLM_OK) {
    ylm__map_lattice(m, s, old, at, *index);
    memcpy(*memory, all + 3 * first, 3 * old * sizeof **memory);
    place(m, s, more, (const uint32_t(*)[3])at, *memory, *memory + 3 * old);
    *out = (ylm_unwrap_mesh){old + more, s->fine, *memory, *index};
  }
  ylm_free(at);
  return status;
}

ylm_status ylm__map_unwrap(ylm_surface_map *m, const ylm_surface_map_form *form,
                           const uint32_t *label, ylm_error *e) {
  float *all = ylm_alloc(ylm_scene_vertices(m->scene, NULL), 3 * sizeof *all);
  float **position = ylm_alloc_zero(m->sheets, sizeof *position);
  uint32_t **index = ylm_alloc_zero(m->sheets, sizeof *index);
  ylm_unwrap_mesh *mesh = ylm_alloc(m->sheets, sizeof *mesh);
  ylm_unwrap *charts = NULL;
  ylm_status s = all && position && index && mesh ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) ylm_scene_vertices(m->scene, all);
  for (size_t i = 0; s == YLM_OK && i < m->sheets; i++)
    s = fine_mesh(m, &m->sheet[i], all, &mesh[i], &position[i], &index[i]);
  ylm_unwrap_form f = {form->angle, form->stretch, label, form->light.threads,
                       form->light.progress};
  if (s == YLM_OK) s = ylm_unwrap_create(m->sheets, mesh, &f, &charts, e);
  if (s == YLM_OK) {
    ylm_unwrap_free(m->charts);
    m->charts = charts;
  }
  for (size_t i = 0; i < m->sheets; i++) {
    if (position) ylm_free(position[i]);
    if (index) ylm_free(index[i]);
  }
  ylm_free(all), ylm_free(position), ylm_free(index), ylm_free(mesh);
  return s;
}

ylm_status ylm__map_sheets(ylm_surface_map *m, const ylm_radiosity *r,
                           const ylm_surface_map_form *form, ylm_error *e) {
  ylm_status s = list_sheets(m, ylm_radiosity_transfer(r));
  return s == YLM_OK ? ylm__map_unwrap(m, form, NULL, e) : s;
}

/* -- look-ups ------------------------------------------------------------------------------------------ */

void ylm__map_tap_at(const ylm_surface_map *m, const double at[2], map_tap *tap) {
  ylm__map_tap_of(m->stats.charts.width, m->stats.charts.height, at, tap);
}

void ylm__map_tap_of(size_t width, size_t height, const double at[2], map_tap *tap) {
  double x = fmin(fmax(at[0] - 0.5, 0), (double)width - 1),
         y = fmin(fmax(at[1] - 0.5, 0), (double)height - 1);
  size_t i = (size_t)x, j = (size_t)y;
  double u = x - (double)i, v = y - (double)j;
  for (size_t k = 0; k < 4; k++) {
    size_t a = i + k % 2, b = j + k / 2;
    tap->weight[k] = (float)((k % 2 ? u : 1 - u) * (k / 2 ? v : 1 - v));
    if (tap->weight[k] < 2e-5f)
      tap->weight[k] = 0, a = i, b = j; /* no texel of this chart, maybe */
    tap->texel[k] = (uint32_t)(b * width + a);
  }
  if (tap->weight[0] == 0) /* nor is the first */
    for (int k = 1; k < 4; k++)
      if (tap->weight[k] > 0)
        for (int z = 0; z < 4; z++)
          if (tap->weight[z] == 0) tap->texel[z] = tap->texel[k];
}

bool ylm__map_tap(const ylm_surface_map *m, const ylm_scene_place *p, map_tap *tap) {
  uint32_t sheet = m->of[2 * p->mesh + p->back];
  double corner[3][2], at[2], u = (double)(p->back ? p->v : p->u),
                              v = (double)(p->back ? p->u : p->v);
  if (sheet == MAP_NONE) return false;
  size_t fine = ylm__map_fine(&m->sheet[sheet], p->element, &u, &v);
  if (ylm_unwrap_chart(m->charts, sheet, fine) == YLM_UNWRAP_NONE) return false;
  ylm_unwrap_corners(m->charts, sheet, fine, corner);
  const double *a = corner[0], *b = corner[1], *c = corner[2];
  for (int k = 0; k < 2; k++) at[k] = a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]);
  ylm__map_tap_at(m, at, tap);
  return true;
}

uint32_t ylm__map_chart(const ylm_surface_map *m, const ylm_scene_place *p) {
  uint32_t sheet = m->of[2 * p->mesh + p->back];
  double u = (double)(p->back ? p->v : p->u), v = (double)(p->back ? p->u : p->v);
  if (sheet == MAP_NONE) return YLM_UNWRAP_NONE;
  return ylm_unwrap_chart(m->charts, sheet, ylm__map_fine(&m->sheet[sheet], p->element, &u, &v));
}
