/*
** textured.c - parallelograms with an image, which they emit to both sides, as a kind of light.
**
** The light field is that of the image's parts, flat lights of one colour (texture.c); rays see the
** image. The kind has no records: ylm_light_set_textured makes a set of one.
**
** Source  Mezieres et al. 2022, Fig. 9 and Sec. 6
*/
#include <string.h>

#include "../flat/flat.h"
#include "../set.h"

typedef struct textured {
  ylm_polygons *parts;
  ylm_light_texture image; /* whose texels are its own */
  float *texel;
} textured;

static void release(void *of) {
  textured *t = of;
  if (!t) return;
  ylm_polygons_free(t->parts);
  ylm_free(t->texel);
  ylm_free(t);
}

static ylm_status evaluate(const void *of, ylm_isa isa, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const textured *t = of;
  return ylm__flat_evaluate(t->parts, isa, q, n, points, r, e);
}

static size_t get(const void *of, size_t i, ylm_light *out, ylm_light_shape *shape) {
  const textured *t = of;
  return ylm__flat_get(t->parts, i, out, shape);
}

static void device(const void *of, ylm_light_part *out) {
  const textured *t = of;
  ylm__flat_device(t->parts, out);
}

/* Triangles cover the whole parallelogram, as many whatever the parts are. */
static ylm_status surfaces(const void *of, size_t i, ylm_light_surfaces *out) {
  const textured *t = of;
  (void)i;
  size_t n = ylm_light_texture_tiles(&t->image, out->tiles, NULL, NULL);
  double *corners = ylm_alloc(n, 9 * sizeof *corners), *mean = ylm_alloc(n, 3 * sizeof *mean);
  ylm_status s = corners && mean ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) ylm_light_texture_tiles(&t->image, out->tiles, corners, mean);
  for (size_t k = 0; k < n && s == YLM_OK; k++) {
    const double *c = corners + 9 * k;
    s = ylm__surfaces_triangle(out, c, c + 3, c + 6, mean + 3 * k, t->parts->horizon);
  }
  ylm_free(corners);
  ylm_free(mean);
  if (s != YLM_OK) return s;
  ylm_light_image image = {.width = t->image.width,
                           .height = t->image.height,
                           .texel = t->texel,
                           .scale = t->image.scale,
                           .triangles = n};
  memcpy(image.corner, t->image.corner, sizeof image.corner);
  memcpy(image.u, t->image.u, sizeof image.u);
  memcpy(image.v, t->image.v, sizeof image.v);
  return ylm__surfaces_image(out, &image);
}

const ylm__light_kind ylm__textured_kind = {.name = "textured",
                                            .free = release,
                                            .evaluate = evaluate,
                                            .get = get,
                                            .surfaces = surfaces,
                                            .images = true,
                                            .device = device};

/* The parts as flat lights. */
static ylm_status make_parts(textured *t, bool exact, const double *horizon, size_t *n,
                             ylm_error *e) {
  *n = ylm_light_texture_quads(&t->image, NULL, NULL);
  double *vertices = ylm_alloc(*n, 12 * sizeof *vertices), *rgb = ylm_alloc(*n, 3 * sizeof *rgb);
  int *sides = ylm_alloc(*n, sizeof *sides);
  ylm_status s = vertices && rgb && sides ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && *n) ylm_light_texture_quads(&t->image, vertices, rgb);
  for (size_t i = 0; s == YLM_OK && i < *n; i++) sides[i] = 4;
  if (s == YLM_OK) s = ylm_polygons_create(*n, sides, vertices, rgb, exact, horizon, &t->parts, e);
  ylm_free(vertices);
  ylm_free(rgb);
  ylm_free(sides);
  return s;
}

/* Whether an image can be cut into parts. */
static ylm_status check(const ylm_light_texture *t, ylm_error *e) {
  size_t most = (size_t)1 << 16, where;
  if (t->width < 1 || t->width > most || t->height < 1 || t->height > most ||
      t->width * t->height > YLM_LIGHT_TEXELS)
    return ylm_fail(e, YLM_ERANGE,
                    "an image of %zu x %zu texels: sides are 1 to 65536, texels %d at most",
                    t->width, t->height, YLM_LIGHT_TEXELS);
  if (!(t->tolerance >= 0) || !(t->largest > 0 && t->largest <= 1) || !isfinite(t->scale))
    return ylm_fail(e, YLM_EDOMAIN,
                    "a texture's tolerance must be >= 0, its largest part above 0, at most 1, its "
                    "scale finite; got %g, "
                    "%g and %g",
                    t->tolerance, t->largest, t->scale);
  if (!ylm_all_finite(YLM_FLOAT, t->texel, 3 * t->width * t->height, &where))
    return ylm_fail(e, YLM_EDOMAIN, "texel %zu of row %zu is not finite", where / 3 % t->width + 1,
                    where / 3 / t->width + 1);
  return YLM_OK;
}

ylm_status ylm_light_set_textured(const ylm_light_texture *image, bool exact, const double *horizon,
                                  ylm_light_set **set, size_t *parts, ylm_error *e) {
  *set = NULL;
  ylm_status s = check(image, e);
  if (s != YLM_OK) return s;
  textured *t = ylm_alloc_zero(1, sizeof *t);
  if (!t) return ylm_no_memory(e);
  t->image = *image;
  t->image.texel = t->texel =
      ylm_alloc_copy(image->texel, 3 * image->width * image->height, sizeof *t->texel);
  s = t->texel ? make_parts(t, exact, horizon, parts, e) : YLM_ENOMEM;
  if (s == YLM_OK) {
    ylm__light_pack made = {&ylm__textured_kind, t, &t->parts->field, t->parts->n, 0};
    return ylm__light_set_of_pack(&made, set, e);
  }
  release(t);
  return s == YLM_ENOMEM ? ylm_no_memory(e) : s;
}
