/* eval_float.isa.c - evaluation in float; see sh_kernel.h. */
#define SH_FLOAT
#include "sh_kernel.h"
