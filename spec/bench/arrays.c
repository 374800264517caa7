/*
** arrays.c - milliseconds of arithmetic of arrays beside copies of the memory that it reads and writes.
**
** A sum of 10^7 floats reads two arrays and writes one. "fresh" is memory that the system gives anew,
** as a result of Lua is.
*/
#include "bench.h"
#include "ylm_numbers.h"

typedef struct job {
  size_t n;
  float *a, *b, *c;
  int threads;
} job;

static void copy_three(void *context) {
  job *j = context;
  memcpy(j->c, j->a, j->n * sizeof *j->c);
  memcpy(j->c, j->b, j->n * sizeof *j->c);
  memcpy(j->a, j->b, j->n * sizeof *j->c);
}

static void copy_fresh(void *context) {
  job *j = context;
  for (int i = 0; i < 3; i++) ylm_free(ylm_alloc_copy(i & 1 ? j->a : j->b, j->n, sizeof *j->a));
}

static void add_to(job *j, float *out, const float *b, size_t extent) {
  size_t shape[1] = {j->n}, other[1] = {extent};
  ylm_numbers x = {YLM_FLOAT, 1, shape, j->a}, y = {YLM_FLOAT, 1, other, b};
  ylm_numbers_combine(YLM_COMBINE_add, &x, &y, YLM_FLOAT, out, j->threads);
}

static void add(void *context) {
  job *j = context;
  add_to(j, j->c, j->b, j->n);
}

static void add_fresh(void *context) {
  job *j = context;
  float *out = ylm_alloc(j->n, sizeof *out);
  if (out) add_to(j, out, j->b, j->n);
  ylm_free(out);
}

static void add_number(void *context) {
  job *j = context;
  add_to(j, j->c, j->b, 1);
}

static void add_rows(void *context) {
  job *j = context;
  size_t shape[2] = {j->n / 4, 4}, other[1] = {4};
  ylm_numbers x = {YLM_FLOAT, 2, shape, j->a}, y = {YLM_FLOAT, 1, other, j->b};
  ylm_numbers_combine(YLM_COMBINE_add, &x, &y, YLM_FLOAT, j->c, j->threads);
}

static void sum(void *context) {
  job *j = context;
  double x;
  ylm_numbers_reduce(YLM_REDUCE_sum, YLM_FLOAT, 1, j->n, 1, j->a, &x);
}

static void sum_rows(void *context) {
  job *j = context;
  double x[4];
  ylm_numbers_reduce(YLM_REDUCE_sum, YLM_FLOAT, 1, j->n / 4, 4, j->a, x);
}

static void to_half(void *context) {
  job *j = context;
  ylm_numbers_convert(YLM_FLOAT, YLM_FLOAT16, j->n, j->a, j->c, NULL);
}

int main(void) {
  static const struct {
    const char *name;
    bench_fn *fn, *beside;
  } rows[] = {{"a + b into memory that is there", add, copy_three},
              {"a + b into fresh memory", add_fresh, copy_fresh},
              {"a + number", add_number, copy_three},
              {"rows of 4 + one row", add_rows, copy_three},
              {"a:sum(), compensated", sum, copy_three},
              {"rows of 4, summed by column", sum_rows, copy_three},
              {"float to float16", to_half, copy_three}};
  job j = {.n = bench_is_quick() ? 1000000 : 10000000};
  j.a = ylm_alloc(j.n, sizeof *j.a), j.b = ylm_alloc(j.n, sizeof *j.b);
  j.c = ylm_alloc(j.n, sizeof *j.c);
  if (!j.a || !j.b || !j.c) return 1;
  for (size_t i = 0; i < j.n; i++) j.a[i] = (float)i * 1e-3f, j.b[i] = 1, j.c[i] = 0;
  printf("%zu floats: ms by the clock, and over a copy of three such arrays (fresh: into fresh "
         "memory)\n\n",
         j.n);
  printf("%-32s %11s %7s %11s %7s\n", "", "one thread", "", "two", "");
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    printf("%-32s", rows[i].name);
    for (j.threads = 1; j.threads <= 2; j.threads++) {
      double copy = bench_wall(rows[i].beside, &j), t = bench_wall(rows[i].fn, &j);
      printf(" %11.2f %7.2f", 1e3 * t, t / copy);
    }
    printf("\n");
  }
  ylm_free(j.a), ylm_free(j.b), ylm_free(j.c);
  return 0;
}
