/* flat_second.real.comp - flat.real.comp's sums of values times the Hessian of |cos gamma|, xx xy xz yy yz zz. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

#include "lamps.glsl"
const uint KINDS = 1;

uint store_at;
real factor[10];
#define PART1 0u
#define SUM0(a) real a##_xx, a##_xy, a##_xz, a##_yy, a##_yz, a##_zz;
#define SUM1(a)
#define SUM2(a)
#define CLEAR0(a) a##_xx = a##_xy = a##_xz = a##_yy = a##_yz = a##_zz = REAL(0.0lf)
#define CLEAR1(a)
#define CLEAR2(a)
#define ADD0(a, e)                                                                                 \
  {                                                                                                \
    real one = e;                                                                                  \
    a##_xx += factor[4] * one, a##_xy += factor[5] * one, a##_xz += factor[6] * one;               \
    a##_yy += factor[7] * one, a##_yz += factor[8] * one, a##_zz += factor[9] * one;               \
  }
#define ADD1(a, e)
#define ADD2(a, e)
#define KEEP0(a, b)                                                                                \
  real b##_xx = a##_xx, b##_xy = a##_xy, b##_xz = a##_xz, b##_yy = a##_yy, b##_yz = a##_yz, b##_zz = a##_zz
#define KEEP1(a, b)
#define KEEP2(a, b)
#define STORE0(n, p, a)                                                                            \
  put(p, 0u, a##_xx), put(p, 1u, a##_xy), put(p, 2u, a##_xz);                                      \
  put(p, 3u, a##_yy), put(p, 4u, a##_yz), put(p, 5u, a##_zz)
#define STORE1(n, p, a)
#define STORE2(n, p, a)

void put(uint p, uint k, real a) { partial[store_at + (parts + k * part_row + p) * stride] = a; }

#include "gen/moments.glsl"

void weigh(rvec3 direction, real id, rvec3 normal, real plain) {
  cosine(normal, plain, direction, id, factor);
}
#include "moments_add.glsl"
#include "lamps_main.glsl"
