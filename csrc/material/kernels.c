/* kernels.c - the choice of kernels. */
#include "kernels.h"

#include "ylm_sets.h"

#define X(name)                                                                                    \
  YLM_SETS_DECLARE(const material_kernels, ylm_k_material_##name)                                  \
  const material_kernels *ylm__material_##name##_kernels(void) {                                   \
    switch (ylm_isa_current()) {                                                                   \
      YLM_SETS_RETURN(&ylm_k_material_##name)                                                      \
    default: return &ylm__material_##name##_plain;                                                 \
    }                                                                                              \
  }
MATERIAL_KERNELS(X)
