/* any.isa.c - the moment kernels for every lmax that has none of its own. */
#define ANY_LMAX
#define LMAX YLM_LIGHT_LMAX
#define KERNEL_NAME YLM_KERNEL(ylm__moments_any)
#include "ylm_light.h"

#include "kernel.h"
