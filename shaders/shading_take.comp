/* Some of the shading points, in a row: those that lie in one part of them. One item a word. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(constant_id = 1) const uint WORDS = 3; /* of a point */

layout(set = 0, binding = 0) readonly buffer Points { uint word[]; }; /* begin .. end - 1 */
layout(set = 0, binding = 1) readonly buffer Which { uint which[]; };
layout(set = 0, binding = 2) buffer Taken { uint taken[]; };
PUSH {
  uint first;
  uint n, begin, end;
};

void main() {
  uint item = ylm_item(first), i = item / WORDS;
  if (i >= n || which[i] < begin || which[i] >= end) return;
  taken[item] = word[(which[i] - begin) * WORDS + item % WORDS];
}
