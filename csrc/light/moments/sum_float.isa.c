/* sum_float.isa.c - sums over lights in float, one by one and by a tree. */
#define YLM_REAL_IS_FLOAT
#include "../tree/tree_kernel.h"
#include "sum_kernel.h"
