/* relight.c - views of the same shading points with other materials, or another camera. */
#include "../gloss/gloss.h"

void ylm__shade_change_free(ylm_shade_view *v) {
  if (v->looks_again) {
    ylm_free(v->entry);
    ylm_free(v->pixel);
    ylm_free(v->corner);
    ylm_free(v->seen);
  }
  for (size_t i = 0; v->material && i < ylm_scene_meshes(v->scene); i++)
    ylm_material_free(v->material[i]);
  ylm_free(v->material);
  ylm__shade_gloss_free(v->gloss);
  ylm_free(v);
}

/* The image of another camera. */
static ylm_status look_again(ylm_shade_view *v, const ylm_shade_change *c, ylm_error *e) {
  ylm_camera_frame frame;
  if (!v->vertex)
    return ylm_fail(e, YLM_EINVAL,
                    "shading points of the prepared view are those of its camera: another one "
                    "needs all vertices");
  ylm_status s = ylm_scene_frame(v->scene, c->camera, v->o.width, v->o.height, &frame, e);
  if (s != YLM_OK) return s;
  v->frame = frame;
  v->looks_again = true;
  v->entry = NULL;
  v->pixel = NULL;
  v->corner = NULL;
  v->seen = NULL;
  v->entries = v->stats.pixels = 0;
  if (c->blind) return YLM_OK;
  s = ylm__shade_primary(v, &frame);
  v->stats.bytes += v->entries * (sizeof(shade_entry) + 12 + (v->seen ? 12 : 0)) +
                    (v->stats.pixels + 1) * sizeof(shade_pixel);
  return s == YLM_OK ? ylm__shade_corners(v, e) : s;
}

/* Keeps the materials of all meshes. */
static ylm_status dress(ylm_shade_view *v, const ylm_material *const *materials) {
  size_t meshes = ylm_scene_meshes(v->scene);
  const ylm_material **all = ylm_alloc(meshes, sizeof *all);
  if (!all) return YLM_ENOMEM;
  for (size_t i = 0; i < meshes; i++)
    all[i] = ylm_material_keep(materials && materials[i] ? materials[i]
                                                         : ylm__shade_mesh_material(v->base, i));
  v->material = all;
  return YLM_OK;
}

ylm_status ylm_shade_view_change(const ylm_shade_view *from, const ylm_shade_change *c, int threads,
                                 const ylm_progress *progress, ylm_shade_view **view,
                                 ylm_error *e) {
  const shade_tables *tables;
  *view = NULL;
  ylm_shade_view *v = ylm_alloc(1, sizeof *v);
  if (!v) return YLM_ENOMEM;
  *v = *from;
  v->base = from;
  v->material = NULL;
  v->gloss = NULL;
  v->looks_again = false;
  v->o.nearest = c->nearest;
  v->o.product = c->product;
  v->o.keep = c->keep;
  v->o.threads = threads;
  v->o.progress = progress;
  v->stats.bytes = sizeof *v;
  ylm_status s =
      from->base ? ylm_fail(e, YLM_EINVAL, "a changed view is not changed again") : YLM_OK;
  if (s == YLM_OK && (from->idle || from->o.gloss == YLM_SHADE_GLOSS_RAYS))
    s = ylm_fail(
        e, YLM_EINVAL,
        "rays shade some surfaces of the prepared view that gloss, and it has no visibility "
        "there: prepare it with gloss = 'sh'");
  if (s == YLM_OK && c->camera) s = look_again(v, c, e);
  if (s == YLM_OK) s = dress(v, c->materials);
  if (s == YLM_OK && v->o.gloss) s = ylm__shade_gloss_create(v, from->gloss, &v->gloss, e);
  if (s == YLM_OK && v->transfer) /* refused, or made, here rather than at the first picture */
    s = ylm__shade_gloss_tables(v, v->o.lmax, threads, progress, &tables, e);
  v->o.progress = NULL;
  if (s == YLM_OK)
    *view = v;
  else
    ylm__shade_change_free(v);
  return s;
}
