/* fold.h - sums of the lanes of a vector, in one order for all kernels of shading. Private. */
#ifndef YLM_SHADE_FOLD_H
#define YLM_SHADE_FOLD_H

#include <string.h>

#include "ylm_simd.h"

typedef float v4 __attribute__((vector_size(16)));

/* Four lanes whose sum is that of all lanes. */
YLM_INLINE v4 fold(ylm_vf v) {
  v4 part[YLM_VF / 4], s;
  memcpy(part, &v, sizeof v);
  s = part[0];
#if YLM_VECTOR_BYTES == 32
  s += part[1];
#elif YLM_VECTOR_BYTES == 64
  s = (s + part[2]) + (part[1] + part[3]);
#endif
  return s;
}

#endif
