/* room.h - the scene of some benches: a knot in a box, lit by one sphere. */
#ifndef YLM_BENCH_ROOM_H
#define YLM_BENCH_ROOM_H

#include <stdlib.h>

#include "ylm_geom.h"
#include "ylm_scene.h"

/* The lamp: its place, and its radius. */
static const float bench_lamp[4] = {2, 2, 1, 0.2f};

static inline ylm_scene_mesh bench_part(const ylm_mesh *m, const ylm_material *material) {
  return (ylm_scene_mesh){.positions = m->position,
                          .normals = m->normal,
                          .vertices = m->vertices,
                          .triangles = m->index,
                          .count = m->triangles,
                          .material = material,
                          .occludes = true};
}

static inline ylm_scene *bench_room(void) {
  const double lo[3] = {-3, -3, -2}, hi[3] = {3, 3, 2};
  const float albedo[3] = {0.7f, 0.6f, 0.5f}, radiance[3] = {30, 30, 30};
  ylm_mesh *mesh[2];
  ylm_material *m;
  ylm_scene *s;
  if (ylm_mesh_box(lo, hi, 1, &mesh[0], NULL) != YLM_OK ||
      ylm_mesh_knot(2, 3, 1.2, 0.5, 0.25, 150, 40, &mesh[1], NULL) != YLM_OK ||
      ylm_material_create(ylm_material_kind_find("matte"), 3, albedo, &m, NULL) != YLM_OK)
    exit(1);
  const ylm_scene_mesh parts[2] = {bench_part(mesh[0], m), bench_part(mesh[1], m)};
  const ylm_scene_lamps l = {.shape = {.spheres = 1, .sphere = bench_lamp}, .radiance = radiance};
  if (ylm_scene_create(2, parts, &l, &s, NULL) != YLM_OK) exit(1);
  for (int i = 0; i < 2; i++) ylm_mesh_free(mesh[i]);
  ylm_material_free(m);
  return s;
}

#endif
