/* Numbers the points that a level adds, in the order of the candidates that first had them; corners become points. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(set = 0, binding = 0) buffer Corners { uint corner[]; };
layout(set = 0, binding = 1) readonly buffer Before { uint before[]; };
layout(set = 0, binding = 2) writeonly buffer Keys { uvec2 key[]; };
layout(set = 0, binding = 3) readonly buffer Voxels { uvec4 voxel[]; };

PUSH {
  uint first;
  uint n, edge, points; /* points there were */
};

void main() {
  uint i = ylm_item(first);
  if (i >= n || (corner[i] & FRESH) == 0) return;
  uint c = corner[i] & ~FRESH, p = points + before[c];
  corner[i] = p;
  if (c == i) key[p] = packed(unpacked(voxel[i >> 3].xy) + corner_of(i & 7, edge));
}
