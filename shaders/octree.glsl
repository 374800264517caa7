/*
** octree.glsl - what the kernels shaders/octree_*.comp share: csrc/vulkan/grid/octree.h says what they do.
**
** Lattice coordinates, 0 .. 2^16 each, are packed into two words: a key. The cells of a level that hold shading
** points are its voxels; candidate 8 w + k is corner k of voxel w. An entry of the table of points is a point, or
** FRESH and the candidate that first had the key of a point that has no number yet.
*/

const uint EMPTY = 0xffffffff, FRESH = 0x80000000;

#include "gen/layout.glsl"

uvec2 packed(uvec3 c) { return uvec2(key_low(c.x, c.y), key_high(c.y, c.z)); }

uvec3 unpacked(uvec2 k) { return uvec3(key_x(k.x), key_y(k.x, k.y), key_z(k.y)); }

/* Corner (or octant) k of something of that edge, from its lowest corner. */
uvec3 corner_of(uint k, uint edge) { return uvec3(k & 1, k >> 1 & 1, k >> 2) * edge; }

uint hash_of(uvec2 k) {
  uint h = k.x * 0x9e3779b1 ^ k.y * 0x85ebca77;
  h = (h ^ h >> 15) * 0x2c1b3c6d;
  h = (h ^ h >> 12) * 0x297a2d39;
  return h ^ h >> 15;
}
