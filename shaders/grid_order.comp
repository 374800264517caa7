/* Points in the order of the cells that they need: tally is where each cell's begin, and then where they end. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "grid.glsl"

layout(set = 0, binding = 0) readonly buffer Places { uvec4 place[]; };
layout(set = 0, binding = 1) buffer Tally { uint tally[]; }; /* [cells + 1]: the last are the host's */
layout(set = 0, binding = 2) writeonly buffer Order { uint order[]; };
PUSH {
  uint first;
  uint n, cells;
};

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  uint k = place[i].x;
  order[atomicAdd(tally[k == NONE ? cells : k & ~AWAY], 1)] = i;
}
