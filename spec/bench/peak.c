/*
** peak.c - what this machine can do: multiply-adds a nanosecond for each instruction set, and bytes
** stored a nanosecond by the size of what is written. The other benchmarks are fractions of this.
*/
#include "bench.h"

#if defined(__x86_64__)
#include <immintrin.h>

#define ROUNDS 200

/*
** ROUNDS x `chains` independent multiply-adds of one vector type: enough of them to hide the
*latency
** of two units, few enough to stay in registers (the asm that touches them keeps the compiler from
** seeing through, and no address of them is taken).
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
} peaks[] = {{YLM_ISA_sse2, float_sse2, double_sse2, 16, 12},
             {YLM_ISA_avx2, float_avx2, double_avx2, 32, 12},
             {YLM_ISA_avx512, float_avx512, double_avx512, 64, 24}};

static void multiply_adds(void) {
  _Alignas(64) char sink[64];
  printf("multiply-adds per ns, one thread\n%-8s %8s %8s\n", "kernel", "float", "double");
  for (size_t i = 0; i < sizeof peaks / sizeof *peaks; i++) {
    if (!ylm_isa_available(peaks[i].isa)) continue;
    double n = 1e-9 * peaks[i].chains * ROUNDS * peaks[i].bytes;
    printf("%-8s %8.1f %8.1f\n", ylm_isa_name(peaks[i].isa),
           n / 4 / bench_seconds(peaks[i].in_float, sink),
           n / 8 / bench_seconds(peaks[i].in_double, sink));
  }
}
#else
static void multiply_adds(void) { printf("multiply-adds: not measured on this processor\n"); }
#endif

typedef struct block {
  char *p;
  size_t size;
} block;

static void store(void *context) {
  block *b = context;
  memset(b->p, 1, b->size);
  __asm__ volatile("" : : "r"(b->p) : "memory");
}

static void bandwidth(void) {
  static const size_t sizes[] = {16 << 10, 256 << 10, 4 << 20, 64 << 20};
  printf("stores, bytes per ns, one thread\n");
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
    block b = {ylm_alloc(sizes[i], 1), sizes[i]};
    if (!b.p) return;
    printf("%8zu KiB %8.1f\n", sizes[i] >> 10, (double)sizes[i] / bench_seconds(store, &b) * 1e-9);
    ylm_free(b.p);
  }
}

int main(void) {
  multiply_adds();
  bandwidth();
  return 0;
}
