/* stack.c - many matrices, each applied to rows of its own. */
#include "../calibration.h"
#include "ylm_sh.h"

/* Sums that do not wait for one another: a vector of them. */
enum { LANES = 16 };

#define DOT(name, type)                                                                            \
  static type name(size_t n, const type *a, const type *b) {                                       \
    type s[LANES] = {0}, all = 0;                                                                  \
    size_t k = 0;                                                                                  \
    for (; k + LANES <= n; k += LANES)                                                             \
      for (size_t i = 0; i < LANES; i++) s[i] += a[k + i] * b[k + i];                              \
    for (; k < n; k++) all += a[k] * b[k];                                                         \
    for (size_t i = 0; i < LANES; i++) all += s[i];                                                \
    return all;                                                                                    \
  }
DOT(dot_f, float)
DOT(dot_d, double)

typedef struct job {
  size_t a, b, period, rows;
  ylm_dtype t;
  const char *matrix, *in;
  char *out;
} job;

/* Matrices begin .. end-1. */
static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t size = ylm_dtype_size(j->t), row = j->b * size;
  for (size_t i = begin; i < end; i++)
    for (size_t r = 0; r < j->rows; r++) {
      const void *x = j->in + ((i % j->period) * j->rows + r) * row;
      size_t to = (i * j->rows + r) * j->a;
      for (size_t k = 0; k < j->a; k++) {
        const void *m = j->matrix + (i * j->a + k) * row;
        if (j->t == YLM_DOUBLE)
          ((double *)(void *)j->out)[to + k] = dot_d(j->b, m, x);
        else
          ((float *)(void *)j->out)[to + k] = dot_f(j->b, m, x);
      }
    }
  return YLM_OK;
}

ylm_status ylm_sh_matrices_apply(size_t n, size_t a, size_t b, ylm_dtype t, const void *matrix,
                                 size_t period, size_t rows, const void *in, void *out, int threads,
                                 const ylm_progress *progress) {
  job j = {a, b, period, rows, t, matrix, in, out};
  return ylm_parallel(n, STACK_GRAIN, threads, run, &j, progress, "transfer");
}
