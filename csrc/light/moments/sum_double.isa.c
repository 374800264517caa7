/* sum_double.isa.c - sums over lights in double, one by one and by a tree. */
#include "../tree/tree_kernel.h"
#include "sum_kernel.h"
