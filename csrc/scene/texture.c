/* texture.c - what flat lamps emit where rays meet them: textures, and radiance that depends on the direction. */
#include <math.h>
#include <string.h>

#include "scene.h"
#include "ylm_light_emitter.h"

/* The vectors whose products with p - corner are the image's coordinates; false: no area. */
static bool coordinates(const ylm_light_image *in, scene_texture *out) {
  const double *u = in->u, *v = in->v;
  double uu = 0, uv = 0, vv = 0;
  for (int a = 0; a < 3; a++) uu += u[a] * u[a], uv += u[a] * v[a], vv += v[a] * v[a];
  double d = uu * vv - uv * uv;
  for (int a = 0; a < 3; a++) {
    out->corner[a] = in->corner[a];
    out->across[a] = (vv * u[a] - uv * v[a]) / d;
    out->up[a] = (uu * v[a] - uv * u[a]) / d;
    if (!isfinite(out->corner[a] + out->across[a] + out->up[a])) return false;
  }
  return d > 0;
}

static ylm_status copy(scene_texture *t, const ylm_light_image *in, const double origin[3],
                       ylm_error *e) {
  size_t n = 3 * in->width * in->height, where;
  t->width = in->width;
  t->height = in->height;
  if (n == 0 || !coordinates(in, t)) return ylm_fail(e, YLM_EDOMAIN, "a textured lamp has no area");
  for (int a = 0; a < 3; a++) t->corner[a] -= origin[a];
  if (!ylm_all_finite(YLM_FLOAT, in->texel, n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "a texel of a lamp is not finite");
  if (!(t->texel = ylm_alloc(n, sizeof *t->texel))) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) t->texel[i] = (float)((double)in->texel[i] * in->scale);
  return YLM_OK;
}

ylm_status ylm__scene_copy_textures(ylm_scene *s, const ylm_scene_lamps *l, ylm_error *e) {
  size_t behind = s->triangles;
  s->texture = ylm_alloc_zero(l->images, sizeof *s->texture);
  if (!s->texture) return YLM_ENOMEM;
  s->textures = l->images;
  for (size_t i = l->images; i-- > 0;) {
    if (l->image[i].triangles > behind)
      return ylm_fail(e, YLM_EINVAL, "textures have more triangles than there are");
    s->texture[i].behind = behind;
    s->texture[i].first = behind -= l->image[i].triangles;
    ylm_status st = copy(&s->texture[i], &l->image[i], s->origin, e);
    if (st != YLM_OK) return st;
  }
  return YLM_OK;
}

void ylm__scene_free_textures(ylm_scene *s) {
  for (size_t i = 0; i < s->textures; i++) ylm_free(s->texture[i].texel);
  ylm_free(s->texture);
}

/* Which of n texels holds x of 0 .. 1. */
static size_t index_of(double x, size_t n) {
  double i = floor(x * (double)n);
  return i > 0 ? (i < (double)n ? (size_t)i : n - 1) : 0;
}

static const float *texel_at(const scene_texture *t, const double p[3]) {
  double s = 0, r = 0;
  for (int a = 0; a < 3; a++) {
    s += t->across[a] * (p[a] - t->corner[a]);
    r += t->up[a] * (p[a] - t->corner[a]);
  }
  return t->texel + 3 * (index_of(1 - r, t->height) * t->width + index_of(s, t->width));
}

static const float *radiance_of(const ylm_scene *s, size_t i, const double p[3]) {
  if (s->textures > 0 && i >= s->texture[0].first && i < s->triangles) {
    size_t lo = 0, hi = s->textures; /* the last texture whose triangles begin at i or before */
    while (hi - lo > 1) {
      size_t mid = (lo + hi) / 2;
      if (s->texture[mid].first <= i)
        lo = mid;
      else
        hi = mid;
    }
    return texel_at(&s->texture[lo], p);
  }
  return s->lamp_radiance + 3 * (s->lamps + i);
}

void ylm__scene_patch_radiance(const ylm_scene *s, size_t i, const double p[3], const float d[3],
                               float radiance[3]) {
  if (ylm__scene_directed_radiance(s, s->lamps + i, d, radiance)) return;
  memcpy(radiance, radiance_of(s, i, p), 12);
}
