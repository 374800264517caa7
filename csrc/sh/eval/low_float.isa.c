/* low_float.isa.c - low degrees in float; see low_kernel.h. */
#define SH_FLOAT
#include "low_kernel.h"
