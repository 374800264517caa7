/* vsgl.isa.c - groups of virtual lights as Gaussians, a vector of groups at a time, once per instruction set. vsgl.c has the
   plain form. */
#include "ylm_simd.h"

#include "many.h"
#include "ylm_shade_rise.h"

ylm_many_weights_fn YLM_KERNEL(ylm_k_many_gaussians);
ylm_many_gloss_fn YLM_KERNEL(ylm_k_many_gaussians_gloss);

/* (1 - e^(-2k))/k for k > 0. */
YLM_INLINE ylm_vf area(ylm_vf k) { return rise(2 * k) / k; }

/* The mean of the clamped cosine under a lobe of sharpness k, c the cosine from its axis to the normal. */
YLM_INLINE ylm_vf clamped(ylm_vf k, ylm_vf c) {
  const ylm_vf one = (ylm_vf){0} + 1;
  ylm_vf e = exponential(-2 * most(k, one * 0.1f)), over = 1 / most(k, one * 0.1f);
  ylm_vf R = (1 + e) / (1 - e) - over, each = R * over, c2 = c * c;
  ylm_vf v = each + c2 * (1 - 3 * each) - c2 * R * R;
  /* without terms that cancel, where the lobe is sharp */
  v = ylm_vf_select(k > 20, (1 - c2) * over + (2 * c2 - 1) * over * over, v);
  ylm_vf small = 1.0f / 3 - k * k * (1.0f / 45);
  R = ylm_vf_select(k < 0.1f, k * (1.0f / 3) * (1 - k * k * (1.0f / 15)), R);
  v = ylm_vf_select(k < 0.1f, small + c2 * (1 - 3 * small) - c2 * R * R, v);
  ylm_vf mean = c * R, s = ylm_vf_sqrt(most(v, one * 1e-30f)), t = mean / s;
  ylm_vf bell = exponential(-0.5f * t * t) * 0.39894228f, away = ylm_vf_select(t < 0, -t, t);
  /* the normal distribution's tail, to 7.5e-8 (Abramowitz & Stegun 1964, 26.2.17) */
  ylm_vf q = 1 / (1 + 0.2316419f * away), tail = one * 1.330274429f;
  tail = tail * q - 1.821255978f;
  tail = tail * q + 1.781477937f;
  tail = tail * q - 0.356563782f;
  tail = (tail * q + 0.319381530f) * q * bell;
  ylm_vf below = ylm_vf_select(t < 0, tail, 1 - tail);
  return most(one * 0, mean * below + s * bell) * (1 + 0.0858f * exponential(k * (-1 / 2.2f)));
}

/* Weights of groups: of the cosine about N, or of the lobe of a receiver. */
YLM_INLINE void gaussian(const ylm_many_lights *l, const ylm_many_receiver *r, size_t first,
                         size_t n, const float x[3], const float N[3], float (*w)[YLM_MANY_CHUNK]) {
  const ylm_vf one = (ylm_vf){0} + 1;
  for (size_t k = 0; k < n; k += YLM_VF) {
    size_t i = first + k;
    ylm_vf u[3], v[3], d2 = one * 0, along = one * 0, s2 = one * 0, c = one * 0;
    ylm_vf s = 1 / ylm_vf_load(l->radius + i), lam = ylm_vf_load(l->shift + i);
    for (int a = 0; a < 3; a++) {
      u[a] = ylm_vf_load(l->at[a] + i) - x[a];
      d2 += u[a] * u[a];
    }
    ylm_vf k1 = d2 * s * s, by = 1 / ylm_vf_sqrt(most(d2, one * 1e-30f));
    for (int a = 0; a < 3; a++) {
      ylm_vf axis = ylm_vf_load(l->normal[a] + i);
      u[a] *= by;
      along += u[a] * axis;
      v[a] = k1 * u[a] - lam * axis;
      s2 += v[a] * v[a];
    }
    ylm_vf sharp = most(ylm_vf_sqrt(s2), one * 1e-6f), over = 1 / sharp;
    ylm_vf power = exponential(least(one * 0, -2 * k1 * lam * (1 + along) /
                                                  most(sharp + k1 + lam, one * 1e-30f))) *
                   s * s;
    if (!r) {
      for (int a = 0; a < 3; a++) c += v[a] * over * N[a];
      c = most(least(c, one), -one);
      ylm_vf_store(w[0] + k, power * area(sharp) * clamped(sharp, c));
      continue;
    }
    ylm_vf both = one * 0, toward = one * 0, q[3];
    for (int a = 0; a < 3; a++) {
      q[a] = v[a] + r->sharp * r->lobe[a];
      both += q[a] * q[a];
      toward += v[a] * over * r->lobe[a];
    }
    both = most(ylm_vf_sqrt(both), one * 1e-6f);
    over = 1 / both;
    for (int a = 0; a < 3; a++) c += q[a] * over * N[a];
    c = most(least(c, one), -one);
    power *= exponential(least(one * 0, -2 * sharp * r->sharp * (1 - toward) /
                                            most(both + sharp + r->sharp, one * 1e-30f))) *
             area(both) * clamped(both, c);
    for (int f = 0; f < 3; f++) ylm_vf_store(w[f] + k, power * r->lobes[f]);
  }
}

void YLM_KERNEL(ylm_k_many_gaussians)(const ylm_many_lights *l, const ylm_many_ask *a, size_t first,
                                      size_t n, const float x[3], const float N[3], float *w) {
  (void)a;
  gaussian(l, NULL, first, n, x, N, (float(*)[YLM_MANY_CHUNK])(void *)w);
}

void YLM_KERNEL(ylm_k_many_gaussians_gloss)(const ylm_many_lights *l, const ylm_many_ask *a,
                                            const ylm_many_receiver *r, size_t first, size_t n,
                                            const float x[3], float (*w)[YLM_MANY_CHUNK]) {
  (void)a;
  gaussian(l, r, first, n, x, r->axis[2], w);
}
