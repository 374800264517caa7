/* eval_float.isa.c - evaluation in float; see sh_kernel.h. */
#define YLM_REAL_IS_FLOAT
#include "sh_kernel.h"
