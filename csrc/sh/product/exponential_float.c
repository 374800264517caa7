/* exponential_float.c - approximate exponentials, in float; see exponential_kernel.h. */
#define real float
#define DTYPE YLM_FLOAT
#define EXPONENTIAL ylm__sh_exponential_f
#include "exponential_kernel.h"
