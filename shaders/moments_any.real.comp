/*
** moments_any.real.comp - the merged moments of every lmax: loops, where moments and flat have the generator's unrolled
** formulas to lmax 10. A group sums one item: at most BLOCK degrees of the cosine's and the sine's column of one order m,
** times 1 or a component of a flat light's cosine's jet. Sums exist as csrc/light/moments/moments.h says of such lmax.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "ylm.glsl"

#include "lamps.glsl"
layout(constant_id = 2) const uint KINDS = 1;
layout(constant_id = 6) const uint BLOCK = 8;
layout(constant_id = 7) const uint GROW = 1; /* z's factor: csrc/light/moments/moments.h */

/* order, component of the jet, first degree, number of the cosine's first sum, of the sine's */
struct Item {
  uint m, component, k, cosine, sine;
};
layout(set = 0, binding = 4) readonly buffer Items { Item item[]; };
layout(set = 0, binding = 5) readonly buffer Constants { rvec4 constants[]; }; /* slows, step, rho, beta: [m][k] */

const uint TOP = LMAX + (KINDS >= 4 ? 2 : KINDS >= 2 ? 1 : 0);
const uint WIDTH = (KINDS & 1) + (KINDS >> 1 & 1) + (KINDS >> 2 & 1);

shared rvec4 constant[TOP + 1]; /* of this order */
Item own;
real sum[2 * WIDTH * BLOCK]; /* by degree and kind, the cosine's and the sine's */
uint store_at;

void clear_sums() {
  own = item[which];
  [[unroll]] for (uint i = 0; i < 2 * WIDTH * BLOCK; i++) sum[i] = REAL(0);
  for (uint k = gl_LocalInvocationID.x; k <= TOP; k += gl_WorkGroupSize.x)
    constant[k] = constants[own.m * (LMAX + 3) + k];
}

/* Recurrences of a light at degree k: weights u of k, k-1, k-2, and the polynomial in z and the one before. */
real z, rest, e, u, u1, u2, q, before;

void next_weight(uint k, real delta) {
  u2 = u1, u1 = u;
  weight_step(constant[k].x, constant[k].y, delta, e, u, e, u);
}

void next_polynomial(uint k) {
  real last = q;
#ifdef YLM_DOUBLE
  q = rise(constant[k].w, z, q, before);
#else
  q = rise_fine(constant[k].w, z, rest, q, before);
#endif
  before = last;
}

bool add(rvec3 at, rvec4 a, rvec4 b, rvec3 normal) {
  rvec3 v = a.xyz - at;
  real d2 = dot(v, v), c = REAL(1), s = REAL(0);
  Light l = seen(d2, difference(d2, a.w, b.x), b.y, b.w);
  v *= l.invd;
  if (FLAT) {
    real jet[10];
    cosine(normal, b.z, v, l.invd, jet);
    c = jet[own.component];
  }
  for (uint m = 0; m < own.m; m++) next_power(v.x, v.y, c, s, c, s);
  z = real(GROW) * v.z, rest = rest_of_z(real(GROW), v.x, v.y, v.z);
  e = u1 = u2 = before = REAL(0), u = l.es, q = REAL(1);
  for (uint k = 0; k < own.k; k++) {
    next_weight(k, l.delta);
    if (k >= own.m) next_polynomial(k);
  }
  [[unroll]] for (uint d = 0; d < BLOCK; d++) {
    uint k = own.k + d, i = 2 * WIDTH * d;
    if (k <= TOP) {
      real weight[3] = real[3](k == 0 ? l.first : u1, u1 * l.invh, bent_weight(constant[k].z, u, u2, l.far));
      [[unroll]] for (uint kind = 0; kind < 3; kind++)
        if ((KINDS >> kind & 1) != 0) {
          sum[i] += c * (q * weight[kind]);
          sum[i + 1] += s * (q * weight[kind]);
          i += 2;
        }
      next_weight(k, l.delta);
      next_polynomial(k);
    }
  }
  return l.outside;
}

void store_sums() {
  uint n = 0;
  [[unroll]] for (uint d = 0; d < BLOCK; d++) {
    uint k = own.k + d, i = 2 * WIDTH * d;
    [[unroll]] for (uint kind = 0; kind < 3; kind++)
      if ((KINDS >> kind & 1) != 0) {
        if (k <= LMAX + kind) {
          partial[store_at + (own.cosine + n) * stride] = sum[i];
          if (own.m > 0) partial[store_at + (own.sine + n) * stride] = sum[i + 1];
          n++;
        }
        i += 2;
      }
  }
}

#include "lamps_main.glsl"
