/*
** rows.real.comp - y = A x for a sparse A and many points: from sums to coefficients, gradients,
** Hessians. Row r of A is coef[t], index[t] for t = start[r] .. start[r+1]-1.
**
**   x  in   element k of point i at from + k * stride + i
**   y  out  row r of point i at to + r * to_row + i * to_point
** A group handles ROWS rows at gl_WorkGroupSize.x points.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

#define ROWS 8u

layout(set = 0, binding = 0) readonly buffer X { real x[]; };
layout(set = 0, binding = 1) writeonly buffer Y { real y[]; };
layout(set = 0, binding = 2) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 3) readonly buffer Index { uint index[]; };
layout(set = 0, binding = 4) readonly buffer Coef { real coef[]; };

PUSH {
  uint first;
  uint points, stride, rows;
  uint from, to, to_row, to_point;
};

void main() {
  uint blocks = (points + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x, group = ylm_group(first);
  uint i = (group % blocks) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
  uint row = (group / blocks) * ROWS, last = min(row + ROWS, rows);
  if (i >= points) return;
  for (; row < last; row++) {
    real sum = REAL(0.0lf);
    for (uint t = start[row]; t < start[row + 1u]; t++) sum += coef[t] * x[from + index[t] * stride + i];
    y[to + row * to_row + i * to_point] = sum;
  }
}
