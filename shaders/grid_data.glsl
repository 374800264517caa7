/*
** grid_data.glsl - what grid_sample.comp and grid_shade.comp share: the grid's data, and points in the order of the cells
** that they need. Push constants come with n, stride, part_rows and unit[3] (a lattice cell in scene units).
*/
layout(constant_id = 1) const uint INTERPOLATION = 0; /* hermite, taylor, linear */
layout(constant_id = 3) const bool SORTED = false;    /* else the points' own order */
layout(constant_id = 4) const uint PARTS = 1;         /* of data: part_rows of the grid's points in each */

const uint CHUNK = 64; /* points of a group, one for each invocation */

layout(set = 0, binding = 0) readonly buffer Data0 { float data0[]; }; /* [points][4][stride] */
layout(set = 0, binding = 1) readonly buffer Data1 { float data1[]; };
layout(set = 0, binding = 2) readonly buffer Data2 { float data2[]; };
layout(set = 0, binding = 3) readonly buffer Data3 { float data3[]; };
layout(set = 0, binding = 4) readonly buffer Cells { Cell cell[]; };
layout(set = 0, binding = 5) readonly buffer Places { uvec4 place[]; };
layout(set = 0, binding = 6) readonly buffer Order { uint order[]; };

/* Coefficient j (kind 0) or its derivative along axis kind - 1 at a point of the grid. */
float grid_data(uint row, uint kind, uint j) {
  if (PARTS == 1) return data0[(row * 4 + kind) * stride + j];
  uint part = row / part_rows, at = ((row - part * part_rows) * 4 + kind) * stride + j;
  return part == 0 ? data0[at] : part == 1 ? data1[at] : part == 2 ? data2[at] : data3[at];
}

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
