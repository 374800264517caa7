/* space.h - vectors in space, one for each lane. Private to csrc/light. */
#ifndef YLM_LIGHT_FLAT_SPACE_H
#define YLM_LIGHT_FLAT_SPACE_H

#include <stdbool.h>

#include "ylm_simd.h"

typedef ylm_vd V;
typedef ylm_vl VI;
#define LANES YLM_VD

/* A vector in space, one for each lane. */
typedef struct v3 {
  V x, y, z;
} v3;

/* The functions of gen/rim.h are made of these. */
YLM_INLINE V set(double x) { return ylm_vd_set(x); }

YLM_INLINE V dot(v3 a, v3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
YLM_INLINE v3 cross(v3 a, v3 b) {
  return (v3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
YLM_INLINE v3 scale(v3 a, V s) { return (v3){a.x * s, a.y * s, a.z * s}; }
YLM_INLINE v3 plus(v3 a, v3 b) { return (v3){a.x + b.x, a.y + b.y, a.z + b.z}; }
YLM_INLINE v3 spread(const double *p) { return (v3){set(p[0]), set(p[1]), set(p[2])}; }
YLM_INLINE V absolute(V x) { return ylm_vd_select(x < 0, -x, x); }
YLM_INLINE V larger(V a, V b) { return ylm_vd_select(a > b, a, b); }
YLM_INLINE bool any(VI m) {
  int64_t all = 0;
  for (int i = 0; i < LANES; i++) all |= m[i];
  return all != 0;
}

#include "gen/rim.h"

#endif
