/* Spherical harmonics at points, low degrees: the generator's unrolled formulas. One item a point. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(constant_id = 1) const uint LMAX = 4;
layout(constant_id = 2) const uint ORDER = 2; /* of derivatives */
layout(constant_id = 3) const bool SOLID = false;
const uint COUNT = (LMAX + 1) * (LMAX + 1);

layout(set = 0, binding = 0) readonly buffer Points { real point[]; };      /* [n][3] */
layout(set = 0, binding = 1) writeonly buffer Values { real value[]; };     /* [n][COUNT] */
layout(set = 0, binding = 2) writeonly buffer Gradients { real gradient[]; }; /* [n][COUNT][3] */
layout(set = 0, binding = 3) writeonly buffer Hessians { real hessian[]; }; /* [n][COUNT][6] */
PUSH {
  uint first;
  uint n;
};

uint at; /* of this point's results */
#define YLM_Y(k, e) value[at + (k)] = e
#define YLM_dY(k, e)                                                                               \
  if (ORDER > 0) gradient[3 * at + (k)] = e
#define YLM_ddY(k, e)                                                                              \
  if (ORDER > 1) hessian[6 * at + (k)] = e

#include "sh.glsl"
#include "sh_solid.glsl"
#include "unit.glsl"

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  at = i * COUNT;
  rvec3 v = rvec3(point[3 * i], point[3 * i + 1], point[3 * i + 2]);
  if (SOLID)
    ylm_sh_solid(v.x, v.y, v.z);
  else {
    real s = ylm_unit(v), g, o;
    ylm_pole(v, g, o);
    ylm_sh(v.x, v.y, v.z, g, o, s);
  }
}
