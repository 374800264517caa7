/* exponential_double.c - approximate exponentials, in double; see exponential_kernel.h. */
#define real double
#define DTYPE YLM_DOUBLE
#define EXPONENTIAL ylm__sh_exponential_d
#include "exponential_kernel.h"
