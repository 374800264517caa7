/*
** storm.c - a fuzz target with random mutations, in one process, of the library as it is built: many inputs a second, and no
** sanitizers.
**
**   storm RUNS SEED LARGEST files...
**
** Files larger than LARGEST bytes are left out. An input that ends in a trap is written to storm-input first, in the folder where
** it runs (BUILD/fuzz). RUNS 0 tries the files as they are.
*/
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ylm_base.h"

#define GROWTH 64 /* bytes that an input may grow by */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);
extern size_t fuzz_accepted;

typedef struct seed {
  unsigned char *data;
  size_t size;
} seed;

static ylm_rng rng;
static const uint8_t *input; /* that is tried */
static size_t input_size;

static uint32_t below(size_t n) { return (uint32_t)(ylm_rng_double(&rng) * (double)n); }

/* One to four changes: a bit, a byte, a number that is one more or less, bytes of another place, zeros. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room) {
  if (!size) return 0;
  for (uint32_t n = 1 + below(4); n; n--) {
    size_t at = below(size), span = 1 + below(16), left = size - at;
    if (span > left) span = left;
    switch (below(6)) {
    case 0: data[at] ^= (uint8_t)(1u << below(8)); break;
    case 1: data[at] = (uint8_t)below(256); break;
    case 2: data[at] = (uint8_t)(data[at] + (below(2) ? 1 : -1)); break;
    case 3: memmove(data + at, data + below(size - span + 1), span); break;
    case 4: memset(data + at, below(2) ? 0 : 255, span); break;
    default:
      if (below(8) == 0) size = 1 + below(size + GROWTH < room ? size + GROWTH : room);
    }
  }
  return size;
}

static void keep_input(int signal_) {
  FILE *f = fopen("storm-input", "wb");
  if (f) fwrite(input, 1, input_size, f), fclose(f);
  signal(signal_, SIG_DFL);
  raise(signal_);
}

int main(int n, char **arg) {
  if (n < 5) return 2;
  uint64_t runs = strtoull(arg[1], NULL, 10);
  size_t largest = strtoull(arg[3], NULL, 10), seeds = 0;
  seed *s = ylm_alloc((size_t)n, sizeof *s);
  uint8_t *copy = ylm_alloc_zero(largest + GROWTH, 1);
  if (!s || !copy) return 1;
  for (int i = 4; i < n; i++)
    if (ylm_file_read(arg[i], largest, &s[seeds].data, &s[seeds].size, NULL) == YLM_OK) seeds++;
  if (!seeds) return 1;
  for (size_t i = 0; !runs && i < seeds; i++) LLVMFuzzerTestOneInput(s[i].data, s[i].size);
  ylm_rng_seed(&rng, strtoull(arg[2], NULL, 10), 0);
  signal(SIGILL, keep_input), signal(SIGSEGV, keep_input), signal(SIGBUS, keep_input);
  signal(SIGFPE, keep_input), signal(SIGABRT, keep_input), signal(SIGALRM, keep_input);
  double begin = ylm_seconds();
  for (uint64_t i = 0; i < runs; i++) {
    const seed *from = &s[below(seeds)];
    memcpy(copy, from->data, from->size);
    input_size =
        LLVMFuzzerCustomMutator(copy, from->size, largest + GROWTH, (unsigned)ylm_rng_u32(&rng));
    input = copy;
    alarm(20); /* no input takes as long */
    LLVMFuzzerTestOneInput(copy, input_size);
    if ((i + 1) % 100000 == 0 || i + 1 == runs) {
      printf("%llu inputs of %zu seeds, %zu accepted, %.0f a second\n", (unsigned long long)(i + 1),
             seeds, fuzz_accepted, (double)(i + 1) / (ylm_seconds() - begin));
      fflush(stdout);
    }
  }
  return 0;
}
