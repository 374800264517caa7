/* rotate_double.isa.c - rotation in double; see rotate_kernel.h. */
#include "rotate_kernel.h"
