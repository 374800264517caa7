/* moments_add.glsl - a light's merged moments, after weigh(direction, 1/d, normal, plain) has had a look at it. */
bool add(rvec3 at, rvec4 a, rvec4 b, rvec3 normal) {
  rvec3 v = a.xyz - at;
  real d2 = dot(v, v);
  Light l = seen(d2, difference(d2, a.w, b.x), b.y, b.w);
  v *= l.invd;
  weigh(v, l.invd, normal, b.z);
  add_light(v.x, v.y, v.z, l.delta, l.es, l.invh, l.far, l.first);
  return l.outside;
}
