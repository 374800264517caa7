/* octree_table.glsl - the table of points, open addressing with linear probing; the includer declares the buffers
   slot (entries), key (of points) and voxel, and the push constants edge and mask. */

uvec2 key_of(uint entry) {
  if ((entry & FRESH) == 0) return key[entry];
  uint c = entry & ~FRESH;
  return packed(unpacked(voxel[c >> 3].xy) + corner_of(c & 7, edge));
}
