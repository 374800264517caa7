/*
** Spherical harmonics at points, any degree: the loops around gen/recurrence.glsl; csrc/sh/eval/sh_kernel.h says what
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

/* Cosine and sine of degree l, order q. */
rvec2 pair(int l, int q) { return rvec2(value[place(l, q)], q > 0 ? value[place(l, -q)] : REAL(0)); }

/* The value over |v| of degree l, order m; 0 beyond the degree. */
real p(int l, int m) { return abs(m) <= l ? value[place(l, m)] * inverse : REAL(0); }

/* p of the sine of order q > 0; s(l, 0) = 0. */
real ps(int l, int q) { return q > 0 ? p(l, -q) : REAL(0); }

/* The solid harmonic's gradient over |v|, from that of Y. */
rvec3 climb_gradient(int l, int m) {
  if (abs(m) > l || l < 0) return rvec3(0);
  uint k = 3 * place(l, m);
  rvec3 g = rvec3(gradient[k], gradient[k + 1], gradient[k + 2]);
  return SOLID ? g : (g + real(l) * p(l, m) * w) * inverse;
}

rvec3 sine_gradient(int l, int q) { return q > 0 ? climb_gradient(l, -q) : rvec3(0); }

/* Writes the cosine and, where q > 0, the sine of degree l, order q. */
void put(int l, int q, real c, real s) {
  value[place(l, q)] = c;
  if (q > 0) value[place(l, -q)] = s;
}

/* Values of degree l; D is 0 where q = l. */
void values(int l, uint k, real sign_z, real o, real r2) {
  real c, s, dc, ds;
  for (int q = 0; q < l; q++, k += 7) {
    rvec2 f = pair(l - 1, q);
    if (SOLID) {
      rvec2 b = l - 2 >= q ? pair(l - 2, q) : rvec2(0);
      sh_solid(table[k], table[k + 1], w.z, r2, f.x, f.y, b.x, b.y, c, s);
    } else {
      rvec2 d = q < l - 1 ? pair(l, q) : rvec2(0);
      sh_stable(table[k], table[k + 5], table[k + 6], sign_z, o, f.x, f.y, d.x, d.y, c, s, dc, ds);
      if (l < int(lmax)) put(l + 1, q, dc, ds);
    }
    put(l, q, c, s);
  }
  rvec2 f = pair(l - 1, l - 1);
  sh_turn(table[k], w.x, w.y, f.x, f.y, c, s);
  put(l, l, c, s);
}

/* Writes the derivatives of Y of degree l, order m from those of the solid harmonic. */
void finish(int l, int m, rvec3 g, real h[6]) {
  uint k = place(l, m);
  rvec3 dy = g;
  if (!SOLID) sh_surface(real(l), p(l, m), w, g, dy);
  for (int c = 0; c < 3; c++) gradient[3 * k + c] = dy[c];
  if (ORDER < 2) return;
  real own[6] = h;
  if (SOLID)
    own[3] = sh_yy(h[0], h[5]);
  else
    sh_surface_twice(real(l), inverse, p(l, m), w, real(l) * inverse * w, dy, h, own);
  for (int c = 0; c < 6; c++) hessian[6 * k + c] = own[c];
}

/* Derivatives of degree l >= 1 from degree l-1, by the ladder. */
void derivatives(int l, uint k) {
  int b = l - 1;
  rvec3 g;
  real h[6] = real[6](0, 0, 0, 0, 0, 0), e = table[k + 2], B = table[k + 4];
  sh_gradient_zero(e, B, p(b, 0), p(b, 1), ps(b, 1), g);
  if (ORDER > 1) sh_hessian_zero(e, B, climb_gradient(b, 1), climb_gradient(b, 0), h);
  finish(l, 0, g, h);
  for (int q = 1; q <= l; q++) {
    k += 7;
    e = table[k + 2], B = table[k + 4];
    real A = table[k + 3], cl = p(b, q - 1), sl = ps(b, q - 1), cu = p(b, q + 1), su = ps(b, q + 1);
    sh_gradient_cosine(e, A, B, p(b, q), cl, sl, cu, su, g);
    if (ORDER > 1) sh_hessian(e, A, B, climb_gradient(b, q - 1), climb_gradient(b, q + 1), climb_gradient(b, q), h);
    finish(l, q, g, h);
    sh_gradient_sine(e, A, B, ps(b, q), cl, sl, cu, su, g);
    if (ORDER > 1) sh_hessian(e, A, B, sine_gradient(b, q - 1), sine_gradient(b, q + 1), sine_gradient(b, q), h);
    finish(l, -q, g, h);
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
