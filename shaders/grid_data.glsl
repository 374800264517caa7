/*
** grid_data.glsl - what grid_sample.comp and grid_shade.comp share: the grid's data, and points in the order of the cells
** that they need. Push constants come with n, spread, stride, part_rows and unit[3] (a lattice cell in scene units).
*/
layout(constant_id = 1) const uint INTERPOLATION = 0; /* hermite, taylor, linear */
layout(constant_id = 3) const bool SORTED = false;    /* else the points' own order */

#include "grid_rows.glsl"

const uint CHUNK = 64; /* points of a group, one for each invocation */

layout(set = 0, binding = 4) readonly buffer Cells { Cell cell[]; };
layout(set = 0, binding = 5) readonly buffer Places { uvec4 place[]; };
layout(set = 0, binding = 6) readonly buffer Order { uint order[]; };

shared uint cell_of[CHUNK];

/* This invocation's point and where it is; NONE where there is no point or the host samples it. */
uvec4 find(uint begin, uint lane, out uint i) {
  i = begin + lane;
  if (i < n && SORTED) i = order[i];
  uvec4 x = i < n ? place[i] : uvec4(NONE);
  cell_of[lane] = x.x & ~AWAY;
  return x;
}

/* Where the run of points in one cell ends that begins at lane `from`. */
uint end_of_run(uint from) {
  uint to = from + 1;
  while (to < CHUNK && cell_of[to] == cell_of[from]) to++;
  return to;
}

/* How many runs the group has. */
uint runs() {
  uint n = 1;
  for (uint k = 1; k < CHUNK; k++) n += cell_of[k] != cell_of[k - 1] ? 1 : 0;
  return n;
}

/*
** The points that a group begins with. Groups of few cells take a fraction of the time of those of many, and neighbours
** are alike: so that slices of work take the time that those before them did, strips of `spread` groups come in the order
** of the reversed bits of their numbers, of which there are 256. spread 0: in order.
*/
uint chunk(uint group) {
  if (spread != 0) group = (bitfieldReverse(group / spread) >> 24) * spread + group % spread;
  return group * CHUNK;
}
