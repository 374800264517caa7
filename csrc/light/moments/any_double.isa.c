/* any_double.isa.c - the moment kernels in double for every lmax that has none of its own. */
#include "general.h"
