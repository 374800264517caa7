/* spheres.isa.c - rays to spheres, once per instruction set. spheres.c has the plain form. */
#include "ylm_simd.h"

#include "tree.h"

ylm_scene_spheres_fn YLM_KERNEL(ylm_k_scene_spheres);

YLM_INLINE ylm_vf most(ylm_vf a, ylm_vf b) { return ylm_vf_select(a > b, a, b); }

/* Cosine and sine of 2 pi u, for u of 0 .. 1, by their series within an eighth of a turn. */
YLM_INLINE void turn(ylm_vf u, ylm_vf *cosine, ylm_vf *sine) {
  ylm_vi quarter = __builtin_convertvector(4 * u + 0.5f, ylm_vi);
  ylm_vf t = (4 * u - __builtin_convertvector(quarter, ylm_vf)) * ((float)YLM_PI / 2), t2 = t * t;
  ylm_vf s =
      t * (1 + t2 * (-1 / 6.f + t2 * (1 / 120.f + t2 * (-1 / 5040.f + t2 * (1 / 362880.f)))));
  ylm_vf c = 1 + t2 * (-1 / 2.f + t2 * (1 / 24.f + t2 * (-1 / 720.f + t2 * (1 / 40320.f))));
  ylm_vi odd = (quarter & 1) != 0;
  ylm_vf x = ylm_vf_select(odd, s, c), y = ylm_vf_select(odd, c, s);
  *cosine = ylm_vf_select(((quarter + 1) & 2) != 0, -x, x);
  *sine = ylm_vf_select((quarter & 2) != 0, -y, y);
}

/* Directions about the axis: cosine 1 - q. Source of the frame: Duff et al. 2017. */
YLM_INLINE void about(const ylm_vf axis[3], ylm_vf q, ylm_vf u, ylm_vf out[3]) {
  const ylm_vf zero = {0};
  ylm_vf x = axis[0], y = axis[1], z = axis[2], s = ylm_vf_select(z < zero, zero - 1, zero + 1);
  ylm_vf p = -1 / (s + z), w = x * y * p, c, d, r = ylm_vf_sqrt(most(q * (2 - q), zero));
  turn(u, &c, &d);
  c *= r;
  d *= r;
  out[0] = c * (1 + s * x * x * p) + d * w + (1 - q) * x;
  out[1] = c * (s * w) + d * (s + y * y * p) + (1 - q) * y;
  out[2] = -(c * s * x) - d * y + (1 - q) * z;
}

YLM_INLINE void aim(const float normal[3], size_t i, scene_spheres *a) {
  const ylm_vf zero = {0};
  ylm_vf v[3], axis[3], dir[3], r = ylm_vf_load(a->radius + i), r2 = r * r, d2 = zero;
  for (int k = 0; k < 3; k++) v[k] = ylm_vf_load(a->v[k] + i), d2 += v[k] * v[k];
  ylm_vi outside = d2 > r2;
  ylm_vf safe2 = ylm_vf_select(outside, d2, zero + 1), d = ylm_vf_sqrt(safe2), inverse = 1 / d;
  ylm_vf s2 = ylm_vf_select(outside, r2, zero) * inverse * inverse;
  ylm_vf cap = s2 / (1 + ylm_vf_sqrt(most(1 - s2, zero))), q = ylm_vf_load(a->u[0] + i) * cap;
  for (int k = 0; k < 3; k++) axis[k] = v[k] * inverse;
  about(axis, q, ylm_vf_load(a->u[1] + i), dir);
  ylm_vf far = d * (1 - q) - ylm_vf_sqrt(most(r2 - safe2 * (q * (2 - q)), zero));
  ylm_vf cosine = most(dir[0] * normal[0] + dir[1] * normal[1] + dir[2] * normal[2], zero);
  for (int k = 0; k < 3; k++) ylm_vf_store(a->dir[k] + i, dir[k]);
  ylm_vf_store(a->far + i, far);
  ylm_vf_store(a->value + i, ylm_vf_select(outside, cosine * (2 * (float)YLM_PI) * cap, zero - 1));
}

void YLM_KERNEL(ylm_k_scene_spheres)(size_t n, const float normal[3], scene_spheres *a) {
  for (size_t i = 0; i < n; i += YLM_VF) aim(normal, i, a);
}
