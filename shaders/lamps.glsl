/*
** lamps.glsl - sums over lights for one point an invocation: what moments, flat and product share.
**
** A group sums one chunk of lights in one channel at gl_WorkGroupSize.x points: group number
** = point group + point groups * (item + items * (chunk + chunks * channel)). Lights come in tiles through shared
** memory. Partial sums go to partial[channel][chunk][sum][stride]; reduce.real.comp adds chunks.
**
** The includer has defined STORE's sums by clear_sums, add_light and store_sums of gen/.
*/
#ifdef LMAX_IS_PUSHED
#define LMAX lmax
#else
layout(constant_id = 1) const uint LMAX = 4;
#endif
layout(constant_id = 3) const uint M_FIRST = 0;
layout(constant_id = 4) const uint M_LAST = 12;
layout(constant_id = 5) const bool FLAT = false; /* lights have a normal */

#ifdef YLM_LOW
#include "gen/layout.glsl"
#define LMAX_MOST int(LOW_LMAX)
#else
#define LMAX_MOST 1000
#endif

#ifdef YLM_DOUBLE
#define rvec4 dvec4
#else
#define rvec4 vec4
#endif

#ifndef stored
#define stored real /* the type of points and sums */
#endif
#define TILE 64u /* lights in shared memory */

/* Lights: (x, y, z, r^2), (what r^2 lost, r, plain, luminance), (red, green, blue, 0) and, where FLAT, (normal, 0).
   `plain` is 1 for spheres, 0 for flat lights; spheres among flat lights have no normal. */
layout(set = 0, binding = 0) readonly buffer Points { stored point[]; };
layout(set = 0, binding = 1) readonly buffer Lamps { rvec4 lamp[]; };
layout(set = 0, binding = 2) writeonly buffer Partial { stored partial[]; };
layout(set = 0, binding = 3) buffer Inside { uint inside[]; };

PUSH {
  uint first;
  uint points, stride; /* points of this pass, and places for them in a row of sums */
  uint lamps, chunk;   /* lights, and lights of a chunk */
  uint chunk_first, chunks; /* chunks of this work, of which the first is chunk_first */
  uint channel_first;  /* 0 1 2: red green blue; 3: luminance */
  uint sums;           /* a channel's */
  uint parts, part_row; /* of these: where those times derivatives of the cosine begin, and how many of each */
  uint items;          /* groups that share points, chunk and channel: moments_any.real.comp */
#ifdef LMAX_IS_PUSHED
  uint lmax;
#endif
};

uint which; /* of them this group is */

const uint LAMP_ROWS = FLAT ? 4u : 3u, TILE_ROWS = FLAT ? 3u : 2u;
shared rvec4 tile[TILE_ROWS * TILE];

/* 1/sqrt(x) to the last bits: the driver's may be two units off, in double as coarse as in float. */
real inverse_root(real x) {
  real y = inversesqrt(x);
#ifdef YLM_DOUBLE
  y += y * (1.0lf - x * y * y) * 0.5lf;
  y += y * (1.0lf - x * y * y) * 0.5lf;
#endif
  return y + y * (REAL(1.0lf) - x * y * y) * REAL(0.5lf);
}

#include "gen/jet.glsl"
#include "gen/light.glsl"

/* d^2 - r^2 without the cancellation that rounding r^2 would bring; no contraction may undo it. */
real difference(real d2, real r2, real lost) {
  precise real h2 = d2 - r2;
  h2 = h2 - lost;
  return h2;
}

/*
** The factor of a flat light's sphere: |cos gamma| (Mezieres et al. 2022, Eqs. 24-28) as a jet by the light's
** position, 1 for spheres (`plain`) and in lights. w: the light's direction; id: 1/d; in a light 0.
*/
void cosine(rvec3 normal, real plain, rvec3 w, real id, inout real jet[10]) {
  jet_cosine(dot(normal, w) < REAL(0.0lf) ? -normal : normal, w, id, jet);
  jet[0] = id > REAL(0.0lf) ? plain + jet[0] : REAL(1.0lf);
}
