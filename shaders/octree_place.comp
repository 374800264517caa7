/* Positions of points: floats, nearest to their places on the lattice. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(set = 0, binding = 0) readonly buffer Keys { uvec2 key[]; };
layout(set = 0, binding = 1) readonly buffer Axes { vec2 axis[]; }; /* [3][resolution + 1]: float, what it lacks */
layout(set = 0, binding = 2) writeonly buffer Points { float point[]; };

PUSH {
  uint first;
  uint n, begin, resolution;
};

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  uvec3 c = unpacked(key[begin + i]);
  for (uint a = 0; a < 3; a++) point[3 * i + a] = axis[a * (resolution + 1) + c[a]].x;
}
