/* ply.c - fuzzes the PLY reader. */
#include "ylm_geom.h"

static ylm_status parse(const unsigned char *bytes, size_t size, const char *name, ylm_mesh **mesh,
                        ylm_error *e) {
  return ylm_mesh_parse_ply(bytes, size, name, YLM_MESH_CREASE, mesh, e);
}

#define FUZZ_PARSE parse
#include "mesh.h"
