/* peak.h - multiply-adds a nanosecond that one core can do, by instruction set and element type. */
#ifndef YLM_BENCH_PEAK_H
#define YLM_BENCH_PEAK_H

#include "bench.h"

#if defined(__x86_64__)
#include <immintrin.h>

#define ROUNDS 200

/*
** ROUNDS x `chains` independent multiply-adds of one vector type: enough of them to hide the
** latency of two units, few enough to stay in registers (the asm that touches them keeps the
** compiler from seeing through, and no address of them is taken).
*/
#define PEAK(name, isa, vector, chains, reg, zero, fma)                                            \
  __attribute__((target(isa), noinline)) static void name(void *context) {                         \
    vector a[chains], m = zero, c = zero;                                                          \
    __asm__ volatile("" : "+" reg(m), "+" reg(c));                                                 \
    _Pragma("GCC unroll 24") for (int i = 0; i < chains; i++) a[i] = c;                            \
    for (int r = 0; r < ROUNDS; r++) {                                                             \
      _Pragma("GCC unroll 24") for (int i = 0; i < chains; i++) a[i] = fma;                        \
      _Pragma("GCC unroll 24") for (int i = 0; i < chains;                                         \
                                    i++) __asm__ volatile("" : "+" reg(a[i]));                     \
    }                                                                                              \
    _Pragma("GCC unroll 24") for (int i = 1; i < chains; i++) __asm__ volatile("" : : reg(a[i]));  \
    *(vector *)context = a[0];                                                                     \
  }
PEAK(float_sse2, "sse2", __m128, 12, "x", _mm_setzero_ps(), _mm_add_ps(_mm_mul_ps(a[i], m), c))
PEAK(double_sse2, "sse2", __m128d, 12, "x", _mm_setzero_pd(), _mm_add_pd(_mm_mul_pd(a[i], m), c))
PEAK(float_avx2, "avx2,fma", __m256, 12, "x", _mm256_setzero_ps(), _mm256_fmadd_ps(a[i], m, c))
PEAK(double_avx2, "avx2,fma", __m256d, 12, "x", _mm256_setzero_pd(), _mm256_fmadd_pd(a[i], m, c))
PEAK(float_avx512, "avx512f", __m512, 24, "v", _mm512_setzero_ps(), _mm512_fmadd_ps(a[i], m, c))
PEAK(double_avx512, "avx512f", __m512d, 24, "v", _mm512_setzero_pd(), _mm512_fmadd_pd(a[i], m, c))

static const struct {
  ylm_isa isa;
  bench_fn *in_float, *in_double;
  int bytes, chains;
} bench_peaks[] = {{YLM_ISA_sse2, float_sse2, double_sse2, 16, 12},
                   {YLM_ISA_avx2, float_avx2, double_avx2, 32, 12},
                   {YLM_ISA_avx512, float_avx512, double_avx512, 64, 24}};

/* Multiply-adds per ns of one thread; 0 where it is not known. */
static inline double bench_peak(ylm_isa isa, ylm_dtype t) {
  _Alignas(64) char sink[64];
  for (size_t i = 0; i < sizeof bench_peaks / sizeof *bench_peaks; i++)
    if (bench_peaks[i].isa == isa && ylm_isa_available(isa))
      return 1e-9 * bench_peaks[i].chains * ROUNDS * bench_peaks[i].bytes /
             (t == YLM_DOUBLE ? 8 : 4) /
             bench_seconds(t == YLM_DOUBLE ? bench_peaks[i].in_double : bench_peaks[i].in_float,
                           sink);
  return 0;
}
#else
static inline double bench_peak(ylm_isa isa, ylm_dtype t) {
  (void)isa, (void)t;
  return 0;
}
#endif

#endif
