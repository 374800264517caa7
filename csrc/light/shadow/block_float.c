/* block_float.c - light behind casters, in float; see block.h. */
#define real float
#define DTYPE YLM_FLOAT
#define SUMS(w, n, out, a, b, c, d) (w)->sums(n, out, a, b, c, d)
#define PROFILE(w, cap, times, v)                                                                  \
  ((w)->profile ? (w)->profile : profile_plain)((w)->rings, cap, times, (w)->rows, v)
#define EVEN ylm__shadow_even_f
#define BLOCK ylm__shadow_block_f
#define BLOCK_FREE ylm__shadow_block_free_f
#include "block.h"
