/*
** Puts the corners of a level's voxels, or points (a larger table), into the table. Of the same key the smallest
** entry stays: a point, else the first candidate; so the table does not depend on the order of invocations.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(constant_id = 1) const uint POINTS = 0; /* 1: items are points */

layout(set = 0, binding = 0) buffer Slots { uint slot[]; };
layout(set = 0, binding = 1) readonly buffer Keys { uvec2 key[]; };
layout(set = 0, binding = 2) readonly buffer Voxels { uvec4 voxel[]; };

PUSH {
  uint first;
  uint n, edge, mask;
};

#include "octree_table.glsl"

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  uint entry = POINTS != 0 ? i : FRESH | i;
  uvec2 own = key_of(entry);
  uint h = hash_of(own) & mask;
  for (uint tries = 0; tries <= mask; tries++) {
    uint old = atomicCompSwap(slot[h], EMPTY, entry);
    if (old == EMPTY) return;
    if (key_of(old) == own) {
      atomicMin(slot[h], entry);
      return;
    }
    h = (h + 1) & mask;
  }
}
