/* kernels.c - the choice of kernels. */
#include "kernels.h"

#include "ylm_sets.h"

#define X(name)                                                                                    \
  YLM_KERNEL_CHOICE(const material_kernels, ylm__material_##name##_kernels, ylm_k_material_##name, \
                    &ylm__material_##name##_plain);
MATERIAL_KERNELS(X)
