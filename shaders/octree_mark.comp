/*
** One level of the occupancy octree: marks the nodes that hold shading points. The nodes of the level above are
** numbered by rank, in Morton order; bit 8 rank + octant stands for a child, so that a child's rank is the number of
** bits before its own. A point carries the rank of its node; first it steps down to the level above.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(set = 0, binding = 0) buffer Places { uint place[]; }; /* [n][3]: x and y, z, rank */
layout(set = 0, binding = 1) buffer Bits { uint bits[]; };    /* this level's */
layout(set = 0, binding = 2) readonly buffer AboveBits { uint above[]; };
layout(set = 0, binding = 3) readonly buffer AboveBefore { uint before[]; }; /* bits in the words before */

PUSH {
  uint first;
  uint n, level;
  uint shift; /* the finest level less this one */
};

#include "gen/cells.glsl"

uint octant(uint xy, uint z, uint at) { return octant_of(xy, xy >> 16, z, at); }

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  uint xy = place[3 * i], z = place[3 * i + 1], rank = place[3 * i + 2];
  if (level > 1) {
    uint bit = (rank & 3) * 8 + octant(xy, z, shift + 1);
    rank = before[rank >> 2] + bitCount(above[rank >> 2] & ((1u << bit) - 1));
    place[3 * i + 2] = rank;
  }
  uint own = 1u << ((rank & 3) * 8 + octant(xy, z, shift));
  if ((bits[rank >> 2] & own) == 0) atomicOr(bits[rank >> 2], own);
}
