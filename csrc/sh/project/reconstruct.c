/* reconstruct.c - ylm_sh_reconstruct: functions from their coefficients. */
#include "../calibration.h"
#include "../eval/sh_eval.h"

typedef struct task {
  int lmax;
  ylm_dtype t;
  size_t rows, n;
  const char *c, *p;
  char *out, *basis; /* basis: [workers][RECONSTRUCT_BLOCK][count] */
} task;

#define DOTS(type, name)                                                                           \
  /* out[i] = c . basis[i] for `points` points, four sums at a time. */                            \
  static void name(size_t count, size_t points, const type *c, const type *basis, type *out) {     \
    for (size_t i = 0; i < points; i++, basis += count) {                                          \
      type s[4] = {0, 0, 0, 0};                                                                    \
      size_t k = 0;                                                                                \
      for (; k + 4 <= count; k += 4)                                                               \
        for (size_t j = 0; j < 4; j++) s[j] += c[k + j] * basis[k + j];                            \
      for (; k < count; k++) s[0] += c[k] * basis[k];                                              \
      out[i] = (s[0] + s[1]) + (s[2] + s[3]);                                                      \
    }                                                                                              \
  }
DOTS(float, dots_float)
DOTS(double, dots_double)

static ylm_status block(void *context, size_t begin, size_t end, int worker) {
  const task *k = context;
  size_t count = ylm_sh_count(k->lmax), size = ylm_dtype_size(k->t), points = end - begin;
  char *basis = k->basis + (size_t)worker * RECONSTRUCT_BLOCK * count * size;
  ylm_status s = ylm_sh_eval(k->lmax, 0, false, k->t, points, k->p + begin * 3 * size, basis, NULL,
                             NULL, 1, NULL);
  for (size_t r = 0; s == YLM_OK && r < k->rows; r++) {
    const char *c = k->c + r * count * size;
    char *out = k->out + (r * k->n + begin) * size;
    if (k->t == YLM_DOUBLE)
      dots_double(count, points, (const double *)c, (const double *)basis, (double *)out);
    else
      dots_float(count, points, (const float *)c, (const float *)basis, (float *)out);
  }
  return s;
}

ylm_status ylm_sh_reconstruct(int lmax, ylm_dtype t, size_t rows, const void *c, size_t n,
                              const void *p, void *out, int threads, const ylm_progress *progress,
                              ylm_error *e) {
  if (lmax < 0 || lmax > YLM_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_LMAX, lmax);
  ylm_sh_how how = {.isa = -1};
  bool tame;
  ylm_status s = ylm__sh_check_points(&how, lmax, t, n, p, &tame, e);
  if (s != YLM_OK || n == 0 || rows == 0) return s;
  threads = ylm_threads(threads);
  task k = {lmax, t, rows, n, c, p, out, NULL};
  k.basis = ylm_alloc((size_t)threads * RECONSTRUCT_BLOCK * ylm_sh_count(lmax), ylm_dtype_size(t));
  if (!k.basis) return ylm_fail(e, YLM_ENOMEM, "no memory for degree %d", lmax);
  s = ylm_parallel(n, RECONSTRUCT_BLOCK, threads, block, &k, progress, "reconstruct");
  ylm_free(k.basis);
  return s == YLM_OK ? s : ylm_fail_plain(e, s);
}
