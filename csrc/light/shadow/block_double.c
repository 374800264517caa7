/* block_double.c - light behind casters, in double; see block.h. */
#define real double
#define DTYPE YLM_DOUBLE
#define SQRT sqrt
#define ATAN2 atan2
#define BLOCK ylm__shadow_block_d
#include "block.h"
