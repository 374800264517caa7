/* mtl.c - fuzzes the MTL reader. */
#include <string.h>

#include "ylm_geom.h"

/* Numbers that were read are within `largest`, and none is NaN. */
static void check(bool has, const float *x, int n, float largest) {
  for (int i = 0; i < n; i++)
    if (has ? !(x[i] >= 0 && x[i] <= largest) : x[i] != 0) __builtin_trap();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  ylm_mesh_library *l;
  if (ylm_mesh_parse_mtl(data, size, "fuzz", &l, &e) != YLM_OK) {
    if (l || strncmp(e.text, "fuzz:", 5) != 0) __builtin_trap();
    return 0;
  }
  for (size_t i = 0; i < l->count; i++) {
    const ylm_mesh_material *m = &l->material[i];
    if (!m->name.text || !*m->name.text || (m->map_kd.text && !*m->map_kd.text)) __builtin_trap();
    check(m->has_kd, m->kd, 3, 1);
    check(m->has_ks, m->ks, 3, 1);
    check(m->has_ke, m->ke, 3, 1e30f);
    check(m->has_ns, &m->ns, 1, 1e5f);
  }
  if (strlen(l->words) >= sizeof l->words) __builtin_trap();
  ylm_mesh_library_free(l);
  return 0;
}
