/* slice.isa.c - the inner loops of slices, once per instruction set. */
#include "ylm_simd.h"

#include "slice_kernel.h"

extern const slice_kernels YLM_KERNEL(ylm_k_material_slice);
const slice_kernels YLM_KERNEL(ylm_k_material_slice) = {slice_places, slice_sums};
