/* kernels.c - the choice of kernels. */
#include "kernels.h"

#include "ylm_base.h"

#define DECLARE(name, isa) extern const material_kernels ylm_k_material_##name##_##isa;
#define CASE(name, isa)                                                                            \
  case YLM_ISA_##isa:                                                                              \
    return &ylm_k_material_##name##_##isa;

#if defined(__x86_64__)
#define EACH(F, name) F(name, sse2) F(name, avx2) F(name, avx512)
#elif defined(__aarch64__)
#define EACH(F, name) F(name, neon)
#else
#define EACH(F, name)
#endif

#define X(name)                                                                                    \
  EACH(DECLARE, name)                                                                              \
  const material_kernels *ylm__material_##name##_kernels(void) {                                   \
    switch (ylm_isa_current()) {                                                                   \
      EACH(CASE, name)                                                                             \
    default: return &ylm__material_##name##_plain;                                                 \
    }                                                                                              \
  }
MATERIAL_KERNELS(X)
