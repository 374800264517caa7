/*
** metric.real.comp - the norm of the largest eigenvalues of all Hessians, and of the coefficients
** (Iwasaki & Dobashi 2025, Eq. 22).
**
**   value    in   [channels][count][stride]
**   hessian  in   [channels][count][6][stride]
**   lambda, norm  out  [points]
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

#include "gen/eigenvalue.glsl"

layout(set = 0, binding = 0) readonly buffer Value { real value[]; };
layout(set = 0, binding = 1) readonly buffer Hessian { real hessian[]; };
layout(set = 0, binding = 2) writeonly buffer Lambda { real lambda[]; };
layout(set = 0, binding = 3) writeonly buffer Norm { real norm[]; };

PUSH {
  uint first;
  uint points, stride;
  uint count; /* coefficients of all channels */
};

void main() {
  uint i = ylm_item(first);
  if (i >= points) return;
  real squares = REAL(0.0lf), norm2 = REAL(0.0lf);
  for (uint k = 0u; k < count; k++) {
    uint h = 6u * k * stride + i;
    real e = largest_eigenvalue(hessian[h], hessian[h + stride], hessian[h + 2u * stride], hessian[h + 3u * stride],
                                hessian[h + 4u * stride], hessian[h + 5u * stride]);
    real v = value[k * stride + i];
    squares += e * e;
    norm2 += v * v;
  }
  lambda[i] = sqrt(squares);
  norm[i] = sqrt(norm2);
}
