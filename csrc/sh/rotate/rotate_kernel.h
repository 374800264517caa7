/*
** rotate_kernel.h - rotation kernels, for the unit's element type: one vector by z-turns between
** quarter turns, batches by blocks, rows with rotations of their own.
*/
#include "rotate_each.h"

#ifdef YLM_REAL_IS_FLOAT
typedef ylm__rotate_kernels_float rotate_kernels;
#else
typedef ylm__rotate_kernels_double rotate_kernels;
#endif

const rotate_kernels YLM_REAL_KERNEL(ylm__rotate_kernels) = {
    one, apply, each, times, integrate, not_rotation, ROTATE_PANEL, LANES};
