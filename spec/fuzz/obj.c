/* obj.c - fuzzes the OBJ reader, and the division of what it read by materials. */
#include "ylm_geom.h"

/* Every triangle is in one part, whose vertices are those of the mesh. */
static void check_parts(const ylm_mesh *mesh, ylm_mesh **part, size_t parts) {
  size_t triangles = 0;
  for (size_t k = 0; k < parts; k++) {
    if (!part[k]) continue;
    triangles += part[k]->triangles;
    if (part[k]->vertices > mesh->vertices || !part[k]->uv != !mesh->uv) __builtin_trap();
    for (size_t i = 0; i < 3 * part[k]->triangles; i++)
      if (part[k]->index[i] >= part[k]->vertices) __builtin_trap();
    ylm_mesh_free(part[k]);
  }
  if (triangles != mesh->triangles) __builtin_trap();
}

static ylm_status parse(const unsigned char *text, size_t size, const char *name, ylm_mesh **mesh,
                        ylm_error *e) {
  ylm_mesh_groups *g;
  ylm_status s = ylm_mesh_parse_obj_groups(text, size, name, YLM_MESH_CREASE, mesh, &g, e);
  if (s != YLM_OK) {
    if (g) __builtin_trap();
    return s;
  }
  ylm_mesh **part = ylm_alloc(g->names + 1, sizeof *part);
  if (part && ylm_mesh_split(*mesh, g, part, e) == YLM_OK) check_parts(*mesh, part, g->names + 1);
  ylm_free(part);
  ylm_mesh_groups_free(g);
  return s;
}

#define FUZZ_PARSE parse
#include "mesh.h"
