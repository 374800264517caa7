/*
** The voxel of the finest lattice that holds each shading point, whatever the type of the points and without
** rounding: the bits of a number, as an integer that orders like the number, among those of the numbers at which
** voxels begin, which the host has found.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

#include "gen/layout.glsl"

layout(constant_id = 1) const uint WORDS = 1; /* of a number: 1 float, 2 double */

layout(set = 0, binding = 0) readonly buffer Points { uint word[]; }; /* [n][3][WORDS] */
/* By axis, its voxels less one: where they begin; [3][2]: the first and the last number inside of the bounds */
layout(set = 0, binding = 1) readonly buffer Fences { uvec2 fence[]; };
layout(set = 0, binding = 2) writeonly buffer Places { uint place[]; }; /* [n][3]: x and y, z, rank */
layout(set = 0, binding = 3) buffer Counts { uint count[]; };

PUSH {
  uint first;
  uint n, begin;  /* points, and which is the first of them */
  uint high;      /* which word of a double is the high one */
  uint voxels[3]; /* along each axis */
};

/* Ordered like the number at `at`; the high word first. */
uvec2 order_of(uint at) {
  uint h = word[WORDS * at + (WORDS == 2 ? high : 0)], l = WORDS == 2 ? word[WORDS * at + 1 - high] : 0;
  return uvec2(order_of_high(h), WORDS == 2 ? order_of_low(h, l) : 0);
}

/* All bits of its exponent: infinite, or no number. */
bool finite(uint at) {
  uint ones = WORDS == 2 ? 0x7ff00000 : 0x7f800000;
  return (word[WORDS * at + (WORDS == 2 ? high : 0)] & ones) != ones;
}

bool below(uvec2 a, uvec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  uint c[3], from = 0, end = voxels[0] + voxels[1] + voxels[2] - 3;
  bool outside = false;
  for (uint a = 0; a < 3; a++) {
    uvec2 x = order_of(3 * i + a);
    uint lo = 0, hi = voxels[a] - 1;
    while (lo < hi) { /* fence k is where voxel k + 1 begins */
      uint middle = (lo + hi) / 2;
      if (below(x, fence[from + middle]))
        hi = middle;
      else
        lo = middle + 1;
    }
    c[a] = lo;
    if (!finite(3 * i + a)) atomicMax(count[COUNT_BAD], ~(begin + i));
    outside = outside || below(x, fence[end]) || below(fence[end + 1], x);
    from += voxels[a] - 1;
    end += 2;
  }
  if (outside) atomicAdd(count[COUNT_OUTSIDE], 1);
  place[3 * i] = c[0] | c[1] << 16;
  place[3 * i + 1] = c[2];
  place[3 * i + 2] = 0;
}
