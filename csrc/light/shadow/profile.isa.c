/* profile.isa.c - a sphere at the directions of a rule, once per instruction set; profile.h has the plain form. */
#include "ylm_simd.h"

#include "shadow.h"

shadow_profile_fn YLM_KERNEL(ylm_k_shadow_profile);

/* Is a lane of the mask set? */
YLM_INLINE bool any(ylm_vi m) {
#if defined(__AVX512F__)
  return _mm512_test_epi32_mask((__m512i)m, (__m512i)m) != 0;
#elif defined(__AVX2__)
  return _mm256_movemask_ps((__m256)m) != 0;
#elif defined(__x86_64__)
  return _mm_movemask_ps((__m128)m) != 0;
#else
  int32_t some = 0;
  for (int i = 0; i < YLM_VF; i++) some |= m[i];
  return some != 0;
#endif
}

/* The directions of a vector, of which some are within the limit: d is the cosine of the angle to the cap's middle. */
YLM_INLINE void add(const shadow_rings *r, const shadow_cap *c, bool times, bool gradient, ylm_vf d,
                    size_t i, float *v) {
  const ylm_vf zero = {0}, one = ylm_vf_set(1);
  ylm_vf h2 = one - d * d;
  ylm_vf across = ylm_vf_sqrt(ylm_vf_select(h2 > zero, h2, zero));
  ylm_vf y = across * (float)c->cosine - d * (float)c->sine, y2 = y * y;
  ylm_vf angle = y * (one + y2 * ((float)(1.0 / 6) + y2 * (float)(3.0 / 40)));
  ylm_vf u = angle * (float)(1 / c->step) + 0.5f;
  u = ylm_vf_select(y < ylm_vf_set(-0.7f), zero, u);
  u = ylm_vf_select(u < zero, zero, ylm_vf_select(u > one, one, u));
  ylm_vf hidden = one - u * u * (3.0f - 2.0f * u), p = one - (float)c->deep * hidden;
  ylm_vf was = ylm_vf_load(v + i);
  ylm_vi less = p < was;
  ylm_vf_store(v + i, times ? was * p : ylm_vf_select(less, p, was));
  if (!gradient) return;
  ylm_vf steep = (float)(6 * c->deep / c->step) * u * (one - u) * (float)c->over;
  ylm_vf away = steep / ylm_vf_select(across > zero, across, one);
  away = ylm_vf_select(across > zero, away, zero);
  for (size_t k = 0; k < 3; k++) {
    ylm_vf n = ylm_vf_load(r->at_f + k * r->padded + i);
    float *to = v + (k + 1) * r->padded + i;
    ylm_vf slope = (n - (float)c->w[k] * d) * away - steep * (float)(c->w[k] * c->turn) -
                   (float)c->fade[k] * hidden;
    ylm_vf old = ylm_vf_load(to);
    ylm_vf_store(to, times ? old * p + was * slope : ylm_vf_select(less, slope, old));
  }
}

YLM_INLINE void rings(const shadow_rings *r, const shadow_cap *c, bool times, bool gradient,
                      float *v) {
  const float *x = r->at_f, *y = x + r->padded;
  ylm_vf limit = ylm_vf_set((float)c->limit);
  for (size_t k = 0; k < r->n; k++) {
    double z = r->z[k];
    if (z < c->low || z > c->high) continue;
    ylm_vf base = ylm_vf_set((float)(c->w[2] * z));
    size_t from = r->first[2 * k], to = from + r->first[2 * k + 1];
    for (size_t i = from; i < to; i += YLM_VF) {
      ylm_vf d = base + (float)c->w[0] * ylm_vf_load(x + i) + (float)c->w[1] * ylm_vf_load(y + i);
      if (any(d > limit)) add(r, c, times, gradient, d, i, v);
    }
  }
}

void YLM_KERNEL(ylm_k_shadow_profile)(const shadow_rings *r, const shadow_cap *c, bool times,
                                      size_t rows, float *v) {
  if (rows > 1)
    rings(r, c, times, true, v);
  else if (times)
    rings(r, c, true, false, v);
  else
    rings(r, c, false, false, v);
}
