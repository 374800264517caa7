/* rotate_each.c - rotation of rows that each have a rotation of their own; kernels in rotate_each.h. */
#include "ylm_sh.h"

#include <string.h>

#include "rotate.h"

typedef struct job {
  const ylm_sh_rotator *p;
  int lmax, rows;
  ylm_dtype t;
  bool halves;
  const char *r, *in;
  char *out;
} job;

/* The first of the rotations that is none; n: all are. */
static size_t not_rotation(const ylm__rotate_kernels *k, ylm_dtype t, size_t n, const void *r) {
  if (k) return t == YLM_DOUBLE ? k->d->not_rotation(n, r) : k->f->not_rotation(n, r);
  for (size_t i = 0; i < n; i++) {
    double m[9];
    for (size_t q = 0; q < 9; q++) m[q] = ylm_get(t, r, 9 * i + q);
    if (!ylm__sh_is_rotation(m, ROTATE_NEAR)) return i;
  }
  return n;
}

/* The plain form: a row is turned by the blocks of its rotation made orthonormal. */
static ylm_status turn_plainly(const job *j, size_t i) {
  size_t count = ylm_sh_count(j->lmax), L = (size_t)j->lmax;
  size_t width = j->halves ? (L + 1) * (L + 2) / 2 : count, size = ylm_dtype_size(j->t);
  double r[9];
  double(*row)[2] = ylm_alloc(count, sizeof *row);
  if (!row) return YLM_ENOMEM;
  for (size_t k = 0; k < 9; k++) r[k] = ylm_get(j->t, j->r, 9 * i + k);
  ylm__sh_orthonormal(r);
  ylm_status s = YLM_OK;
  for (int q = 0; s == YLM_OK && q < j->rows; q++) {
    size_t at = i * (size_t)j->rows + (size_t)q;
    double *in = &row[0][0], *out = in + count;
    memset(in, 0, count * sizeof *in);
    if (j->halves)
      for (int l = 0, k = 0; l <= j->lmax; l++)
        for (int m = 0; m <= l; m++, k++)
          in[l * l + l + m] = ylm_get(j->t, j->in, at * width + (size_t)k);
    else
      for (size_t k = 0; k < count; k++) in[k] = ylm_get(j->t, j->in, at * width + k);
    s = ylm_sh_rotate(j->p, r, j->lmax, YLM_DOUBLE, 1, in, out, 1, NULL, NULL);
    for (size_t k = 0; k < count; k++) ylm_put(j->t, j->out + at * count * size, k, out[k]);
  }
  ylm_free(row);
  return s;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const ylm__rotate_kernels *k = j->p->kernels;
  size_t count = ylm_sh_count(j->lmax), L = (size_t)j->lmax, size = ylm_dtype_size(j->t);
  size_t width = j->halves ? (L + 1) * (L + 2) / 2 : count, first = begin * (size_t)j->rows;
  const void *r = j->r + 9 * begin * size, *in = j->in + first * width * size;
  void *out = j->out + first * count * size;
  if (!k) {
    ylm_status s = YLM_OK;
    for (size_t i = begin; s == YLM_OK && i < end; i++) s = turn_plainly(j, i);
    return s;
  }
  if (j->t == YLM_DOUBLE)
    k->d->each(j->p, j->lmax, end - begin, r, j->rows, j->halves, in, out);
  else
    k->f->each(j->p, j->lmax, end - begin, r, j->rows, j->halves, in, out);
  return YLM_OK;
}

ylm_status ylm_sh_rotate_each(const ylm_sh_rotator *p, int lmax, ylm_dtype t, size_t n,
                              const void *r, int rows, bool halves, const void *in, void *out,
                              int threads, const ylm_progress *progress, ylm_error *e) {
  int most = p->lmax < YLM_SH_ROTATE_EACH_LMAX ? p->lmax : YLM_SH_ROTATE_EACH_LMAX;
  if (lmax < 0 || lmax > most)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", most, lmax);
  if (rows < 1) return ylm_fail(e, YLM_ERANGE, "rows must be at least 1, got %d", rows);
  size_t wrong = not_rotation(p->kernels, t, n, r);
  if (wrong < n)
    return ylm_fail(e, YLM_EDOMAIN,
                    "rotation %zu is none: its columns must be orthonormal to %g and right-handed",
                    wrong + 1, ROTATE_NEAR);
  job j = {p, lmax, rows, t, halves, r, in, out};
  size_t grain = 256;
  if (n <= grain && !progress) return run(&j, 0, n, 0);
  return ylm_parallel(n, grain, threads, run, &j, progress, "rotate");
}
