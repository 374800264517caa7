/* Entries of the table that are candidates become the points that these have been numbered as. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(set = 0, binding = 0) buffer Slots { uint slot[]; };
layout(set = 0, binding = 1) readonly buffer Before { uint before[]; };

PUSH {
  uint first;
  uint n, points;
};

void main() {
  uint i = ylm_item(first);
  if (i >= n || slot[i] == EMPTY || (slot[i] & FRESH) == 0) return;
  slot[i] = points + before[slot[i] & ~FRESH];
}
