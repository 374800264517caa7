/* Rows of some points, in a row: copied from their places, or to there. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#define WRITES_ROWS

layout(constant_id = 1) const uint PUT = 0;

PUSH {
  uint first;
  uint n, stride, part_rows;
};

#include "grid_rows.glsl"

layout(set = 0, binding = 4) readonly buffer Points { uint point[]; };
layout(set = 0, binding = 5) buffer Packed { float packed[]; }; /* [n][4][stride] */

void main() {
  uint item = ylm_item(first), i = item / (4 * stride), c = item % (4 * stride);
  if (i >= n) return;
  if (PUT != 0)
    put_data(point[i], c / stride, c % stride, packed[item]);
  else
    packed[item] = grid_data(point[i], c / stride, c % stride);
}
