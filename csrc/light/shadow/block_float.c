/* block_float.c - light behind casters, in float; see block.h. */
#define real float
#define DTYPE YLM_FLOAT
#define SQRT sqrtf
#define ATAN2 atan2f
#define SUMS(w, n, out, a, b, c, d) (w)->sums(n, out, a, b, c, d)
#define BLOCK ylm__shadow_block_f
#include "block.h"
