/* moments_add.glsl - a light's merged moments, after weigh(direction, 1/d, normal, plain) has had a look at it. */
bool add(rvec3 at, rvec4 a, rvec4 b, rvec3 normal) {
  rvec3 v = a.xyz - at;
  real d2 = dot(v, v), h2 = difference(d2, a.w, b.x);
  bool outside = h2 > REAL(0.0lf);
  real invd = outside ? inverse_root(d2) : REAL(0.0lf), invh = inverse_root(outside ? h2 : REAL(1.0lf));
  real t = b.y * invd, s2 = t * t, es = s2 * b.w, once = REAL(1.0lf) / (REAL(1.0lf) + h2 * invh * invd);
  v *= invd;
  weigh(v, invd, normal, b.z);
  add_light(v.x, v.y, v.z, s2 * once, es, invh, d2 * invd * invh * invh * invh,
            outside ? es * once : REAL(2.0lf) * b.w);
  return outside;
}
