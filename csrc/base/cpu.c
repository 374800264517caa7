/* cpu.c - which kernels this processor runs, and which are asked for. */
#include "environment.h"
#include "ylm_sets.h"

#include <stdatomic.h>

const char *ylm_isa_name(ylm_isa isa) {
  static const char *const names[] = {
#define X(name) #name,
      YLM_ISA_LIST(X)
#undef X
  };
  return (int)isa >= 0 && isa < YLM_ISA_COUNT ? names[isa] : "?";
}

/* Whether this build has kernels of a set. */
static bool built(ylm_isa isa) {
  switch (isa) {
#define X(set) case YLM_ISA_##set:
    YLM_SETS(X)
#undef X
  case YLM_ISA_reference: return true;
  default: return false;
  }
}

/* Whether this processor runs them. */
static bool runs(ylm_isa isa) {
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

bool ylm_isa_available(ylm_isa isa) { return built(isa) && runs(isa); }

static ylm_isa choose(void) {
  int wish = ylm__environment_isa(NULL);
  if (wish >= 0) return (ylm_isa)wish;
  int best = YLM_ISA_COUNT - 1;
  while (!ylm_isa_available((ylm_isa)best)) best--;
  return (ylm_isa)best;
}

ylm_isa ylm_isa_current(void) {
  static atomic_int cached = -1; /* every thread computes the same answer */
  int isa = atomic_load_explicit(&cached, memory_order_relaxed);
  if (isa < 0) {
    isa = choose();
    atomic_store_explicit(&cached, isa, memory_order_relaxed);
  }
  return (ylm_isa)isa;
}
