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
rvec4 factor; /* flat lights: |cos gamma|, its gradient and Hessian */
rmat2x3 bent;
#define STORE(number, sum) partial[store_at + (number) * stride] = sum
#define ADD(n)                                                                                     \
  if (FLAT) {                                                                                      \
    v##n += factor.x * p0;                                                                         \
    x##n += factor.x * p1 + factor.y * p0;                                                         \
    y##n += factor.x * p2 + factor.z * p0;                                                         \
    z##n += factor.x * p3 + factor.w * p0;                                                         \
    xx##n += factor.x * p4 + REAL(2.0lf) * factor.y * p1 + bent[0].x * p0;                         \
    xy##n += factor.x * p5 + factor.z * p1 + factor.y * p2 + bent[0].y * p0;                       \
    xz##n += factor.x * p6 + factor.w * p1 + factor.y * p3 + bent[0].z * p0;                       \
    yy##n += factor.x * p7 + REAL(2.0lf) * factor.z * p2 + bent[1].x * p0;                         \
    yz##n += factor.x * p8 + factor.w * p2 + factor.z * p3 + bent[1].y * p0;                       \
    zz##n += factor.x * p9 + REAL(2.0lf) * factor.w * p3 + bent[1].z * p0;                         \
  } else {                                                                                         \
    v##n += p0, x##n += p1, y##n += p2, z##n += p3, xx##n += p4;                                   \
    xy##n += p5, xz##n += p6, yy##n += p7, yz##n += p8, zz##n += p9;                               \
  }
#include "gen/product.glsl"

bool add(rvec3 at, rvec4 a, rvec4 b, rvec3 normal) {
  const real one = REAL(1.0lf), zero = REAL(0.0lf);
  rvec3 v = a.xyz - at;
  real d2 = dot(v, v), h2 = difference(d2, a.w, b.x);
  bool outside = h2 > zero;
  real id = outside ? inverse_root(d2) : zero, invh = outside ? inverse_root(h2) : zero;
  real alpha = h2 * invh * id, t = b.y * id, s2 = t * t, es = s2 * b.w;
  real slope = es * invh, d = d2 * id;
  v *= id;
  if (FLAT) factor = cosine(normal, b.z, v, id, bent);
  add_light(v.x, v.y, v.z, id, alpha, s2 * invh, es, outside ? es / (one + alpha) : REAL(2.0lf) * b.w, slope,
            slope * (REAL(2.0lf) * id + d * invh * invh));
  return outside;
}

#include "lamps_main.glsl"
