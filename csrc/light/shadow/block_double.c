/* block_double.c - light behind casters, in double; see block.h. */
#define real double
#define DTYPE YLM_DOUBLE
#define SUMS(w, n, out, a, b, c, d)                                                                \
  for (size_t i_ = 0; i_ < (n); i_++) (out)[i_] = (a)[i_] * (b)[i_] + (c)[i_] * (d)[i_]
#define PROFILE(w, cap, times, v) profile_plain((w)->rings, cap, times, (w)->rows, v)
#define EVEN ylm__shadow_even_d
#define BLOCK ylm__shadow_block_d
#define BLOCK_FREE ylm__shadow_block_free_d
#include "block.h"
