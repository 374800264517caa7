/*
** reduce.real.comp - adds chunks of partial sums to the totals, in order and with compensation
** (Kahan), so that a sum does not depend on how chunks were spread over dispatches.
**
**   partial  in      [channels][chunks][sums][stride]
**   total    in out  [channels][sums][stride]
**   lost     in out  the same: what the totals lost to rounding
** An invocation for each element of total.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(set = 0, binding = 0) readonly buffer Partial { real partial[]; };
layout(set = 0, binding = 1) buffer Total { real total[]; };
layout(set = 0, binding = 2) buffer Lost { real lost[]; };

PUSH {
  uint first;
  uint elements;    /* channels * sums * stride */
  uint row, chunks; /* sums * stride */
};

#include "gen/compensation.glsl"

void main() {
  uint i = ylm_item(first);
  if (i >= elements) return;
  uint from = (i / row) * chunks * row + i % row;
  real sum = total[i], rest = lost[i];
  for (uint k = 0u; k < chunks; k++) add_part(partial[from + k * row], sum, rest);
  total[i] = sum;
  lost[i] = rest;
}
