/*
** product.real.comp - the sums of the papers, light by light with the product rule, to compare with.
**
** Forward: one dispatch with all orders m. Reversed: one for each, so that fewer sums are kept
** in registers and what does not depend on m is computed again (Mezieres et al. 2022, Sec. 5.1).
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

#include "lamps.glsl"
layout(constant_id = 2) const uint DERIVATIVES = 0;

uint store_at;
#define STORE(number, sum) partial[store_at + (number) * stride] = sum
#include "gen/product.glsl"

bool add(rvec3 at, rvec4 a, rvec4 b) {
  const real one = REAL(1.0lf), zero = REAL(0.0lf);
  rvec3 v = a.xyz - at;
  real d2 = dot(v, v), h2 = difference(d2, a.w, b.x);
  bool outside = h2 > zero;
  real id = outside ? inverse_root(d2) : zero, invh = outside ? inverse_root(h2) : zero;
  real alpha = h2 * invh * id, t = b.y * id, s2 = t * t, es = s2 * b.w;
  real slope = es * invh, d = d2 * id;
  v *= id;
  add_light(v.x, v.y, v.z, id, alpha, s2 * invh, es, outside ? es / (one + alpha) : REAL(2.0lf) * b.w, slope,
            slope * (REAL(2.0lf) * id + d * invh * invh));
  return outside;
}

#include "lamps_main.glsl"
