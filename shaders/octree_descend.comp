/* The voxels of the next level: children, in order, of the voxels that are split. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(set = 0, binding = 0) readonly buffer Voxels { uvec4 voxel[]; };
layout(set = 0, binding = 1) readonly buffer States { uint state[]; };
layout(set = 0, binding = 2) readonly buffer Bits { uint bits[]; }; /* the next level's occupancy */
layout(set = 0, binding = 3) readonly buffer BitsBefore { uint bits_before[]; };
layout(set = 0, binding = 4) readonly buffer SplitsBefore { uint splits_before[]; };
layout(set = 0, binding = 5) readonly buffer VoxelsBefore { uint voxels_before[]; };
layout(set = 0, binding = 6) writeonly buffer Next { uvec4 next[]; };
layout(set = 0, binding = 7) writeonly buffer NextStates { uint next_state[]; };
layout(set = 0, binding = 8) writeonly buffer Asked { uint asked[]; }; /* in no order */
layout(set = 0, binding = 9) buffer Counts { uint count[]; };

PUSH {
  uint first;
  uint n, half_edge, all;
};

void main() {
  uint i = ylm_item(first);
  if (i >= n || (state[i] & SPLIT) == 0) return;
  uint s = state[i], rank = voxel[i].z, j = voxels_before[i];
  uvec3 at = unpacked(voxel[i].xy);
  for (uint k = 0; k < 8; k++) {
    if ((s >> k & 1) == 0) continue;
    uint below = all != 0 ? 0 : bits_before[rank >> 2] + bitCount(bits[rank >> 2] & ((1u << ((rank & 3) * 8 + k)) - 1));
    next[j] = uvec4(packed(at + corner_of(k, half_edge)), below, 8 * splits_before[i] + k);
    next_state[j] = (s & CROSSED) != 0 ? ASKED : 0;
    if ((s & CROSSED) != 0) asked[atomicAdd(count[COUNT_PLACED], 1)] = j;
    j++;
  }
}
