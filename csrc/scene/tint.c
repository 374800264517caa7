/* tint.c - textures and colours of vertices: what multiplies the reflectance at a place. */
#include <math.h>

#include "scene.h"

static ylm_status check_colours(size_t i, const ylm_scene_mesh *in, ylm_error *e) {
  for (size_t k = 0; k < 3 * in->vertices; k++)
    if (!(in->colours[k] >= 0 && in->colours[k] <= 1))
      return ylm_fail(e, YLM_EDOMAIN,
                      "mesh %zu: the colour of vertex %zu must be from 0 to 1, got %g", i + 1,
                      k / 3 + 1, (double)in->colours[k]);
  return YLM_OK;
}

ylm_status ylm__scene_copy_tint(scene_mesh *m, size_t i, const ylm_scene_mesh *in, ylm_error *e) {
  if (in->texture && !in->uvs)
    return ylm_fail(e, YLM_EINVAL,
                    "mesh %zu: a texture needs texture coordinates (uvs), the mesh has none",
                    i + 1);
  m->texture = ylm_texture_keep(in->texture);
  if (!in->colours) return YLM_OK;
  ylm_status s = check_colours(i, in, e);
  if (s != YLM_OK) return s;
  m->colour = ylm_alloc_copy(in->colours, 3 * in->vertices, sizeof(float));
  return m->colour ? YLM_OK : YLM_ENOMEM;
}

void ylm__scene_free_tint(scene_mesh *m) {
  ylm_free(m->colour);
  ylm_texture_free(m->texture);
}

bool ylm_scene_is_tinted(const ylm_scene *s) {
  for (size_t i = 0; i < s->meshes; i++)
    if (s->mesh[i].colour || s->mesh[i].texture) return true;
  return false;
}

/* One of `width` numbers of the vertices, interpolated. */
static float mean(const float *x, size_t width, const uint32_t t[3], const float w[3]) {
  return w[0] * x[width * t[0]] + w[1] * x[width * t[1]] + w[2] * x[width * t[2]];
}

void ylm__scene_tint(const scene_mesh *m, const uint32_t t[3], const float w[3], float tint[3]) {
  tint[0] = tint[1] = tint[2] = 1;
  if (m->texture) ylm_texture_at(m->texture, mean(m->uv, 2, t, w), mean(m->uv + 1, 2, t, w), tint);
  for (int c = 0; m->colour && c < 3; c++)
    tint[c] *= fminf(1, fmaxf(0, mean(m->colour + c, 3, t, w))); /* weights may be a rounding off */
}
