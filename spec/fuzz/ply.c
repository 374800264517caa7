/* ply.c - fuzzes the PLY reader. */
#define FUZZ_PARSE ylm_mesh_parse_ply
#include "mesh.h"
