/*
** Spherical harmonics at points, any degree: the recurrences of csrc/sh/sh_kernel.h, which says what
** the coefficients are. One item a point, which keeps nothing but what it writes: lower degrees are read
** back from the results, and D of degree l waits in the values of degree l + 1.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(constant_id = 1) const uint ORDER = 2; /* of derivatives */
layout(constant_id = 2) const bool SOLID = false;

layout(set = 0, binding = 0) readonly buffer Points { real point[]; };  /* [n][3] */
layout(set = 0, binding = 1) buffer Values { real value[]; };           /* [n][count] */
layout(set = 0, binding = 2) buffer Gradients { real gradient[]; };     /* [n][count][3] */
layout(set = 0, binding = 3) writeonly buffer Hessians { real hessian[]; }; /* [n][count][6] */
layout(set = 0, binding = 4) readonly buffer Table { real table[]; };   /* a b e A B b' c' by l, q */
PUSH {
  uint first;
  uint n, lmax;
};

#include "unit.glsl"

uint at;      /* of this point's results */
rvec3 w;      /* the unit vector (solid: the vector) */
real inverse; /* 1 / |v| (solid: 1) */

/* Where degree l, order m is. */
uint place(int l, int m) { return at + uint(l * (l + 1) + m); }

/* The value over |v| of degree l, order m; 0 beyond the degree. */
real p(int l, int m) { return abs(m) <= l ? value[place(l, m)] * inverse : REAL(0); }

/* The same with sines at order q > 0 only: s(l, 0) = 0. */
real ps(int l, int q) { return q > 0 ? p(l, -q) : REAL(0); }

/* The solid harmonic's gradient over |v|, from that of Y. */
rvec3 climb_gradient(int l, int m) {
  if (abs(m) > l || l < 0) return rvec3(0);
  uint k = 3 * place(l, m);
  rvec3 g = rvec3(gradient[k], gradient[k + 1], gradient[k + 2]);
  return SOLID ? g : (g + real(l) * p(l, m) * w) * inverse;
}

rvec3 sine_gradient(int l, int q) { return q > 0 ? climb_gradient(l, -q) : rvec3(0); }

/* Values of degree l; D is 0 where q = l. */
void values(int l, uint k, real sign_z, real o, real r2) {
  for (int q = 0; q < l; q++, k += 7) {
    for (int m = q; m >= -q; m -= max(2 * q, 1)) {
      real f = value[place(l - 1, m)];
      if (SOLID)
        value[place(l, m)] = table[k] * w.z * f - (l - 2 >= q ? table[k + 1] * r2 * value[place(l - 2, m)] : REAL(0));
      else {
        real d = sign_z * table[k + 5] * (q < l - 1 ? value[place(l, m)] : REAL(0)) - table[k] * o * f;
        value[place(l, m)] = sign_z * table[k + 6] * f + d;
        if (l < int(lmax)) value[place(l + 1, m)] = d;
      }
    }
  }
  real c = value[place(l - 1, l - 1)], s = l > 1 ? value[place(l - 1, 1 - l)] : REAL(0);
  value[place(l, l)] = table[k] * (w.x * c - w.y * s);
  value[place(l, -l)] = table[k] * (w.x * s + w.y * c);
}

/* Writes the derivatives of Y of degree l, order m from those of the solid harmonic. */
void finish(int l, int m, rvec3 g, real hxx, real hxy, real hxz, real hyz, real hzz) {
  uint k = place(l, m);
  real t = SOLID ? REAL(0) : real(l) * p(l, m);
  rvec3 dy = g - t * w;
  for (int c = 0; c < 3; c++) gradient[3 * k + c] = dy[c];
  if (ORDER < 2) return;
  k *= 6;
  if (SOLID) {
    hessian[k] = hxx, hessian[k + 1] = hxy, hessian[k + 2] = hxz;
    hessian[k + 3] = -hxx - hzz, hessian[k + 4] = hyz, hessian[k + 5] = hzz;
    return;
  }
  rvec3 u = dy + (real(l - 2) / real(2 * l)) * t * w, lwd = real(l) * inverse * w;
  real t2 = t * inverse, xx = hxx - t2 - 2 * u.x * lwd.x, zz = hzz - t2 - 2 * u.z * lwd.z;
  hessian[k] = xx;
  hessian[k + 1] = hxy - u.x * lwd.y - u.y * lwd.x;
  hessian[k + 2] = hxz - u.x * lwd.z - u.z * lwd.x;
  hessian[k + 3] = -real(l + 1) * t2 - xx - zz;
  hessian[k + 4] = hyz - u.y * lwd.z - u.z * lwd.y;
  hessian[k + 5] = zz;
}

/* Derivatives of degree l >= 1 from degree l-1, by the ladder. */
void derivatives(int l, uint k) {
  int b = l - 1;
  for (int q = 0; q <= l; q++, k += 7) {
    real e = table[k + 2], A = q > 0 ? table[k + 3] : REAL(0), B = table[k + 4];
    rvec3 low = rvec3(0), lows = rvec3(0), up = rvec3(0), ups = rvec3(0), same = rvec3(0), sames = rvec3(0);
    if (ORDER > 1) {
      if (q > 0) low = climb_gradient(b, q - 1), lows = sine_gradient(b, q - 1);
      up = climb_gradient(b, q + 1), ups = sine_gradient(b, q + 1);
      same = climb_gradient(b, q), sames = sine_gradient(b, q);
    }
    real pl = q > 0 ? p(b, q - 1) : REAL(0), pls = ps(b, q - 1), pu = p(b, q + 1), pus = ps(b, q + 1);
    rvec3 x = A * low + B * up, y = B * ups - A * lows;
    finish(l, q, rvec3(A * pl + B * pu, B * pus - A * pls, e * p(b, q)), x.x, x.y, e * same.x, e * same.y,
           e * same.z);
    if (q == 0) continue;
    x = A * lows + B * ups;
    finish(l, -q, rvec3(A * pls + B * pus, A * pl - B * pu, e * ps(b, q)), x.x, x.y, e * sames.x,
           e * sames.y, e * sames.z);
  }
}

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  at = i * (lmax + 1) * (lmax + 1);
  w = rvec3(point[3 * i], point[3 * i + 1], point[3 * i + 2]);
  real sign_z = 1, o = 0, r2 = 0;
  inverse = 1;
  if (SOLID)
    r2 = dot(w, w);
  else {
    inverse = ylm_unit(w);
    ylm_pole(w, sign_z, o);
    o *= sign_z;
  }
  value[at] = REAL(0.28209479177387814347lf);
  for (int c = 0; ORDER > 0 && c < 3; c++) gradient[3 * at + c] = 0;
  for (int c = 0; ORDER > 1 && c < 6; c++) hessian[6 * at + c] = 0;
  uint k = 0;
  for (int l = 1; l <= int(lmax); k += 7 * (l + 1), l++) {
    values(l, k, sign_z, o, r2);
    if (ORDER > 0) derivatives(l, k);
  }
}
