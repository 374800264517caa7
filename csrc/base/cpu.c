/* cpu.c - which kernels this processor runs, and which are asked for. */
#include "ylm_base.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

const char *ylm_isa_name(ylm_isa isa) {
  static const char *const names[] = {
#define X(name) #name,
      YLM_ISA_LIST(X)
#undef X
  };
  return (int)isa >= 0 && isa < YLM_ISA_COUNT ? names[isa] : "?";
}

bool ylm_isa_available(ylm_isa isa) {
  switch (isa) {
  case YLM_ISA_reference: return true;
#if defined(__x86_64__)
  case YLM_ISA_sse2: return true;
  case YLM_ISA_avx2: return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  case YLM_ISA_avx512:
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
#elif defined(__aarch64__)
  case YLM_ISA_neon: return true;
#endif
  default: return false;
  }
}

static ylm_isa choose(void) {
  const char *wish = getenv("YLM_ISA");
  ylm_isa best = YLM_ISA_reference;
  for (int i = 0; i < YLM_ISA_COUNT; i++) {
    if (!ylm_isa_available((ylm_isa)i)) continue;
    if (wish && strcmp(wish, ylm_isa_name((ylm_isa)i)) == 0) return (ylm_isa)i;
    best = (ylm_isa)i;
  }
  return best;
}

ylm_isa ylm_isa_current(void) {
  static atomic_int cached = -1; /* the same answer whoever computes it */
  int isa = atomic_load_explicit(&cached, memory_order_relaxed);
  if (isa < 0) {
    isa = choose();
    atomic_store_explicit(&cached, isa, memory_order_relaxed);
  }
  return (ylm_isa)isa;
}
