/* Which voxels of a level are split: those whose metric, the mean over the corners outside of lights, exceeds the
   threshold, and those that a light's surface crosses. Finds which of the children hold shading points. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(set = 0, binding = 0) readonly buffer Voxels { uvec4 voxel[]; }; /* key, rank among the level's nodes, cell */
layout(set = 0, binding = 1) readonly buffer Corners { uint corner[]; };
layout(set = 0, binding = 2) readonly buffer Ratio { float ratio[]; };
layout(set = 0, binding = 3) readonly buffer Bits { uint bits[]; }; /* the next level's occupancy */
layout(set = 0, binding = 4) buffer States { uint state[]; };
layout(set = 0, binding = 5) writeonly buffer Errors { float error[]; };
layout(set = 0, binding = 6) buffer Counts { uint count[]; };

PUSH {
  uint first;
  uint n;
  uint last, all; /* whether this is the finest level; whether every child is a voxel */
  float diagonal, threshold;
};

#include "gen/cells.glsl"

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  float sum = 0.0, valid = 0.0;
  for (uint k = 0; k < 8; k++) {
    float r = ratio[corner[8 * i + k]];
    if (r >= 0.0) sum += r, valid += 1.0;
  }
  float e = cell_metric(sum, valid, diagonal, 0.5 * diagonal);
  error[i] = e;
  uint s = state[i] & CROSSED, rank = voxel[i].z;
  if (last == 0 && cell_splits(e, threshold, s != 0)) {
    uint children = all != 0 ? CHILDREN : bits[rank >> 2] >> (rank & 3) * 8 & CHILDREN;
    if (s != 0) atomicAdd(count[COUNT_ASKED], bitCount(children));
    s |= SPLIT | children;
  }
  state[i] = s;
}
