/*
** peak.c - what this machine can do: multiply-adds a nanosecond for each instruction set, and bytes
** stored a nanosecond by the size of what is written. The other benchmarks are fractions of this.
*/
#include "peak.h"

static void multiply_adds(void) {
  printf("multiply-adds per ns, one thread\n%-8s %8s %8s\n", "kernel", "float", "double");
  for (int isa = 1; isa < YLM_ISA_COUNT; isa++) {
    double f = bench_peak((ylm_isa)isa, YLM_FLOAT), d = bench_peak((ylm_isa)isa, YLM_DOUBLE);
    if (f > 0) printf("%-8s %8.1f %8.1f\n", ylm_isa_name((ylm_isa)isa), f, d);
  }
}

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
