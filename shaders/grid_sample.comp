/*
** Interpolates a grid at places: shaders/gen/interpolation.glsl has the 32 weights of a cell's corners. A group has CHUNK
** points in the order of cells; an invocation keeps a coefficient's numbers at all corners while it goes through a run of
** points in one cell.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "grid.glsl"

layout(constant_id = 2) const bool GRADIENT = false;

PUSH {
  uint first;
  uint n, spread, stride, part_rows, width, nan_outside;
  float unit[3];
};

#include "grid_data.glsl"

layout(set = 0, binding = 7) writeonly buffer Values { float value[]; };       /* [n][width] */
layout(set = 0, binding = 8) writeonly buffer Gradients { float gradient[]; }; /* [n][width][3] */

const uint SETS = GRADIENT ? 4 : 1, ROWS = INTERPOLATION == 2 && !GRADIENT ? 8 : 32;

shared float weight[CHUNK * 33]; /* a place more, so that points are in different banks */
shared uint item[CHUNK];
shared bool away[CHUNK];

#include "grid_weights.glsl"

void main() {
  uint lane = gl_LocalInvocationID.x, i;
  uvec4 x = find(chunk(ylm_group(first)), lane, i);
  item[lane] = i;
  away[lane] = (x.x & AWAY) != 0 && nan_outside != 0;
  for (uint set = 0; set < SETS; set++) {
    if (x.x != NONE) weights(lane * 33, set, x.x & ~AWAY, uintBitsToFloat(x.yzw));
    barrier();
    for (uint from = 0, to; from < CHUNK; from = to) {
      to = end_of_run(from);
      uint k = cell_of[from];
      for (uint j = lane; k != NONE && j < width; j += CHUNK) {
        float v[ROWS];
        for (uint r = 0; r < ROWS; r++) v[r] = grid_data(cell[k].corner[r & 7], r >> 3, j);
        for (uint p = from; p < to; p++) {
          float sum = 0.0;
          for (uint r = 0; r < ROWS; r++) sum += weight[p * 33 + r] * v[r];
          if (away[p]) sum = uintBitsToFloat(0x7fc00000);
          uint at = item[p] * width + j;
          if (set == 0)
            value[at] = sum;
          else
            gradient[3 * at + set - 1] = sum;
        }
      }
    }
    barrier();
  }
}
