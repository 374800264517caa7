/* weights.isa.c - how much each sphere lamp may bring to a point, once per instruction set.
   weights.c has the plain form. */
#include "ylm_simd.h"

#include "scene.h"

ylm_scene_weights_fn YLM_KERNEL(ylm_k_scene_weights);

YLM_INLINE float lane_sum(ylm_vf v) {
  float s = 0;
  for (int i = 0; i < YLM_VF; i++) s += v[i];
  return s;
}

YLM_INLINE ylm_vf root(ylm_vf x) {
  for (int i = 0; i < YLM_VF; i++) x[i] = sqrtf(x[i]);
  return x;
}

/* The bound for one vector of lamps: pi s cos, s = (r/d)^2, with the cosine of the lamp's highest
   point where the horizon cuts it; s = 1 from inside. */
YLM_INLINE ylm_vf weights(ylm_vf vx, ylm_vf vy, ylm_vf vz, ylm_vf r, const float n[3]) {
  const ylm_vf zero = {0}, one = zero + 1;
  ylm_vf d2 = vx * vx + vy * vy + vz * vz, r2 = r * r;
  ylm_vi inside = d2 <= r2;
  d2 = ylm_vf_select(inside, one, d2);
  ylm_vf cosine = (vx * n[0] + vy * n[1] + vz * n[2]) / root(d2);
  ylm_vf s = r2 / d2, cosine2 = cosine * cosine;
  ylm_vf sine2 = ylm_vf_select(cosine2 < one, one - cosine2, zero);
  ylm_vf inner = ylm_vf_select(s < one, one - s, zero);
  ylm_vf cut = cosine * root(inner) + root(sine2 * s);
  ylm_vi whole = (cosine > zero) & (cosine2 >= s), hidden = (cosine < zero) & (cosine2 >= s);
  ylm_vf w = ylm_vf_select(whole, cosine, ylm_vf_select(cut > zero, cut, zero));
  w = ylm_vf_select(hidden, zero, w) * s;
  return ylm_vf_select(inside, ylm_vf_select(r > zero, one, zero), w);
}

void YLM_KERNEL(ylm_k_scene_weights)(size_t chunks, float *const lamp[4], const float *luminance,
                                     const float x[3], const float n[3], float *w, float *sum) {
  for (size_t b = 0; b < chunks; b++) {
    ylm_vf s = {0};
    for (size_t j = b * YLM_LAMP_CHUNK; j < (b + 1) * YLM_LAMP_CHUNK; j += YLM_VF) {
      ylm_vf vx = ylm_vf_load(lamp[0] + j) - x[0], vy = ylm_vf_load(lamp[1] + j) - x[1],
             vz = ylm_vf_load(lamp[2] + j) - x[2];
      ylm_vf one = weights(vx, vy, vz, ylm_vf_load(lamp[3] + j), n) * ylm_vf_load(luminance + j);
      ylm_vf_store(w + j, one);
      s += one;
    }
    sum[b] = lane_sum(s);
  }
}
