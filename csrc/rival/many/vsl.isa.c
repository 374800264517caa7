/* vsl.isa.c - virtual lights as spheres at a point that is matte, a vector of lights at a time, once per instruction
   set. vsl.c has the plain form and the ways. */
#include "ylm_simd.h"

#include "many.h"

ylm_many_spheres_fn YLM_KERNEL(ylm_k_many_spheres);

typedef uint32_t vu __attribute__((vector_size(YLM_VECTOR_BYTES)));

YLM_INLINE ylm_vf least(ylm_vf a, ylm_vf b) { return ylm_vf_select(a < b, a, b); }
YLM_INLINE ylm_vf most(ylm_vf a, ylm_vf b) { return ylm_vf_select(a > b, a, b); }
YLM_INLINE ylm_vf dot(const ylm_vf *a, const ylm_vf *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Lights as they are seen from a point. */
typedef struct sphere {
  ylm_vf w[3], N[3], n[3], shift;
  ylm_vf edge, part, over_cone; /* cosine of the half angle; 1 less it; 1 over the solid angle */
  ylm_vf directions;            /* of each way */
  ylm_vi on, wide;              /* something is above both horizons; all ways are weighed */
} sphere;

/* Numbers from 0, below 1, of lights from `first` on. */
YLM_INLINE ylm_vf numbers(uint32_t seed, uint32_t step, size_t first) {
  vu lane;
  for (int i = 0; i < YLM_VF; i++) lane[i] = (uint32_t)first + (uint32_t)i;
  vu x = lane * step + seed;
  return (ylm_vf)(x >> 9 | 0x3f800000u) - 1;
}

/* Axes at right angles to n (ylm_scene_basis). */
YLM_INLINE void basis(const ylm_vf n[3], ylm_vf a[3], ylm_vf b[3]) {
  const ylm_vf one = (ylm_vf){0} + 1;
  ylm_vf s = ylm_vf_select((ylm_vi)n[2] < 0, -one, one), p = -1 / (s + n[2]), q = n[0] * n[1] * p;
  a[0] = 1 + s * n[0] * n[0] * p, a[1] = s * q, a[2] = -s * n[0];
  b[0] = q, b[1] = s + n[1] * n[1] * p, b[2] = -n[1];
}

/* Cosine and sine of v turns, v from 0, below 1. */
YLM_INLINE void turn(ylm_vf v, ylm_vf *c, ylm_vf *s) {
  ylm_vf x = (v - 0.5f) * (float)YLM_PI, x2 = x * x; /* half the angle, less half a turn */
  ylm_vf half_s =
      x * (1 + x2 * (-0.16666667f +
                     x2 * (8.3333333e-3f +
                           x2 * (-1.9841270e-4f + x2 * (2.7557319e-6f - x2 * 2.5052108e-8f)))));
  ylm_vf half_c =
      1 + x2 * (-0.5f +
                x2 * (4.1666667e-2f +
                      x2 * (-1.3888889e-3f +
                            x2 * (2.4801587e-5f + x2 * (-2.7557319e-7f + x2 * 2.0876757e-9f)))));
  *s = -2 * half_s * half_c;
  *c = 2 * half_s * half_s - 1;
}

/* The sum over directions of one way. */
YLM_INLINE ylm_vf sum_of(const sphere *s, int way, bool alone, int count, ylm_vf u0, ylm_vf v0,
                         ylm_vi on) {
  const ylm_vf zero = {0}, *axis = way == VSL_CONE ? s->w : way == VSL_RECEIVER ? s->N : s->n;
  const float sign = way == VSL_LIGHT ? -1 : 1;
  ylm_vf a[3], b[3], cs, sn, sum = zero, per = 1 / s->directions;
  basis(axis, a, b);
  turn(v0, &cs, &sn);
  for (int i = 0; i < count; i++) {
    ylm_vf u = u0 + ((float)i + 0.5f) * per, d[3];
    u = ylm_vf_select(u >= 1, u - 1, u);
    ylm_vf z = way == VSL_CONE ? 1 - u * s->part : ylm_vf_sqrt(most(zero, 1 - u));
    ylm_vf r = ylm_vf_sqrt(most(zero, 1 - z * z));
    for (int k = 0; k < 3; k++) d[k] = sign * (r * (cs * a[k] + sn * b[k]) + z * axis[k]);
    ylm_vf up = most(zero, dot(s->N, d)), along = -dot(s->n, d), out = most(zero, s->shift + along);
    ylm_vf p = alone ? up * 0.318309886f + 1e-20f
                     : s->over_cone +
                           ylm_vf_select(s->wide, (up + most(zero, along)) * 0.318309886f, zero);
    ylm_vi counts = on & ((zero + (float)i) < s->directions);
    if (way != VSL_CONE) counts &= dot(s->w, d) >= s->edge;
    sum += ylm_vf_select(counts, up * out / p, zero);
    ylm_vf next = cs * -0.73736888f - sn * -0.67549029f;
    sn = cs * -0.67549029f + sn * -0.73736888f, cs = next;
  }
  return sum;
}

YLM_INLINE bool any(ylm_vi x) {
  int32_t all = 0;
  for (int i = 0; i < YLM_VF; i++) all |= x[i];
  return all != 0;
}

void YLM_KERNEL(ylm_k_many_spheres)(const ylm_many_lights *l, const ylm_many_ask *a, size_t first,
                                    size_t n, const float x[3], const float N[3],
                                    const uint32_t seed[2], const float *keep, float *w) {
  const ylm_vf zero = {0}, one = zero + 1;
  const ylm_shade_sphere_strategy strategy = a->o->strategy;
  const float samples = (float)a->o->samples;
  for (size_t k = 0; k < n; k += YLM_VF) {
    size_t i = first + k;
    sphere s = {.N = {zero + N[0], zero + N[1], zero + N[2]}, .shift = ylm_vf_load(l->shift + i)};
    ylm_vf r = ylm_vf_load(l->radius + i), d2 = zero, sum = zero;
    for (int c = 0; c < 3; c++) {
      s.w[c] = ylm_vf_load(l->at[c] + i) - x[c];
      s.n[c] = ylm_vf_load(l->normal[c] + i);
      d2 += s.w[c] * s.w[c];
    }
    ylm_vf d = ylm_vf_sqrt(most(d2, one * 1e-30f)), sine = r / d;
    for (int c = 0; c < 3; c++) s.w[c] /= d;
    ylm_vf sine2 = ylm_vf_select(d > r, sine * sine, one);
    s.part = sine2 / (1 + ylm_vf_sqrt(most(zero, 1 - sine2)));
    s.edge = 1 - s.part;
    s.over_cone = 1 / (2 * (float)YLM_PI * s.part);
    s.on = (d2 > 0) & ((d <= r) | (dot(s.w, s.N) >= -sine));
    s.on &= (d <= r) | (s.shift > 0) | (-dot(s.w, s.n) >= -sine);
    for (int q = 0; q < YLM_VF; q++) {
      size_t at = k + (size_t)q;
      s.on[q] = at < n && first + at < l->n && (!keep || keep[at] > 0) ? s.on[q] : 0;
    }
    if (!any(s.on)) {
      ylm_vf_store(w + k, zero);
      continue;
    }
    ylm_vf wanted =
        strategy == YLM_SHADE_RECEIVER ? one * samples : most(one * 4, samples * s.part);
    int count = 0;
    for (int q = 0; q < YLM_VF; q++) {
      int many = s.on[q] ? (int)ceilf(wanted[q]) : 4;
      s.directions[q] = (float)many;
      count = s.on[q] && many > count ? many : count;
    }
    s.wide = strategy == YLM_SHADE_MIS ? s.part >= VSL_SMALL : s.on & 0;
    ylm_vf u = numbers(seed[0], VSL_STEP_U, i), v = numbers(seed[1], VSL_STEP_V, i);
    if (strategy == YLM_SHADE_RECEIVER)
      sum = sum_of(&s, VSL_RECEIVER, true, count, u, v, s.on);
    else
      sum = sum_of(&s, VSL_CONE, false, count, u, v, s.on);
    ylm_vi wide = s.on & s.wide;
    if (any(wide)) {
      ylm_vi turned = wide & ((s.n[0] != 0) | (s.n[1] != 0) | (s.n[2] != 0));
      sum += sum_of(&s, VSL_RECEIVER, false, count, v, u, wide);
      sum += sum_of(&s, VSL_LIGHT, false, count, u, 1 - v, turned);
    }
    if (keep) sum *= ylm_vf_load(keep + k);
    ylm_vf_store(w + k, sum / (s.directions * (float)YLM_PI * most(r * r, one * 1e-30f)));
  }
}
