/* storage.c - the arrays that lamps stand in, and which of them has a lamp. */
#include "scene.h"

const scene_storage *const ylm__scene_storage[SCENE_STORAGES] = {
    [SCENE_SPHERES] = &ylm__scene_spheres_storage,
    [SCENE_PATCHES] = &ylm__scene_patch_storage,
    [SCENE_SKY] = &ylm__scene_sky_storage,
    [SCENE_POINTS] = &ylm__scene_point_storage};

int ylm__scene_storage_of(const ylm_scene *s, size_t *lamp) {
  int k = 0;
  for (size_t n; k < SCENE_STORAGES - 1 && *lamp >= (n = ylm__scene_storage[k]->count(s)); k++)
    *lamp -= n;
  return k;
}

size_t ylm_scene_near(const ylm_scene *s) { return s->lamps + s->triangles + s->disks; }

size_t ylm_scene_lamps_all(const ylm_scene *s) {
  return ylm_scene_near(s) + s->sky_lights + s->points;
}

bool ylm_scene_is_distant(const ylm_scene *s, size_t lamp) {
  return ylm__scene_storage_of(s, &lamp) == SCENE_SKY;
}

bool ylm_scene_emitter(const ylm_scene *s, size_t lamp, ylm_light_emitter *out) {
  int k = ylm__scene_storage_of(s, &lamp);
  return ylm__scene_storage[k]->emitter(s, lamp, out);
}

bool ylm_scene_lamp_ray(const ylm_scene *s, size_t lamp, const float x[3], const double u[2],
                        ylm_trace_ray *ray) {
  const scene_aim a = {.x = x, .u = {u[0], u[1]}, .one = true};
  float radiance[3];
  int k = ylm__scene_storage_of(s, &lamp);
  return ylm__scene_storage[k]->sample(s, lamp, &a, ray, radiance) > 0;
}
