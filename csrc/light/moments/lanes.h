/* lanes.h - choices, sizes and eigenvalues, lane by lane, for the unit's element type. Private to csrc/light. */
#ifndef YLM_LIGHT_LANES_H
#define YLM_LIGHT_LANES_H

#include "ylm_real.h"

/* A divisor that stands for 0. */
#ifdef YLM_REAL_IS_FLOAT
#define TINY 1e-30f
#else
#define TINY 1e-280
#endif

YLM_INLINE vreal choose(vmask first, vreal a, vreal b) {
  return (vreal)(((vmask)a & first) | ((vmask)b & ~first));
}
YLM_INLINE vreal keep_lanes(vmask mask, vreal a) { return (vreal)((vmask)a & mask); }
YLM_INLINE vreal larger(vreal a, vreal b) { return choose(a > b, a, b); }
YLM_INLINE vreal smaller(vreal a, vreal b) { return -larger(-a, -b); }
YLM_INLINE vreal magnitude(vreal a) { return larger(a, -a); }

#include "gen/eigenvalue.h"

#endif
