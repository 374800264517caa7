/* weights.isa.c - how much each sphere lamp may bring to a point, once per instruction set.
   weights.c has the plain form. */
#include "ylm_simd.h"

#include "scene.h"

#if YLM_VECTOR_BYTES > 16
#define BYTES 16
#include "weights_of.h"
#undef BYTES
#endif
#define BYTES YLM_VECTOR_BYTES
#include "weights_of.h"

ylm_scene_weights_fn YLM_KERNEL(ylm_k_scene_weights);

YLM_INLINE float lane_sum(ylm_vf v) {
  float s = 0;
  for (int i = 0; i < YLM_VF; i++) s += v[i];
  return s;
}

void YLM_KERNEL(ylm_k_scene_weights)(size_t lamps, float *const lamp[4], const float *luminance,
                                     const float x[3], const float n[3], float *w, float *sum) {
#if YLM_VECTOR_BYTES > 16
  if (lamps <= 4) {
    floats_16 one = weigh_16(lamp, luminance, x, n, 0, w);
    sum[0] = one[0] + one[1] + one[2] + one[3];
    return;
  }
#endif
  for (size_t b = 0; b * YLM_LAMP_CHUNK < lamps; b++) {
    ylm_vf s = {0};
    size_t end = (b + 1) * YLM_LAMP_CHUNK < lamps ? (b + 1) * YLM_LAMP_CHUNK : lamps;
    for (size_t j = b * YLM_LAMP_CHUNK; j < end; j += YLM_VF)
      s += weigh(lamp, luminance, x, n, j, w);
    sum[b] = lane_sum(s);
  }
}
