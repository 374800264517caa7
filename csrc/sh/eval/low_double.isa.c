/* low_double.isa.c - low degrees in double; see low_kernel.h. */
#include "low_kernel.h"
