/* product_float.isa.c - products in float; see product_kernel.h. */
#define YLM_REAL_IS_FLOAT
#include "product_kernel.h"
