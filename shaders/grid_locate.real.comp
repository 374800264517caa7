/* Where points are in a grid: the cell whose corners are interpolated, and the fractions of its edges; how many points each
   cell has. One item a point. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "grid.glsl"

layout(constant_id = 1) const bool DOUBLES = false; /* points, which the float kernel does not take */
layout(constant_id = 2) const bool SORTED = false;  /* count in tally */

layout(set = 0, binding = 0) readonly buffer Cells { Cell cell[]; };
layout(set = 0, binding = 1) readonly buffer Table { uint table[]; }; /* uniform: cells by lattice coordinates */
layout(set = 0, binding = 2) readonly buffer Bounds { real lo[3], hi[3], scale[3]; };
layout(set = 0, binding = 3) readonly buffer Points { uint point[]; }; /* [n][3], words */
layout(set = 0, binding = 4) writeonly buffer Places { uvec4 place[]; };
layout(set = 0, binding = 5) buffer Counts { uint outside, unbaked, elsewhere; };
layout(set = 0, binding = 6) buffer Tally { uint tally[]; }; /* [cells + 1]: the last are the host's */
PUSH {
  uint first;
  uint n, depth, uniform_grid;
  uint resolution[3];
  uint cells;
};

#include "gen/cells.glsl"

real coordinate(uint k) {
#ifdef YLM_DOUBLE
  if (DOUBLES) return packDouble2x32(uvec2(point[2 * k], point[2 * k + 1]));
#endif
  return real(uintBitsToFloat(point[k]));
}

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  real at[3];
  uint c[3];
  bool away = false;
  for (int a = 0; a < 3; a++) {
    real p = coordinate(3 * i + a), last = real(resolution[a]);
    at[a] = lattice_coordinate(p, lo[a], hi[a], scale[a], last);
    away = away || !within(p, lo[a], hi[a]);
    c[a] = min(uint(at[a]), resolution[a] - 1);
  }
  uint k = uniform_grid != 0 ? table[(c[2] * resolution[1] + c[1]) * resolution[0] + c[0]] : 0;
  if (k != NONE && uniform_grid == 0) {
    while (cell[k].child != 0) {
      uint shift = depth - (cell[k].info & LEVEL) - 1;
      k = cell[k].child + octant_of(c[0], c[1], c[2], shift);
    }
    if ((cell[k].info & ELSEWHERE) != 0) k = NONE;
  }
  if (k == NONE) { /* the host samples it */
    atomicAdd(elsewhere, 1);
    if (SORTED) atomicAdd(tally[cells], 1);
    place[i] = uvec4(NONE, 0, 0, 0);
    return;
  }
  if (away) atomicAdd(outside, 1);
  if ((cell[k].info & HAS_DATA) == 0) atomicAdd(unbaked, 1);
  k = cell[k].source;
  if (SORTED) atomicAdd(tally[k], 1);
  vec3 t;
  real inverse = real(1) / real(cell[k].edge);
  for (int a = 0; a < 3; a++)
    t[a] = float(clamp(edge_fraction(at[a], real(cell[k].origin[a]), inverse), real(0), real(1)));
  place[i] = uvec4(k | (away ? AWAY : 0), floatBitsToUint(t));
}
