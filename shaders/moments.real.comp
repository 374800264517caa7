/* moments.real.comp - the merged moments of DESIGN section 4: csrc/light/moments.h. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

#include "lamps.glsl"
layout(constant_id = 2) const uint KINDS = 1;

uint store_at;
#define STORE(number, sum) partial[store_at + (number) * stride] = sum
#include "gen/moments.glsl"

bool add(rvec3 at, rvec4 a, rvec4 b) {
  rvec3 v = a.xyz - at;
  real d2 = dot(v, v), h2 = difference(d2, a.w, b.x);
  bool outside = h2 > REAL(0.0lf);
  real invd = outside ? inverse_root(d2) : REAL(0.0lf), invh = inverse_root(outside ? h2 : REAL(1.0lf));
  real t = b.y * invd, s2 = t * t, es = s2 * b.w, once = REAL(1.0lf) / (REAL(1.0lf) + h2 * invh * invd);
  v *= invd;
  add_light(v.x, v.y, v.z, s2 * once, es, invh, d2 * invd * invh * invh * invh,
            outside ? es * once : REAL(2.0lf) * b.w);
  return outside;
}

#include "lamps_main.glsl"
