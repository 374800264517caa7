/* eval_double.isa.c - evaluation in double; see sh_kernel.h. */
#include "sh_kernel.h"
