/* kernel_double.isa.c - sums over virtual lights in double. */
#include "kernel.h"
