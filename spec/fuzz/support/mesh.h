/* mesh.h - fuzzes a reader of meshes, FUZZ_PARSE: the body of obj.c and ply.c. */
#include "ylm_geom.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  ylm_mesh *mesh;
  if (FUZZ_PARSE(data, size, "fuzz", &mesh, &e) != YLM_OK) {
    if (mesh) __builtin_trap();
    return 0;
  }
  for (size_t i = 0; i < 3 * mesh->triangles; i++)
    if (mesh->index[i] >= mesh->vertices) __builtin_trap();
  size_t where;
  if (!mesh->normal || !ylm_all_finite(YLM_FLOAT, mesh->position, 3 * mesh->vertices, &where))
    __builtin_trap();
  if (!ylm_all_finite(YLM_FLOAT, mesh->normal, 3 * mesh->vertices, &where)) __builtin_trap();
  ylm_mesh_free(mesh);
  return 0;
}
