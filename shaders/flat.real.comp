/*
** flat.real.comp - merged moments of flat lights: those of the spheres that approximate them, times |cos gamma| and
** the components of its gradient (Mezieres et al. 2022, Eqs. 24-28). Sums of values are four times those of spheres,
** those for gradients too where Hessians are wanted: S c, S grad c; S' c, S' grad c; S'' c.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

#include "lamps.glsl"
layout(constant_id = 2) const uint KINDS = 1;

uint store_at;
real factor[10];
const uint PART1 = (KINDS & 4) != 0 ? 1u : 0u;
#define SUM0(a) real a, a##_x, a##_y, a##_z;
#define SUM1(a) SUM0(a)
#define SUM2(a) real a;
#define CLEAR0(a) a = a##_x = a##_y = a##_z = REAL(0.0lf)
#define CLEAR1(a) CLEAR0(a)
#define CLEAR2(a) a = REAL(0.0lf)
#define ADD0(a, e)                                                                                 \
  {                                                                                                \
    real one = e;                                                                                  \
    a += factor[0] * one, a##_x += factor[1] * one, a##_y += factor[2] * one, a##_z += factor[3] * one; \
  }
#define ADD1(a, e) ADD0(a, e)
#define ADD2(a, e) a += factor[0] * (e)
#define KEEP0(a, b) real b = a, b##_x = a##_x, b##_y = a##_y, b##_z = a##_z
#define KEEP1(a, b) KEEP0(a, b)
#define KEEP2(a, b) real b = a
#define STORE0(n, p, a) put(n, a); if (KINDS > 1) put_parts(p, a##_x, a##_y, a##_z)
#define STORE1(n, p, a) put(n, a); if (KINDS > 3) put_parts(p, a##_x, a##_y, a##_z)
#define STORE2(n, p, a) put(n, a)

void put(uint n, real a) { partial[store_at + n * stride] = a; }
void put_parts(uint p, real x, real y, real z) {
  put(parts + p, x);
  put(parts + part_row + p, y);
  put(parts + 2u * part_row + p, z);
}

#include "gen/moments.glsl"

void weigh(rvec3 direction, real id, rvec3 normal, real plain) {
  cosine(normal, plain, direction, id, factor);
}
#include "moments_add.glsl"
#include "lamps_main.glsl"
