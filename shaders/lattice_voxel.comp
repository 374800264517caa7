/* The voxels of a uniform grid, all or those that are marked, x fastest. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(set = 0, binding = 0) readonly buffer Bits { uint bits[]; };
layout(set = 0, binding = 1) readonly buffer Before { uint before[]; }; /* bits in the words before */
layout(set = 0, binding = 2) writeonly buffer Voxels { uvec4 voxel[]; };

PUSH {
  uint first;
  uint n, nx, ny;
  uint all;
};

void main() {
  uint i = ylm_item(first), k = i;
  if (i >= n) return;
  if (all == 0) {
    uint word = bits[i >> 5], own = 1u << (i & 31);
    if ((word & own) == 0) return;
    k = before[i >> 5] + bitCount(word & (own - 1));
  }
  voxel[k] = uvec4(packed(uvec3(i % nx, i / nx % ny, i / nx / ny)), 0, k);
}
