/* vpl.isa.c - virtual lights as points, a vector of lights at a time, once per instruction set. vpl_plain.c has the plain
   form. */
#include "ylm_simd.h"

#include "many.h"
#include "ylm_shade_rise.h"

ylm_many_weights_fn YLM_KERNEL(ylm_k_many_points);

YLM_INLINE ylm_vf as_point(const ylm_many_ask *a, ylm_vf d2, ylm_vf c, ylm_vf cosine) {
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

void YLM_KERNEL(ylm_k_many_points)(const ylm_many_lights *l, const ylm_many_ask *a, size_t first,
                                   size_t n, const float x[3], const float N[3], float *w) {
  const ylm_vf one = (ylm_vf){0} + 1;
  for (size_t k = 0; k < n; k += YLM_VF) {
    size_t i = first + k;
    ylm_vf vx = ylm_vf_load(l->at[0] + i) - x[0], vy = ylm_vf_load(l->at[1] + i) - x[1],
           vz = ylm_vf_load(l->at[2] + i) - x[2];
    ylm_vf d2 = vx * vx + vy * vy + vz * vz, up = vx * N[0] + vy * N[1] + vz * N[2];
    ylm_vf along = -(vx * ylm_vf_load(l->normal[0] + i) + vy * ylm_vf_load(l->normal[1] + i) +
                     vz * ylm_vf_load(l->normal[2] + i));
    ylm_vf safe = most(d2, one * 1e-30f), c = up / ylm_vf_sqrt(safe), D = ylm_vf_sqrt(safe);
    ylm_vf cosine = most(one * 0, ylm_vf_load(l->shift + i) + along / D);
    ylm_vf_store(w + k, as_point(a, d2, c, cosine));
  }
}
