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
real factor[10]; /* flat lights: |cos gamma|, its gradient and Hessian */
#define STORE(number, sum) partial[store_at + (number) * stride] = sum
#define ADD(n)                                                                                     \
  {                                                                                                \
    real part[10] = real[10](p0, p1, p2, p3, p4, p5, p6, p7, p8, p9), made[10] = part;              \
    if (FLAT) jet_times(factor, part, made);                                                       \
    v##n += made[0], x##n += made[1], y##n += made[2], z##n += made[3], xx##n += made[4];          \
    xy##n += made[5], xz##n += made[6], yy##n += made[7], yz##n += made[8], zz##n += made[9];      \
  }
#include "gen/product.glsl"

bool add(rvec3 at, rvec4 a, rvec4 b, rvec3 normal) {
  rvec3 v = a.xyz - at;
  real d2 = dot(v, v);
  Light l = seen(d2, difference(d2, a.w, b.x), b.y, b.w);
  real slope = l.es * l.invh;
  v *= l.invd;
  if (FLAT) cosine(normal, b.z, v, l.invd, factor);
  add_light(v.x, v.y, v.z, l.invd, l.alpha, l.s2 * l.invh, l.es, l.first, slope,
            slope * (REAL(2.0lf) * l.invd + d2 * l.invd * l.invh * l.invh));
  return l.outside;
}

#include "lamps_main.glsl"
