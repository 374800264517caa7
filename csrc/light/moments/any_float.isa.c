/* any_float.isa.c - the moment kernels in float for every lmax that has none of its own. */
#define YLM_REAL_IS_FLOAT
#include "general.h"
