/*
** lamps.glsl - sums over lights for one point an invocation: what moments and product share.
**
** A group sums one chunk of lights in one channel at gl_WorkGroupSize.x points: group number
** = point group + point groups * (chunk + chunks * channel). Lights come in tiles through shared
** memory. Partial sums go to partial[channel][chunk][sum][stride]; reduce.real.comp adds chunks.
**
** The includer has defined STORE's sums by clear_sums, add_light and store_sums of gen/.
*/
layout(constant_id = 1) const uint LMAX = 4;
layout(constant_id = 3) const uint M_FIRST = 0;
layout(constant_id = 4) const uint M_LAST = 12;

#ifdef YLM_DOUBLE
#define rvec4 dvec4
#else
#define rvec4 vec4
#endif

#define TILE 64u /* lights in shared memory */

/* Lights: (x, y, z, r^2), (what r^2 lost, r, 0, luminance), (red, green, blue, 0). */
layout(set = 0, binding = 0) readonly buffer Points { real point[]; };
layout(set = 0, binding = 1) readonly buffer Lamps { rvec4 lamp[]; };
layout(set = 0, binding = 2) writeonly buffer Partial { real partial[]; };
layout(set = 0, binding = 3) buffer Inside { uint inside[]; };

PUSH {
  uint first;
  uint points, stride; /* points of this pass, and places for them in a row of sums */
  uint lamps, chunk;   /* lights, and lights of a chunk */
  uint chunk_first, chunks; /* chunks of this work, of which the first is chunk_first */
  uint channel_first;  /* 0 1 2: red green blue; 3: luminance */
  uint sums;           /* a channel's */
};

shared rvec4 tile[2 * TILE];

/* 1/sqrt(x) to the last bits: the driver's may be two units off, in double as coarse as in float. */
real inverse_root(real x) {
  real y = inversesqrt(x);
#ifdef YLM_DOUBLE
  y += y * (1.0lf - x * y * y) * 0.5lf;
  y += y * (1.0lf - x * y * y) * 0.5lf;
#endif
  return y + y * (REAL(1.0lf) - x * y * y) * REAL(0.5lf);
}

/* d^2 - r^2 without the cancellation that rounding r^2 would bring; no contraction may undo it. */
real difference(real d2, real r2, real lost) {
  precise real h2 = d2 - r2;
  h2 = h2 - lost;
  return h2;
}
