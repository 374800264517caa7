/*
** grid_data.glsl - what grid_sample.comp and grid_shade.comp share: the grid's data, and points in the order of the cells
** that they need. Push constants come with n, stride, part_rows and unit[3] (a lattice cell in scene units).
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
