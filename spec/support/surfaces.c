/*
** surfaces.c - surfaces at places of three meshes, side by side and one by one, for specs: their bits are the same.
**
** Prints the number of places, how many differ, and the first of those.
*/
#include <stdio.h>
#include <string.h>

#include <ylm/ylm_geom.h>
#include <ylm/ylm_scene.h>

enum { PLACES = 4099 };

/* A number of 0 .. 1. */
static float draw(ylm_rng *r) { return (float)ylm_rng_u32(r) * 0x1p-32f; }

/* Places near edges, at corners and within, from both sides. */
static void choose(const ylm_scene_mesh *mesh, ylm_scene_place *p) {
  ylm_rng r;
  ylm_rng_seed(&r, 1, 1);
  for (size_t i = 0; i < PLACES; i++) {
    float u = draw(&r), v = (1 - u) * draw(&r);
    if (i % 7 == 0) v = 0;
    if (i % 11 == 0) u = i % 2 ? 0 : 1e-7f;
    if (i % 13 == 0) v = 1 - u;
    p[i] = (ylm_scene_place){(uint32_t)(i % 3), 0, u, v, i % 5 == 0};
    p[i].element = (uint32_t)(draw(&r) * 0.999f * (float)mesh[i % 3].count);
  }
}

static int differ(const ylm_scene_surface *a, const ylm_scene_surface *b) {
  return memcmp(a->position, b->position, 12) || memcmp(a->normal, b->normal, 12) ||
         memcmp(a->lit, b->lit, 12) || memcmp(a->origin, b->origin, 12) ||
         memcmp(a->flat, b->flat, 12) || memcmp(a->tangent, b->tangent, 12) ||
         memcmp(a->tint, b->tint, 12) || a->material != b->material;
}

int main(void) {
  static ylm_scene_place place[PLACES];
  static ylm_scene_surface all[PLACES];
  ylm_mesh *m[3];
  ylm_scene_mesh mesh[3] = {0};
  ylm_scene_lamps lamps = {0};
  ylm_scene *scene;
  ylm_material *matte;
  size_t wrong = 0, first = 0;
  if (ylm_mesh_knot(2, 3, .35, .14, .06, 60, 12, &m[0], NULL) != YLM_OK ||
      ylm_mesh_sphere(1, 9, 5, &m[1], NULL) != YLM_OK ||
      ylm_mesh_quad((double[]){.1, .2, .3}, (double[]){3, .1, .2}, (double[]){.3, .1, -2}, 4, 3,
                    &m[2], NULL) != YLM_OK ||
      ylm_material_create(0, 3, (float[]){.5f, .5f, .5f}, &matte, NULL) != YLM_OK)
    return 1;
  for (int i = 0; i < 3; i++)
    mesh[i] = (ylm_scene_mesh){.positions = m[i]->position,
                               .normals = i == 1 ? NULL : m[i]->normal,
                               .uvs = i == 2 ? m[i]->uv : NULL,
                               .vertices = m[i]->vertices,
                               .triangles = m[i]->index,
                               .count = m[i]->triangles,
                               .material = matte,
                               .occludes = true};
  if (ylm_scene_create(3, mesh, &lamps, &scene, NULL) != YLM_OK) return 1;
  choose(mesh, place);
  ylm_scene_surfaces(scene, PLACES, place, all);
  for (size_t i = PLACES; i-- > 0;) {
    ylm_scene_surface one;
    ylm_scene_surfaces(scene, 1, &place[i], &one);
    if (differ(&one, &all[i])) wrong++, first = i;
  }
  printf("%d places, %zu differ, the first is %zu\n", PLACES, wrong, first);
  ylm_scene_free(scene);
  ylm_material_free(matte);
  for (int i = 0; i < 3; i++) ylm_mesh_free(m[i]);
  return 0;
}
