/* unit.glsl - directions. */
#include "gen/recurrence.glsl"

/* Makes v a unit vector and returns 1 / |v|, without overflow. */
real ylm_unit(inout rvec3 v) {
  real m = max(max(abs(v.x), abs(v.y)), abs(v.z));
  v /= m;
  real r = inversesqrt(dot(v, v));
  v *= r;
  return r / m;
}

/* The sign of a unit vector's z and 1 - |z|, exact also near the poles. */
void ylm_pole(rvec3 v, out real g, out real o) {
  g = v.z < 0 ? REAL(-1) : REAL(1);
  o = sh_one_minus(g, v.x, v.y, v.z);
}
