/* kernel_float.isa.c - sums over virtual lights in float. */
#define YLM_REAL_IS_FLOAT
#include "kernel.h"
#include "tree/tree_kernel.h"
