/* within.h - the largest numbers of arrays, as bits: what within.c and its kernels share. Private to csrc/base. */
#ifndef YLM_WITHIN_H
#define YLM_WITHIN_H

#include <string.h>

#include "ylm_base.h"

/* The largest of n numbers without their signs, as bits: infinities and NaNs are larger than all others. */
typedef struct ylm__magnitudes {
  int32_t (*of_float)(const float *x, size_t n);
  int64_t (*of_double)(const double *x, size_t n);
} ylm__magnitudes;

#define YLM__MAGNITUDE(name, real, bits, sign)                                                     \
  static bits name(const real *x, size_t n) {                                                      \
    bits most = 0;                                                                                 \
    for (size_t i = 0; i < n; i++) {                                                               \
      bits b;                                                                                      \
      memcpy(&b, x + i, sizeof b);                                                                 \
      b &= sign;                                                                                   \
      most = b > most ? b : most;                                                                  \
    }                                                                                              \
    return most;                                                                                   \
  }                                                                                                \
  _Static_assert(sizeof(real) == sizeof(bits), "bits of a number")

#endif
