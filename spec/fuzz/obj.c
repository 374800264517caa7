/* obj.c - fuzzes the OBJ reader. */
#define FUZZ_PARSE ylm_mesh_parse_obj
#include "mesh.h"
