/* low_float.isa.c - low degrees in float; see low_kernel.h. */
#define YLM_REAL_IS_FLOAT
#include "low_kernel.h"
