/* tint.c - what shading points reflect: materials, textures and colours. */
#include <string.h>

#include "../view.h"

void ylm__shade_tint(const ylm_shade_view *v, size_t first, size_t n, float *radiance) {
  if (!v->tint) return;
  for (size_t i = 0; i < n; i++)
    for (size_t c = 0; c < 3; c++) radiance[3 * i + c] *= v->tint[first + i][c];
}

void ylm__shade_albedo(const ylm_shade_view *v, size_t point, float albedo[3]) {
  ylm_material_albedo(ylm__shade_material(v, point), albedo);
  ylm__shade_tint(v, point, 1, albedo);
}

void ylm__shade_seen_albedo(const ylm_shade_view *v, size_t i, float albedo[3]) {
  ylm_material_albedo(ylm__shade_mesh_material(v, v->entry[i].at.mesh), albedo);
  for (int c = 0; v->seen && c < 3; c++) albedo[c] *= v->seen[i][c];
}

ylm_status ylm__shade_make_tints(ylm_shade_view *v) {
  if (!v->seen) return YLM_OK;
  v->tint = v->o.per_vertex ? ylm_alloc(v->points, sizeof *v->tint) : v->seen;
  return v->tint ? YLM_OK : YLM_ENOMEM;
}

void ylm__shade_free_tints(ylm_shade_view *v) {
  if (v->tint != v->seen) ylm_free(v->tint);
  ylm_free(v->seen);
}

void ylm_shade_view_surface(const ylm_shade_view *v, float *albedo, float *object) {
  for (size_t i = 0; i < v->points; i++) {
    if (albedo) ylm__shade_albedo(v, i, albedo + 3 * i);
    if (object) object[i] = (float)v->mesh[i];
  }
}

ylm_status ylm_shade_view_materials(const ylm_shade_view *v, float *row, ylm_error *e) {
  ylm_status s = YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < v->points; i++, row += YLM_MATERIAL_ROW) {
    const ylm_material *m = ylm__shade_material(v, i);
    s = ylm_material_row(m, row, e);
    if (s == YLM_EMISSING)
      s = ylm_fail(e, s, "a device shades matte surfaces only: mesh %u is %s", v->mesh[i] + 1,
                   ylm_material_kind_name(ylm_material_kind(m)));
    if (s == YLM_OK && v->tint) ylm_material_row_tint(row, v->tint[i]);
  }
  return s;
}
