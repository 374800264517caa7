/* spheres.isa.c - rays to spheres, once per instruction set. spheres.c has the plain form. */
#include "ylm_simd.h"

#include "tree.h"

#if YLM_VECTOR_BYTES > 16
#define BYTES 16
#include "spheres_of.h"
#undef BYTES
#endif
#define BYTES YLM_VECTOR_BYTES
#include "spheres_of.h"

ylm_scene_spheres_fn YLM_KERNEL(ylm_k_scene_spheres);

void YLM_KERNEL(ylm_k_scene_spheres)(size_t n, const float normal[3], scene_spheres *a) {
#if YLM_VECTOR_BYTES > 16
  if (n <= 4) {
    aim_16(normal, 0, a);
    return;
  }
#endif
  for (size_t i = 0; i < n; i += YLM_VF) aim(normal, i, a);
}
