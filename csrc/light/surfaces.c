/* surfaces.c - what rays see of a set of lights. */
#include <string.h>

#include "set.h"
#include "ylm_list.h"

/* Room for one more behind n elements, which fill a room for a power of two of them. */
static void *make_room(void *elements, size_t n, size_t size) {
  return n & (n - 1) ? elements : ylm_realloc(elements, n * size, n ? 2 * n : 1, size);
}

/* A row of `width` numbers behind n others. */
static double *append(double **rows, size_t n, size_t width) {
  double *more = make_room(*rows, n, width * sizeof **rows);
  if (!more) return NULL;
  *rows = more;
  return more + n * width;
}

static void put(double *to, const double *from) { memcpy(to, from, 3 * sizeof *to); }

static void put_emission(double *to, const double *radiance, const double *horizon) {
  put(to, radiance);
  put(to + 3, horizon);
}

ylm_status ylm__surfaces_sphere(ylm_light_surfaces *s, const ylm_light *sphere) {
  ylm_light *more = make_room(s->sphere, s->spheres, sizeof *more);
  if (!more) return YLM_ENOMEM;
  s->sphere = more;
  s->sphere[s->spheres++] = *sphere;
  return YLM_OK;
}

ylm_status ylm__surfaces_triangle(ylm_light_surfaces *s, const double *a, const double *b,
                                  const double *c, const double radiance[3],
                                  const double *horizon) {
  double *to = append(&s->triangle, s->triangles, 9);
  double *light = to ? append(&s->triangle_emission, s->triangles, 6) : NULL;
  if (!light) return YLM_ENOMEM;
  put(to, a), put(to + 3, b), put(to + 6, c);
  put_emission(light, radiance, horizon);
  s->triangles++;
  return YLM_OK;
}

ylm_status ylm__surfaces_disk(ylm_light_surfaces *s, const double at[3], double radius,
                              const double normal[3], const double radiance[3],
                              const double *horizon) {
  double *to = append(&s->disk, s->disks, 7);
  double *light = to ? append(&s->disk_emission, s->disks, 6) : NULL;
  if (!light) return YLM_ENOMEM;
  put(to, at);
  to[3] = radius;
  put(to + 4, normal);
  put_emission(light, radiance, horizon);
  s->disks++;
  return YLM_OK;
}

ylm_status ylm__surfaces_image(ylm_light_surfaces *s, const ylm_light_image *image) {
  if (!ylm_list_resize(&s->image, s->images, s->images + 1, sizeof *s->image)) return YLM_ENOMEM;
  s->image[s->images++] = *image;
  return YLM_OK;
}

ylm_status ylm__surfaces_direct(ylm_light_surfaces *s, ylm_light_directed_shape shape,
                                const ylm_light_emitter *emitter) {
  const size_t count[] = {[YLM_LIGHT_DIRECTED_SPHERE] = s->spheres,
                          [YLM_LIGHT_DIRECTED_TRIANGLE] = s->triangles,
                          [YLM_LIGHT_DIRECTED_DISK] = s->disks};
  ylm_light_directed *more = make_room(s->directed, s->directions, sizeof *more);
  if (!more) return YLM_ENOMEM;
  s->directed = more;
  more[s->directions++] = (ylm_light_directed){shape, count[shape] - 1, *emitter};
  return YLM_OK;
}

/* -- a set ------------------------------------------------------------------------------------ */

static bool has_places(const ylm_light_set *set, size_t pack) {
  for (size_t i = 0; i < set->places; i++)
    if (set->place[i].pack == pack) return true;
  return false;
}

/* The lights of a pack, those that are seen as images or others. */
static ylm_status add_pack(const ylm__light_pack *p, bool images, ylm_light_surfaces *out) {
  ylm_status s = YLM_OK;
  if (!p->kind->surfaces || p->kind->images != images) return s;
  for (size_t i = 0; i < (images ? 1 : p->n) && s == YLM_OK; i++)
    s = p->kind->surfaces(p->of, i, out);
  return s;
}

/* Flat lights in the order in which records were given; then packs that came from other sets; the
   triangles of images are the last. */
ylm_status ylm_light_set_surfaces(const ylm_light_set *set, size_t tiles, ylm_light_surfaces *out) {
  ylm_status s = YLM_OK;
  *out = (ylm_light_surfaces){.tiles = tiles};
  for (size_t i = 0; i < set->places && s == YLM_OK; i++) {
    const ylm__light_pack *p = set->pack[set->place[i].pack];
    if (p->kind->surfaces) s = p->kind->surfaces(p->of, set->place[i].i, out);
  }
  for (size_t k = 0; k < set->packs && s == YLM_OK; k++)
    if (!has_places(set, k)) s = add_pack(set->pack[k], false, out);
  for (size_t k = 0; k < set->packs && s == YLM_OK; k++) s = add_pack(set->pack[k], true, out);
  return s;
}

void ylm_light_surfaces_free(ylm_light_surfaces *s) {
  ylm_free(s->sphere);
  ylm_free(s->triangle);
  ylm_free(s->disk);
  ylm_free(s->triangle_emission);
  ylm_free(s->disk_emission);
  ylm_free(s->image);
  ylm_free(s->directed);
}
