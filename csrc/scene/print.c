/* print.c - fingerprints of a scene: what two runs compare before their results are put together. */
#include <math.h>

#include "scene.h"
#include "ylm_light.h"

/* Directions in which skies of harmonics are asked. */
#define DIRECTIONS 256

static uint64_t floats(uint64_t crc, const float *x, size_t n) {
  uint64_t count = x ? n : 0;
  crc = ylm_crc64(crc, &count, sizeof count);
  return count ? ylm_crc64(crc, x, n * sizeof *x) : crc;
}

/* The origin, where it is not 0. */
static uint64_t begin(const ylm_scene *s, uint64_t crc) {
  return ylm_scene_origin(s) ? ylm_crc64(crc, s->origin, sizeof s->origin) : crc;
}

/* Normals that are means over triangles follow from the rest. */
static uint64_t geometry(const ylm_scene *s) {
  uint64_t crc = begin(s, 0);
  for (size_t i = 0; i < s->meshes; i++) {
    const scene_mesh *m = &s->mesh[i];
    uint64_t flags = (uint64_t)m->smooth + 2 * (uint64_t)m->occludes;
    crc = floats(crc, m->position, 3 * m->vertices);
    crc = floats(crc, m->smooth ? m->normal : NULL, 3 * m->vertices);
    crc = floats(crc, m->uv, 2 * m->vertices);
    crc = ylm_crc64(crc, m->triangle, 3 * m->count * sizeof *m->triangle);
    crc = ylm_crc64(crc, &flags, sizeof flags);
  }
  return crc;
}

static uint64_t materials(const ylm_scene *s) {
  uint64_t crc = 0;
  for (size_t i = 0; i < s->meshes; i++) {
    const scene_mesh *m = &s->mesh[i];
    uint64_t of[2] = {ylm_material_print(m->material),
                      m->texture ? ylm_texture_print(m->texture) : 0};
    crc = ylm_crc64(crc, of, sizeof of);
    crc = floats(crc, m->colour, 3 * m->vertices);
  }
  return crc;
}

/* A panorama's texels; of every sky the radiance in some directions. */
static uint64_t sky(const ylm_scene *s, uint64_t crc) {
  if (!s->sky) return crc;
  for (size_t i = 0; i < s->domes; i++) {
    const ylm_light_panorama *p = s->dome[i].light.panorama;
    if (p && p->texel) crc = floats(crc, p->texel, 3 * (size_t)p->width * (size_t)p->height);
  }
  for (int i = 0; i < DIRECTIONS; i++) {
    double d[3], rgb[3];
    ylm_spiral(i, DIRECTIONS, d);
    ylm_light_set_sky(s->sky, d, false, rgb);
    crc = floats(crc, (float[3]){(float)rgb[0], (float)rgb[1], (float)rgb[2]}, 3);
  }
  for (size_t i = 0; i < s->cones; i++) crc = ylm_crc64(crc, &s->cone[i], sizeof s->cone[i]);
  return crc;
}

static uint64_t lights(const ylm_scene *s, uint64_t crc) {
  size_t flat = s->triangles + s->disks;
  crc = begin(s, crc);
  for (int a = 0; a < 4; a++) crc = floats(crc, s->lamp[a], s->lamps);
  crc = floats(crc, s->lamp_radiance, 3 * (s->lamps + flat));
  crc = floats(crc, s->triangle, 9 * s->triangles);
  crc = floats(crc, s->disk, 7 * s->disks);
  crc = floats(crc, s->horizon, 3 * flat);
  for (size_t i = 0; i < s->textures; i++)
    crc = floats(crc, s->texture[i].texel, 3 * s->texture[i].width * s->texture[i].height);
  for (size_t i = 0; i < s->directions; i++)
    crc = ylm_crc64(crc, s->directed[i].emitter.x, s->directed[i].emitter.numbers * sizeof(double));
  for (size_t i = 0; i < s->points; i++)
    crc = ylm_crc64(crc, s->point[i].x, s->point[i].numbers * sizeof *s->point[i].x);
  return sky(s, crc);
}

void ylm_scene_print(const ylm_scene *s, ylm_scene_prints *out) {
  uint64_t seen = ylm_crc64(0, &s->sky_is_seen, sizeof s->sky_is_seen);
  *out = (ylm_scene_prints){
      .geometry = geometry(s), .materials = materials(s), .lights = lights(s, seen)};
}

uint64_t ylm_scene_print_lights(const ylm_scene *s) { return lights(s, 0); }
