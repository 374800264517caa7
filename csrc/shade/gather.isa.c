/* gather.isa.c - virtual lights at a point, a vector of lights at a time, once per instruction set.
   gather_plain.c has the plain form and the formulas. */
#include "ylm_simd.h"

#include "gather.h"

ylm_shade_weights_fn YLM_KERNEL(ylm_k_shade_weights);
ylm_shade_collect_fn YLM_KERNEL(ylm_k_shade_collect);

YLM_INLINE ylm_vf least(ylm_vf a, ylm_vf b) { return ylm_vf_select(a < b, a, b); }
YLM_INLINE ylm_vf most(ylm_vf a, ylm_vf b) { return ylm_vf_select(a > b, a, b); }

/* e^x for x <= 0, to 2 units in the last place; 0 below -87. */
YLM_INLINE ylm_vf exponential(ylm_vf x) {
  const ylm_vf zero = {0};
  ylm_vi dark = x < zero - 87;
  x = ylm_vf_select(dark, zero, x);
  ylm_vf round = x * 1.44269504f + 12582912.0f, n = round - 12582912.0f;
  ylm_vf r = x - n * 0.693359375f + n * 2.12194440e-4f, p = zero + 1.9875691500e-4f;
  p = p * r + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  p = p * r * r + r + 1;
  ylm_vi power = ((ylm_vi)round << 23) + (127 << 23); /* of 2^n */
  return ylm_vf_select(dark, zero, p * (ylm_vf)power);
}

/* 1 - e^-t for t >= 0. */
YLM_INLINE ylm_vf rise(ylm_vf t) {
  ylm_vf series = t * (1 - t * (0.5f - t * (0.16666667f - t * (0.041666668f - t * 0.0083333334f))));
  return ylm_vf_select(t < 0.1f, series, 1 - exponential(-t));
}

/* sum over l of z_l G_l P_l(c), of Gaussian lights and points. */
YLM_INLINE ylm_vf by_degrees(const gather_ask *a, int profile, ylm_vf r, ylm_vf d2, ylm_vf c) {
  const ylm_vf one = (ylm_vf){0} + 1;
  ylm_vf safe = most(d2, one * 1e-30f), inverse = 1 / safe, sg2 = r * r * 0.25f;
  ylm_vf G = inverse, decay = one;
  if (profile != YLM_LIGHT_VIRTUAL_POINT) {
    ylm_vf gauss = rise(2 * d2 / sg2) * inverse, far = rise(d2 * d2 * a->core) * inverse;
    gauss = ylm_vf_select(d2 <= 1e-30f, 2 / sg2, gauss);
    G = profile == YLM_LIGHT_VIRTUAL_FAR    ? far
        : profile == YLM_LIGHT_VIRTUAL_NEAR ? gauss - far
                                            : gauss;
    decay = exponential(most(-sg2 * inverse, one * -88));
  } else
    G = ylm_vf_select(d2 > 0, G, one * 0);
  ylm_vf A = one, q = one, P0 = one, P1 = c, sum = one * a->zonal[0];
  for (int k = 1; k <= a->o->lmax; k++) {
    q *= decay;
    A *= q;
    sum += a->zonal[k] * A * P1;
    float by = 1.0f / (float)(k + 1);
    ylm_vf P2 = (float)(2 * k + 1) * by * c * P1 - (float)k * by * P0;
    P0 = P1, P1 = P2;
  }
  return G * sum;
}

YLM_INLINE ylm_vf by_cap(const gather_ask *a, ylm_vf r, ylm_vf d2, ylm_vf c) {
  const ylm_vf one = (ylm_vf){0} + 1;
  ylm_vf m2 = most(d2, r * r), alpha = ylm_vf_sqrt(most(one * 0, 1 - r * r / m2));
  ylm_vf P0 = one, P1 = c, Q0 = one, Q1 = alpha, D0 = one * 0, D1 = one;
  ylm_vf sum = 2 * a->zonal[0] / (1 + alpha);
  for (int k = 1; k <= a->o->lmax; k++) {
    sum += a->zonal[k] * 2 / ((float)k * (float)(k + 1)) * D1 * P1;
    float by = 1.0f / (float)(k + 1), two = (float)(2 * k + 1);
    ylm_vf P2 = two * by * c * P1 - (float)k * by * P0;
    ylm_vf Q2 = two * by * alpha * Q1 - (float)k * by * Q0, D2 = D0 + two * Q1;
    P0 = P1, P1 = P2, Q0 = Q1, Q1 = Q2, D0 = D1, D1 = D2;
  }
  return sum / m2;
}

YLM_INLINE ylm_vf as_point(const gather_ask *a, ylm_vf d2, ylm_vf c, ylm_vf cosine) {
  const ylm_vf one = (ylm_vf){0} + 1;
  float limit = (float)a->o->limit, f = a->reflectance;
  ylm_vf inverse = 1 / most(d2, one * 1e-30f), g = most(one * 0, c) * cosine;
  switch (a->o->clamp) {
  case YLM_SHADE_CLAMP_DISTANCE: g *= least(inverse, one * limit); break;
  case YLM_SHADE_CLAMP_GEOMETRY: g = least(g * inverse, one * limit); break;
  case YLM_SHADE_CLAMP_WHOLE:
    g = f > 0 ? least(g * inverse, one * (limit / f)) : g * inverse;
    break;
  default: g *= inverse;
  }
  return ylm_vf_select(d2 > 0, g, one * 0);
}

YLM_INLINE void weigh(const gather_lights *l, const gather_ask *a, int profile, bool point,
                      size_t first, const float x[3], const float N[3], float *w) {
  const ylm_vf one = (ylm_vf){0} + 1;
  bool soft = !point && profile != YLM_LIGHT_VIRTUAL_CAP && profile != YLM_LIGHT_VIRTUAL_POINT;
  for (size_t k = 0; k < GATHER_CHUNK; k += YLM_VF) {
    size_t i = first + k;
    ylm_vf vx = ylm_vf_load(l->at[0] + i) - x[0], vy = ylm_vf_load(l->at[1] + i) - x[1],
           vz = ylm_vf_load(l->at[2] + i) - x[2], r = ylm_vf_load(l->radius + i);
    ylm_vf d2 = vx * vx + vy * vy + vz * vz, up = vx * N[0] + vy * N[1] + vz * N[2];
    ylm_vf along = -(vx * ylm_vf_load(l->normal[0] + i) + vy * ylm_vf_load(l->normal[1] + i) +
                     vz * ylm_vf_load(l->normal[2] + i));
    ylm_vf safe = most(d2, one * 1e-30f), c = up / ylm_vf_sqrt(safe);
    ylm_vf D =
        soft ? ylm_vf_sqrt(most(d2 + r * r * (0.25f / 16), one * 1e-30f)) : ylm_vf_sqrt(safe);
    ylm_vf cosine = most(one * 0, ylm_vf_load(l->shift + i) + along / D), g;
    if (point)
      g = as_point(a, d2, c, cosine);
    else if (profile == YLM_LIGHT_VIRTUAL_CAP)
      g = cosine * by_cap(a, r, d2, c);
    else
      g = cosine * by_degrees(a, profile, r, d2, c);
    if (!point && a->o->horizon == YLM_SHADE_HORIZON_GATE) g = ylm_vf_select(up < -r, one * 0, g);
    ylm_vf_store(w + k, g);
  }
}

void YLM_KERNEL(ylm_k_shade_weights)(const gather_lights *l, const gather_ask *a, size_t first,
                                     const float x[3], const float N[3], float *w) {
  if (a->o->method == YLM_SHADE_VPL) {
    weigh(l, a, 0, true, first, x, N, w);
    return;
  }
  switch (l->form.profile) {
  case YLM_LIGHT_VIRTUAL_CAP: weigh(l, a, YLM_LIGHT_VIRTUAL_CAP, false, first, x, N, w); break;
  case YLM_LIGHT_VIRTUAL_POINT: weigh(l, a, YLM_LIGHT_VIRTUAL_POINT, false, first, x, N, w); break;
  case YLM_LIGHT_VIRTUAL_FAR: weigh(l, a, YLM_LIGHT_VIRTUAL_FAR, false, first, x, N, w); break;
  case YLM_LIGHT_VIRTUAL_NEAR: weigh(l, a, YLM_LIGHT_VIRTUAL_NEAR, false, first, x, N, w); break;
  default: weigh(l, a, YLM_LIGHT_VIRTUAL_GAUSS, false, first, x, N, w);
  }
}

void YLM_KERNEL(ylm_k_shade_collect)(const float *w, const float *const I[3], double sum[3]) {
  ylm_vf s[3] = {{0}, {0}, {0}};
  for (size_t k = 0; k < GATHER_CHUNK; k += YLM_VF) {
    ylm_vf one = ylm_vf_load(w + k);
    for (int c = 0; c < 3; c++) s[c] += one * ylm_vf_load(I[c] + k);
  }
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < YLM_VF; i++) sum[c] += (double)s[c][i];
}
