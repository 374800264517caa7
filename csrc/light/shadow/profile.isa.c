/* profile.isa.c - a sphere at the directions of a rule, once per instruction set; spheres.real.c has the plain form. */
#include "ylm_simd.h"

#include "shadow.h"

shadow_profile_fn YLM_KERNEL(ylm_k_shadow_profile);

/* The directions of a vector: d is the cosine of the angle to the cap's middle. */
YLM_INLINE void add(const shadow_rings *r, const shadow_cap *c, bool times, bool gradient, ylm_vf d,
                    ylm_vf limit, size_t i, float *v) {
  const ylm_vf zero = {0}, one = ylm_vf_set(1);
  ylm_vf h2 = one - d * d;
  ylm_vf across = ylm_vf_sqrt(ylm_vf_select(h2 > zero, h2, zero));
  ylm_vf y = across * (float)c->cosine - d * (float)c->sine, y2 = y * y;
  ylm_vf angle = y * (one + y2 * ((float)(1.0 / 6) + y2 * (float)(3.0 / 40)));
  ylm_vf u = angle * (float)(1 / c->step) + 0.5f;
  u = ylm_vf_select(y < ylm_vf_set(-0.7f), zero, u);
  u = ylm_vf_select(u < zero, zero, ylm_vf_select(u > one, one, u));
  u = ylm_vf_select(d > limit, u, one);
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

/* The vectors of directions, of each ring, that a cap may reach: from .. to - 1 in numbers, and those before `wrapped`. */
typedef struct window {
  size_t from, to, wrapped;
} window;

static window window_of(const shadow_rings *r, const shadow_cap *c) {
  const double turn = 1 / (2 * YLM_PI);
  double m = (double)r->around, middle = (c->azimuth * turn + 0.5) * m - 0.5;
  /* the arcsine, or more */
  double half = (c->reach + 0.5709 * c->reach * c->reach * c->reach) * turn * m + 0.01;
  double low = ceil(middle - half), high = floor(middle + half);
  window all = {0, r->around, 0};
  if (!(c->reach < 1) || high - low + 1 >= m) return all;
  if (high < low) return (window){0, 0, 0};
  window w = {0, 0, 0};
  if (low < 0) {
    w = (window){(size_t)(low + m), r->around, (size_t)(high < 0 ? 0 : high + 1)};
    if (high < 0) w.to = (size_t)(high + m) + 1;
  } else if (high >= m) {
    w = (window){(size_t)low, r->around, (size_t)(high - m) + 1};
    if (low >= m) w = (window){(size_t)(low - m), (size_t)(high - m) + 1, 0};
  } else
    w = (window){(size_t)low, (size_t)high + 1, 0};
  w.from = w.from / YLM_VF * YLM_VF;
  return w.wrapped > w.from ? all : w;
}

YLM_INLINE ylm_vf cosines(const shadow_rings *r, const shadow_cap *c, double along, size_t i) {
  const float *x = r->at_f, *y = x + r->padded;
  return (float)along + (float)c->w[0] * ylm_vf_load(x + i) + (float)c->w[1] * ylm_vf_load(y + i);
}

YLM_INLINE void rings(const shadow_rings *r, const shadow_cap *c, bool times, bool gradient,
                      float *v) {
  ylm_vf limit = ylm_vf_set((float)c->limit);
  window w = window_of(r, c);
  for (size_t k = 0; k < r->n; k++) {
    double z = r->z[k], along = c->w[2] * z;
    if (z < c->low || z > c->high) continue;
    size_t from = r->first[2 * k], count = r->first[2 * k + 1];
    if (count != r->around) { /* the equator, whose directions stand there twice */
      for (size_t i = from; i < from + count; i += YLM_VF)
        add(r, c, times, gradient, cosines(r, c, along, i), limit, i, v);
      continue;
    }
    for (size_t i = from + w.from; i < from + w.to; i += YLM_VF)
      add(r, c, times, gradient, cosines(r, c, along, i), limit, i, v);
    for (size_t i = from; i < from + w.wrapped; i += YLM_VF)
      add(r, c, times, gradient, cosines(r, c, along, i), limit, i, v);
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
