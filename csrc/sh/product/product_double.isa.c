/* product_double.isa.c - products in double; see product_kernel.h. */
#include "product_kernel.h"
