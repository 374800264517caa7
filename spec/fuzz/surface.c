/*
** surface.c - fuzzes the reader of light on surfaces (.surfaces), for a scene of a quad, a wall that stands on it, and a sphere.
**
** Mutations get a size, a fingerprint and a checksum that fit, and most of them the number of charts, or else nothing behind
** these would be reached; one in sixteen goes through as it is. Most keep their size. Files that are accepted are looked up at
** places of each triangle, and drawn as rectangles.
*/
#include <string.h>

#include "../../csrc/surface/surface.h"
#include "ylm_geom.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);

/* Offsets in the header (docs/surfaces.md), its size, and the charts of the scene: two of each plane, six of the sphere. */
enum { AT_SIZE = 16, AT_PRINT = 24, AT_CHARTS = 56, HEADER = 144, CHARTS = 2 + 12 + 6 };

static ylm_scene_mesh part(const ylm_mesh *m, const ylm_material *material) {
  return (ylm_scene_mesh){.positions = m->position,
                          .normals = m->normal,
                          .vertices = m->vertices,
                          .triangles = m->index,
                          .count = m->triangles,
                          .material = material,
                          .occludes = true};
}

static const ylm_scene *scene(void) {
  static ylm_scene *s = NULL;
  const double lo[3] = {0.3, -0.5, -0.4}, hi[3] = {0.4, 0.4, 0.4};
  const double corner[3] = {-1, -0.5, 1}, u[3] = {2, 0, 0}, v[3] = {0, 0, -2};
  const float grey[3] = {0.5f, 0.5f, 0.5f};
  ylm_mesh *mesh[3];
  ylm_material *m;
  const ylm_scene_lamps none = {.sky = NULL};
  if (s) return s;
  if (ylm_mesh_quad(corner, u, v, 1, 1, &mesh[0], NULL) != YLM_OK ||
      ylm_mesh_box(lo, hi, 1, &mesh[1], NULL) != YLM_OK ||
      ylm_mesh_sphere(0.25, 8, 4, &mesh[2], NULL) != YLM_OK ||
      ylm_material_create(ylm_material_kind_find("matte"), 3, grey, &m, NULL) != YLM_OK)
    __builtin_trap();
  const ylm_scene_mesh meshes[3] = {part(mesh[0], m), part(mesh[1], m), part(mesh[2], m)};
  if (ylm_scene_create(3, meshes, &none, &s, NULL) != YLM_OK) __builtin_trap();
  for (int i = 0; i < 3; i++) ylm_mesh_free(mesh[i]);
  ylm_material_free(m);
  return s;
}

static void seal(uint8_t *data, size_t size, bool charts) {
  static ylm_scene_prints print;
  const uint32_t count = CHARTS;
  if (!print.geometry) ylm_scene_print(scene(), &print);
  uint64_t x = size;
  memcpy(data + AT_SIZE, &x, sizeof x);
  memcpy(data + AT_PRINT, &print.geometry, sizeof print.geometry);
  if (charts) memcpy(data + AT_CHARTS, &count, sizeof count);
  x = ylm_crc64(0, data, size - 8);
  memcpy(data + size - 8, &x, sizeof x);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed) {
  size_t before = size, head = size > HEADER && seed % 8 ? HEADER : 0;
  size = head + LLVMFuzzerMutate(data + head, size - head, (seed % 4 ? size : room) - head);
  if (seed % 4 && before <= room) {
    memset(data + size, 0, before - size);
    size = before;
  }
  if (size >= HEADER + 8 && seed % 16) seal(data, size, seed % 32 != 1);
  return size;
}

/* Looks a grid up at three places of each side of each triangle, and draws its rectangles. */
static void use(const ylm_surface_grid *g) {
  static const float at[3][2] = {{0.3f, 0.3f}, {0, 0}, {0.9f, 0.1f}};
  ylm_surface_stats stats;
  ylm_surface_look(g, &stats);
  for (uint32_t m = 0; m < ylm_scene_meshes(scene()); m++)
    for (uint32_t i = 0; i < ylm_scene_triangles(scene(), m); i++)
      for (int k = 0; k < 6; k++) {
        const ylm_scene_place place = {m, i, at[k / 2][0], at[k / 2][1], k % 2};
        float E[1][3];
        uint32_t rectangle;
        ylm_surface_irradiance(g, 1, &place, E, &rectangle, 1);
        if (rectangle != UINT32_MAX && rectangle >= stats.rectangles) __builtin_trap();
        for (int c = 0; c < 3; c++)
          if (!(E[0][c] >= 0)) __builtin_trap();
      }
  for (size_t i = 0; i < stats.rectangles; i++) {
    float corner[4][3], value[4][3];
    ylm_surface_rectangle(g, i, corner, value);
    if (!(value[3][2] >= 0)) __builtin_trap();
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  ylm_surface_grid *g;
  ylm_surface_stats stats;
  bool told = ylm_surface_inspect(data, size, "fuzz", &stats, &e) == YLM_OK;
  if (ylm_surface_read(scene(), data, size, "fuzz", &g, &e) != YLM_OK) {
    if (g) __builtin_trap();
    return 0;
  }
  if (!told) __builtin_trap();
  use(g);
  ylm_surface_free(g);
  return 0;
}
