/* merl_places.isa.c - places of directions among MERL's bins, once per instruction set. merl.c has the
   plain form. */
#include "ylm_simd.h"

#include "merl.h"

merl_places_fn YLM_KERNEL(ylm_k_merl_places);

YLM_INLINE ylm_vf larger(ylm_vf a, ylm_vf b) { return ylm_vf_select(a > b, a, b); }
YLM_INLINE ylm_vf smaller(ylm_vf a, ylm_vf b) { return ylm_vf_select(a < b, a, b); }

/* The angle of (x, y) with y >= 0 and x >= 0, to 1e-7 (Abramowitz & Stegun 1964, 4.4.49); 0 where both
   are 0. */
YLM_INLINE ylm_vf quarter(ylm_vf y, ylm_vf x) {
  const ylm_vf tiny = ylm_vf_set(1e-37f);
  ylm_vf t = smaller(x, y) / larger(larger(x, y), tiny), q = t * t;
  ylm_vf p = ylm_vf_set(0.0028662257f);
  p = p * q - 0.0161657367f;
  p = p * q + 0.0429096138f;
  p = p * q - 0.0752896400f;
  p = p * q + 0.1065626393f;
  p = p * q - 0.1420889944f;
  p = p * q + 0.1999355085f;
  p = p * q - 0.3333314528f;
  p = p * q * t + t;
  return ylm_vf_select(y > x, (float)YLM_PI / 2 - p, p);
}

void YLM_KERNEL(ylm_k_merl_places)(int phis, size_t n, const float (*wi)[3], const float (*wo)[3],
                                   merl_places *out) {
  float in[6][MERL_BLOCK];
  size_t whole = (n + YLM_VF - 1) / YLM_VF * YLM_VF;
  for (size_t k = 0; k < whole; k++)
    for (int a = 0; a < 3; a++) {
      in[a][k] = wi[k < n ? k : 0][a];
      in[3 + a][k] = wo[k < n ? k : 0][a];
    }
  const ylm_vf zero = {0};
  for (size_t k = 0; k < whole; k += YLM_VF) {
    ylm_vf ix = ylm_vf_load(in[0] + k), iy = ylm_vf_load(in[1] + k), iz = ylm_vf_load(in[2] + k);
    ylm_vf ox = ylm_vf_load(in[3] + k), oy = ylm_vf_load(in[4] + k), oz = ylm_vf_load(in[5] + k);
    ylm_vf hx = ix + ox, hy = iy + oy, hz = iz + oz, vx = ix - ox, vy = iy - oy, vz = iz - oz;
    ylm_vf flat2 = hx * hx + hy * hy, h = ylm_vf_sqrt(flat2 + hz * hz);
    ylm_vf v = ylm_vf_sqrt(vx * vx + vy * vy + vz * vz);
    ylm_vf theta_h = quarter(ylm_vf_sqrt(flat2), hz), theta_d = quarter(v, h);
    ylm_vi pole = flat2 == zero;
    ylm_vf y = ylm_vf_select(pole, vy, vy * hx - vx * hy), x = ylm_vf_select(pole, vx, -(vz * h));
    ylm_vf phi = quarter(ylm_vf_select(y < zero, -y, y), ylm_vf_select(x < zero, -x, x));
    phi = ylm_vf_select(x < zero, (float)YLM_PI - phi, phi);
    ylm_vf turn = ylm_vf_set(phis == MERL_PHI_D ? (float)YLM_PI : 2 * (float)YLM_PI);
    phi = ylm_vf_select(y < zero, turn - phi, phi);
    ylm_vf_store(out->theta_h + k, MERL_THETA_H * ylm_vf_sqrt(theta_h * (2 / (float)YLM_PI)));
    ylm_vf_store(out->theta_d + k, theta_d * (MERL_THETA_D * 2 / (float)YLM_PI));
    ylm_vf_store(out->phi_d + k, phi * (MERL_PHI_D / (float)YLM_PI));
  }
}
