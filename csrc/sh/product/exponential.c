/*
** exponential.c - exponentials and logarithms of functions given by coefficients.
**
** M is the matrix that multiplies by f, cut off at lmax (ylm_sh_product_matrix), M = R D R'. With 1 the coefficients of the
** function 1 and q(x) = log x/(x - 1), q(1) = 1:
**
**   log f = R q(max(D, epsilon max D)) R' (f - 1)
**   exp f = e^(f_00/sqrt(4 pi)) (1 + g + g g/2 + g g g/6 ..),   g = f without f_00
**
** where each product is cut off at lmax.
**
** Source  Ren et al. 2006, "Real-time soft shadows in dynamic scenes using spherical harmonic exponentiation"
*/
#include "product.h"

#include <math.h>

#define SQRT_4PI 3.54490770181103205459
#define DIVERGES 1e6 /* a term of the series that is so many times the first */

/* log x/(x - 1) */
static double quotient(double x) {
  double d = x - 1;
  return fabs(d) < 1e-4 ? 1 - d / 2 + d * d / 3 - d * d * d / 4 : log(x) / d;
}

typedef struct job {
  int lmax;
  ylm_dtype t;
  double epsilon;
  const void *in;
  void *out;
  ylm_error *e;
  const ylm_sh_product *product;
  int terms;
} job;

/* Row r of the input in double. */
static void load(const job *j, size_t r, double *to) {
  size_t count = ylm_sh_count(j->lmax);
  for (size_t i = 0; i < count; i++) to[i] = ylm_get(j->t, j->in, r * count + i);
}

/* All rows; where one fails, one thread names the first. */
static ylm_status apply(job *j, size_t rows, size_t grain, int threads, ylm_range_fn *fn,
                        const ylm_progress *progress, const char *stage, ylm_error *e) {
  ylm_status s = ylm_parallel(rows, grain, threads, fn, j, progress, stage);
  if (s != YLM_ERANGE && s != YLM_EDOMAIN) return s;
  j->e = e;
  return fn(j, 0, rows, 0);
}

static ylm_status log_row(const job *j, size_t r, double *matrix, double *w, double *f) {
  size_t n = ylm_sh_count(j->lmax);
  load(j, r, f);
  ylm_status s = ylm_sh_product_matrix(j->lmax, f, j->lmax, matrix, j->e);
  if (s == YLM_OK) s = ylm__sh_eigen((int)n, matrix, w);
  if (s != YLM_OK) return s;
  double most = w[0];
  for (size_t i = 1; i < n; i++) most = fmax(most, w[i]);
  if (!(most > 0))
    return ylm_fail(j->e, YLM_EDOMAIN,
                    "row %zu: there is no logarithm of a function that is nowhere positive", r + 1);
  f[0] -= SQRT_4PI;
  double *part = f + n;
  for (size_t k = 0; k < n; k++) {
    part[k] = 0;
    for (size_t i = 0; i < n; i++) part[k] += matrix[i * n + k] * f[i];
    part[k] *= quotient(fmax(w[k], j->epsilon * most));
  }
  for (size_t i = 0; i < n; i++) {
    double sum = 0;
    for (size_t k = 0; k < n; k++) sum += matrix[i * n + k] * part[k];
    ylm_put(j->t, j->out, r * n + i, sum);
  }
  return YLM_OK;
}

static ylm_status run_log(void *context, size_t r, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t n = ylm_sh_count(j->lmax);
  double *room = ylm_alloc(n * n + 3 * n, sizeof *room);
  ylm_status s = room ? YLM_OK : YLM_ENOMEM;
  for (; r < end && s == YLM_OK; r++) s = log_row(j, r, room, room + n * n, room + n * n + n);
  ylm_free(room);
  return s;
}

ylm_status ylm_sh_log(int lmax, ylm_dtype t, size_t rows, double epsilon, const void *in, void *out,
                      int threads, const ylm_progress *progress, ylm_error *e) {
  if (lmax < 0 || lmax > YLM_SH_LOG_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax of a logarithm must be from 0 to %d, got %d",
                    YLM_SH_LOG_LMAX, lmax);
  job j = {.lmax = lmax, .t = t, .epsilon = epsilon, .in = in, .out = out};
  return apply(&j, rows, 1, threads, run_log, progress, "log", e);
}

static double norm(size_t n, const double *x) {
  double s = 0;
  for (size_t i = 0; i < n; i++) s += x[i] * x[i];
  return sqrt(s);
}

static ylm_status exp_row(const job *j, size_t r, double *g) {
  size_t n = ylm_sh_count(j->lmax);
  double *term = g + n, *next = term + n, *sum = next + n;
  load(j, r, g);
  double scale = exp(g[0] / SQRT_4PI), size = 0;
  g[0] = 0;
  for (size_t i = 0; i < n; i++) sum[i] = term[i] = g[i];
  sum[0] += SQRT_4PI;
  for (int k = 2; k <= j->terms; k++) {
    const void *factor[2] = {term, g};
    ylm_status s =
        ylm_sh_product_apply(j->product, YLM_DOUBLE, 1, factor, NULL, next, 1, NULL, NULL);
    if (s != YLM_OK) return s;
    for (size_t i = 0; i < n; i++) sum[i] += term[i] = next[i] / k;
    size = norm(n, term);
    if (!(size <= DIVERGES * SQRT_4PI))
      return ylm_fail(j->e, YLM_ERANGE,
                      "row %zu: the series diverges: term %d is %.2g times the first, the norm "
                      "without c(0,0) is %.3g",
                      r + 1, k, size / SQRT_4PI, norm(n, g));
  }
  for (size_t i = 0; i < n; i++) ylm_put(j->t, j->out, r * n + i, scale * sum[i]);
  return YLM_OK;
}

static ylm_status run_exp(void *context, size_t r, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  double *room = ylm_alloc(4 * ylm_sh_count(j->lmax), sizeof *room);
  ylm_status s = room ? YLM_OK : YLM_ENOMEM;
  for (; r < end && s == YLM_OK; r++) s = exp_row(j, r, room);
  ylm_free(room);
  return s;
}

ylm_status ylm_sh_exp(int lmax, ylm_dtype t, size_t rows, int terms, const void *in, void *out,
                      int threads, const ylm_progress *progress, ylm_error *e) {
  if (terms < 1 || terms > YLM_SH_EXP_TERMS)
    return ylm_fail(e, YLM_ERANGE, "1 to %d terms expected, got %d", YLM_SH_EXP_TERMS, terms);
  ylm_sh_product *product;
  ylm_status s =
      ylm_sh_product_create(lmax, 2, YLM_SH_PRODUCT_auto, YLM_SH_PRODUCT_auto, &product, e);
  if (s != YLM_OK) return s;
  job j = {.lmax = lmax, .t = t, .in = in, .out = out, .product = product, .terms = terms};
  s = apply(&j, rows, 4, threads, run_exp, progress, "exp", e);
  ylm_sh_product_free(product);
  return s;
}
