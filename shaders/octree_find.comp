/* The table's entry for each corner of a level's voxels. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(set = 0, binding = 0) readonly buffer Slots { uint slot[]; };
layout(set = 0, binding = 1) readonly buffer Keys { uvec2 key[]; };
layout(set = 0, binding = 2) readonly buffer Voxels { uvec4 voxel[]; };
layout(set = 0, binding = 3) writeonly buffer Corners { uint corner[]; };

PUSH {
  uint first;
  uint n, edge, mask;
};

#include "octree_table.glsl"

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  uvec2 own = key_of(FRESH | i);
  uint h = hash_of(own) & mask;
  for (uint tries = 0; tries < mask && slot[h] != EMPTY && key_of(slot[h]) != own; tries++) h = (h + 1) & mask;
  corner[i] = slot[h];
}
