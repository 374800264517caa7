/* rotate_matrix.c - 3x3 rotations: checked, made exact, made from quaternions, axes and angles. */
#include "ylm_sh.h"

#include <math.h>
#include <string.h>

#include "rotate.h"
#include "ylm_vector.h"

static double determinant(const double r[9]) {
  return r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
         r[2] * (r[3] * r[7] - r[4] * r[6]);
}

/* R^T R - I as its six numbers xx xy xz yy yz zz; returns the largest. */
static double departure(const double r[9], double d[6]) {
  double worst = 0;
  for (int i = 0, k = 0; i < 3; i++)
    for (int j = i; j < 3; j++, k++) {
      d[k] = r[i] * r[j] + r[3 + i] * r[3 + j] + r[6 + i] * r[6 + j] - (i == j);
      if (!(fabs(d[k]) <= worst)) worst = fabs(d[k]);
    }
  return worst;
}

/* Is r one of the cube's 24 rotations to twice the rounding of 1? Then *out is that one. Products
   of sines and cosines of quarter turns, axes along diagonals and unit quaternions are no further
   off. */
static bool snap(const double r[9], double out[9]) {
  double m[9], d[6];
  for (int i = 0; i < 9; i++) {
    m[i] = fabs(r[i]) <= 4.5e-16 ? 0 : r[i] < 0 ? -1 : 1;
    if (!(fabs(r[i] - m[i]) <= 4.5e-16)) return false;
  }
  if (departure(m, d) != 0 || determinant(m) != 1) return false;
  memcpy(out, m, sizeof m);
  return true;
}

void ylm__sh_orthonormal(double m[9]) {
  double d[6], worst = departure(m, d);
  /* R (I - (R^T R - I)/2): the departure is squared each time */
  for (int pass = 0; pass < 3 && worst > 1e-15; pass++) {
    double q[9] = {1 - d[0] / 2, -d[1] / 2, -d[2] / 2, -d[1] / 2,   1 - d[3] / 2,
                   -d[4] / 2,    -d[2] / 2, -d[4] / 2, 1 - d[5] / 2},
           t[9];
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        t[i * 3 + j] = m[i * 3] * q[j] + m[i * 3 + 1] * q[3 + j] + m[i * 3 + 2] * q[6 + j];
    memcpy(m, t, sizeof t);
    worst = departure(m, d);
  }
}

bool ylm__sh_is_rotation(const double r[9], double within) {
  double d[6];
  for (int i = 0; i < 9; i++)
    if (!isfinite(r[i])) return false;
  return departure(r, d) <= within && determinant(r) > 0;
}

ylm_status ylm_sh_rotation_check(const double r[9], double out[9], ylm_error *e) {
  if (snap(r, out)) return YLM_OK;
  double d[6], m[9], worst = departure(r, d);
  if (!(worst < 1e-5)) {
    for (int i = 0; i < 9; i++)
      if (!isfinite(r[i]))
        return ylm_fail(e, YLM_EDOMAIN,
                        "3x3 rotation expected, it holds a number that is not finite");
    return ylm_fail(e, YLM_EDOMAIN,
                    "3x3 rotation expected, columns are not orthonormal (off by %.3g)", worst);
  }
  double det = determinant(r);
  if (det < 0) return ylm_fail(e, YLM_EDOMAIN, "3x3 rotation expected, determinant is %.6g", det);
  memcpy(m, r, sizeof m);
  ylm__sh_orthonormal(m);
  memcpy(out, m, sizeof m);
  return YLM_OK;
}

ylm_status ylm_sh_rotation_from_quaternion(const double q[4], double r[9], ylm_error *e) {
  double scale = 0;
  for (int i = 0; i < 4; i++) scale = fmax(scale, fabs(q[i]));
  if (!(scale > 0) || !isfinite(scale) || q[0] != q[0] || q[1] != q[1] || q[2] != q[2] ||
      q[3] != q[3])
    return ylm_fail(e, YLM_EDOMAIN,
                    "a quaternion {w, x, y, z} of finite numbers, not all zero, expected");
  double w = q[0] / scale, x = q[1] / scale, y = q[2] / scale, z = q[3] / scale;
  double n = 2 / (w * w + x * x + y * y + z * z);
  double m[9] = {1 - n * (y * y + z * z), n * (x * y - w * z),     n * (x * z + w * y),
                 n * (x * y + w * z),     1 - n * (x * x + z * z), n * (y * z - w * x),
                 n * (x * z - w * y),     n * (y * z + w * x),     1 - n * (x * x + y * y)};
  memcpy(r, m, sizeof m);
  return YLM_OK;
}

/* Cosine and sine, exact at whole quarter turns as near as a double can name them. */
static void cosine_sine(double angle, double *c, double *s) {
  double quarters = angle / 1.57079632679489661923;
  double whole = nearbyint(quarters);
  if (fabs(whole) < 1e6 && fabs(quarters - whole) <= 4e-16 * fmax(1, fabs(whole))) {
    int k = (int)whole & 3;
    *c = k == 0 ? 1 : k == 2 ? -1 : 0;
    *s = k == 1 ? 1 : k == 3 ? -1 : 0;
    return;
  }
  *c = cos(angle);
  *s = sin(angle);
}

ylm_status ylm_sh_rotation_from_axis(const double axis[3], double angle, double r[9],
                                     ylm_error *e) {
  double u[3] = {axis[0], axis[1], axis[2]};
  if (!ylm_unit3(u) || !isfinite(angle))
    return ylm_fail(e, YLM_EDOMAIN,
                    "an axis {x, y, z} that is not zero and a finite angle expected");
  double x = u[0], y = u[1], z = u[2], c, s;
  cosine_sine(angle, &c, &s);
  double t = 1 - c;
  double m[9] = {t * x * x + c,     t * x * y - s * z, t * x * z + s * y,
                 t * x * y + s * z, t * y * y + c,     t * y * z - s * x,
                 t * x * z - s * y, t * y * z + s * x, t * z * z + c};
  memcpy(r, m, sizeof m);
  return YLM_OK;
}

ylm_status ylm_sh_rotation_from_zyz(const double abc[3], double r[9], ylm_error *e) {
  if (!isfinite(abc[0]) || !isfinite(abc[1]) || !isfinite(abc[2]))
    return ylm_fail(e, YLM_EDOMAIN, "three finite angles expected");
  double ca, sa, cb, sb, cc, sc;
  cosine_sine(abc[0], &ca, &sa);
  cosine_sine(abc[1], &cb, &sb);
  cosine_sine(abc[2], &cc, &sc);
  double m[9] = {ca * cb * cc - sa * sc,
                 -ca * cb * sc - sa * cc,
                 ca * sb,
                 sa * cb * cc + ca * sc,
                 -sa * cb * sc + ca * cc,
                 sa * sb,
                 -sb * cc,
                 sb * sc,
                 cb};
  memcpy(r, m, sizeof m);
  return YLM_OK;
}
