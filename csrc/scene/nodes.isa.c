/* nodes.isa.c - how much each child of a node of the tree of lamps may bring to a point, once per
   instruction set. nodes.c has the plain form. */
#include "ylm_simd.h"

#include "tree.h"

ylm_scene_nodes_fn YLM_KERNEL(ylm_k_scene_nodes);

YLM_INLINE ylm_vf most(ylm_vf a, ylm_vf b) { return ylm_vf_select(a > b, a, b); }
YLM_INLINE ylm_vf least(ylm_vf a, ylm_vf b) { return ylm_vf_select(a < b, a, b); }

/* The lanes that are set, as bits. */
YLM_INLINE uint32_t bits_of(ylm_vi mask) {
#if defined(__AVX512F__)
  return (uint32_t)_mm512_movepi32_mask((__m512i)mask);
#elif defined(__AVX2__)
  return (uint32_t)_mm256_movemask_ps((__m256)mask);
#elif defined(__x86_64__)
  return (uint32_t)_mm_movemask_ps((__m128)mask);
#else
  uint32_t bits = 0;
  for (int i = 0; i < YLM_VF; i++) bits |= (uint32_t)(mask[i] & 1) << i;
  return bits;
#endif
}

/* v'Fv */
YLM_INLINE ylm_vf facing(const scene_node *node, int i, ylm_vf x, ylm_vf y, ylm_vf z) {
  ylm_vf f[6];
  for (int k = 0; k < 6; k++) f[k] = ylm_vf_load(&node->facing[k][i]);
  return f[0] * x * x + f[1] * y * y + f[2] * z * z +
         2 * (f[3] * x * y + f[4] * x * z + f[5] * y * z);
}

YLM_INLINE ylm_vf trace_of(const scene_node *node, int i) {
  return ylm_vf_load(&node->facing[0][i]) + ylm_vf_load(&node->facing[1][i]) +
         ylm_vf_load(&node->facing[2][i]);
}

/* One vector of children from i on. */
YLM_INLINE void see(const scene_node *node, int i, bool flat, const float x[3], const float *n,
                    float limit, scene_seen *seen) {
  const ylm_vf zero = {0};
  ylm_vf vx = ylm_vf_load(&node->x[0][i]) - x[0], vy = ylm_vf_load(&node->x[1][i]) - x[1],
         vz = ylm_vf_load(&node->x[2][i]) - x[2];
  ylm_vf r = ylm_vf_load(&node->radius[i]), power = ylm_vf_load(&node->power[i]);
  ylm_vf spread = (float)SCENE_SPREAD * ylm_vf_load(&node->spread[i]);
  ylm_vf d2 = vx * vx + vy * vy + vz * vz, far2 = most(d2 + spread, 0.01f * r * r);
  ylm_vf inverse2 = 1 / far2, w = power * inverse2;
  ylm_vf doubt = spread * inverse2 * w;
  if (n) {
    ylm_vf over = most(vx * n[0] + vy * n[1] + vz * n[2] + r, zero), soft = least(over, 2 * r);
    ylm_vf inverse = ylm_vf_sqrt(inverse2);
    doubt = (doubt * over + 0.25f * w * least(soft, 2 * r - soft)) * inverse;
    w *= (soft * soft / (4 * r) + (over - soft)) * inverse;
  }
  if (flat) {
    ylm_vf q =
        most(facing(node, i, vx, vy, vz), zero) + trace_of(node, i) * (1 / 3.f) * (far2 - d2);
    ylm_vf cosine = ylm_vf_sqrt(q * inverse2);
    w *= cosine;
    doubt *= cosine;
  }
  w = ylm_vf_select(power > zero, w, zero);
  ylm_vf_store(seen->weight + i, w);
  ylm_vf_store(seen->doubt + i, doubt);
  seen->doubtful |= bits_of(doubt > limit) << i;
  seen->live |= bits_of(w > zero) << i;
  seen->near |= bits_of(d2 < (float)(SCENE_NEAR * SCENE_NEAR) * r * r) << i;
}

void YLM_KERNEL(ylm_k_scene_nodes)(const scene_node *node, bool flat, const float x[3],
                                   const float *n, float limit, scene_seen *seen) {
  seen->live = seen->near = seen->doubtful = 0;
  for (int i = 0; i < SCENE_WIDTH; i += YLM_VF) see(node, i, flat, x, n, limit, seen);
}
