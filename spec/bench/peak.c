/*
** peak.c - what this machine can do: multiply-adds a nanosecond for each instruction set, and bytes
** stored a nanosecond by the size of what is written. The other benchmarks are fractions of this.
*/
#include "bench.h"

#if defined(__x86_64__)
#include <immintrin.h>

#define CHAINS 24
#define ROUNDS 200

/* ROUNDS x CHAINS independent multiply-adds of one vector type. */
#define PEAK(name, isa, vector, fma)                                                               \
  __attribute__((target(isa), noinline)) static void name(void *context) {                         \
    vector a[CHAINS], m, c;                                                                        \
    memset(&m, 0, sizeof m), memset(&c, 0, sizeof c), memset(a, 0, sizeof a);                      \
    __asm__ volatile("" : "+x"(m), "+x"(c));                                                       \
    for (int r = 0; r < ROUNDS; r++) {                                                             \
      _Pragma("GCC unroll 24") for (int i = 0; i < CHAINS; i++) a[i] = fma;                        \
      _Pragma("GCC unroll 24") for (int i = 0; i < CHAINS; i++) __asm__ volatile("" : "+x"(a[i])); \
    }                                                                                              \
    memcpy(context, a, sizeof a[0]);                                                               \
  }
PEAK(float_sse2, "sse2", __m128, _mm_add_ps(_mm_mul_ps(a[i], m), c))
PEAK(double_sse2, "sse2", __m128d, _mm_add_pd(_mm_mul_pd(a[i], m), c))
PEAK(float_avx2, "avx2,fma", __m256, _mm256_fmadd_ps(a[i], m, c))
PEAK(double_avx2, "avx2,fma", __m256d, _mm256_fmadd_pd(a[i], m, c))
#undef PEAK
#define PEAK512(name, vector, type, fma)                                                           \
  __attribute__((target("avx512f"), noinline)) static void name(void *context) {                   \
    vector a[CHAINS], m, c;                                                                        \
    memset(&m, 0, sizeof m), memset(&c, 0, sizeof c), memset(a, 0, sizeof a);                      \
    __asm__ volatile("" : "+v"(m), "+v"(c));                                                       \
    for (int r = 0; r < ROUNDS; r++) {                                                             \
      _Pragma("GCC unroll 24") for (int i = 0; i < CHAINS; i++) a[i] = fma;                        \
      _Pragma("GCC unroll 24") for (int i = 0; i < CHAINS; i++) __asm__ volatile("" : "+v"(a[i])); \
    }                                                                                              \
    memcpy(context, a, sizeof a[0]);                                                               \
  }
PEAK512(float_avx512, __m512, float, _mm512_fmadd_ps(a[i], m, c))
PEAK512(double_avx512, __m512d, double, _mm512_fmadd_pd(a[i], m, c))

static const struct {
  ylm_isa isa;
  bench_fn *in_float, *in_double;
  int bytes;
} peaks[] = {{YLM_ISA_sse2, float_sse2, double_sse2, 16},
             {YLM_ISA_avx2, float_avx2, double_avx2, 32},
             {YLM_ISA_avx512, float_avx512, double_avx512, 64}};

static void multiply_adds(void) {
  char sink[64];
  printf("multiply-adds per ns, one thread\n%-8s %8s %8s\n", "kernel", "float", "double");
  for (size_t i = 0; i < sizeof peaks / sizeof *peaks; i++) {
    if (!ylm_isa_available(peaks[i].isa)) continue;
    double n = 1e-9 * CHAINS * ROUNDS * peaks[i].bytes;
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
