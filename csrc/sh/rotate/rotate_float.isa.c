/* rotate_float.isa.c - rotation in float; see rotate_kernel.h. */
#define YLM_REAL_IS_FLOAT
#include "rotate_kernel.h"
