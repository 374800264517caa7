/*
** exponential_kernel.h - approximate exponentials for the element type `real`; exponential_float.c and
** exponential_double.c include it.
**
** Functions are kept derivative by derivative, [rows][m][count], so that products take m rows at once.
*/
#include <math.h>
#include <string.h>

#include "circles.h"

typedef struct work {
  const ylm_sh_exponential *p;
  size_t m, rows, count, wide; /* functions; 1 or 4; coefficients; m count */
  real *f;                     /* [rows][m][count] without f_00, scaled */
  real *e;                     /* [rows][m][count] the exponential */
  real *next, *other;          /* [m][count] */
  size_t at[EXPONENTIAL_ROWS]; /* the place of function i in the call */
  double scale[EXPONENTIAL_ROWS];
  int halved[EXPONENTIAL_ROWS]; /* q */
} work;

/* to [n][count] = a b */
static ylm_status times(const work *w, size_t n, const real *a, const real *b, real *to) {
  const void *factor[2] = {a, b};
  return ylm_sh_product_apply(w->p->product, DTYPE, n, factor, NULL, to, 1, NULL, NULL);
}

static double norm(size_t n, const real *x) {
  double s = 0;
  for (size_t i = 0; i < n; i++) s += (double)x[i] * (double)x[i];
  return sqrt(s);
}

/* -- PS --------------------------------------------------------------------------------------- */

static ylm_status diverges(const work *w, int k, const real *term, ylm_error *e) {
  for (size_t i = 0; i < w->m; i++) {
    double size = norm(w->count, term + i * w->count);
    if (!(size <= SERIES_DIVERGES * SQRT_4PI))
      return ylm_fail(e, YLM_ERANGE,
                      "row %zu: the series diverges: term %d is %.2g times the first, the norm "
                      "without c(0,0) is %.3g",
                      w->at[i] + 1, k, size / SQRT_4PI, norm(w->count, w->f + i * w->count));
  }
  return YLM_OK;
}

/* term: [rows][m][count], terms of e and its derivatives */
static ylm_status series(work *w, real *term, ylm_error *e) {
  size_t all = w->rows * w->wide;
  memcpy(w->e, w->f, all * sizeof(real));
  memcpy(term, w->f, all * sizeof(real));
  for (size_t i = 0; i < w->m; i++) w->e[i * w->count] += (real)SQRT_4PI;
  ylm_status s = YLM_OK;
  for (int k = 2; k <= w->p->terms && s == YLM_OK; k++) {
    for (size_t d = w->rows; d-- > 0 && s == YLM_OK;) {
      real *to = term + d * w->wide;
      s = times(w, w->m, w->f, to, w->next);
      if (d && s == YLM_OK) s = times(w, w->m, w->f + d * w->wide, term, w->other);
      for (size_t i = 0; i < w->wide && s == YLM_OK; i++) {
        to[i] = (w->next[i] + (d ? w->other[i] : 0)) / (real)k;
        w->e[d * w->wide + i] += to[i];
      }
    }
    if (s == YLM_OK) s = diverges(w, k, term, e);
  }
  return s;
}

/* -- OL, HYB ----------------------------------------------------------------------------------- */

/* e = a 1 + b f */
static void line(work *w, size_t i) {
  const ylm_sh_exponential *p = w->p;
  real *f = w->f + i * w->count, *to = w->e + i * w->count;
  double size = norm(w->count, f), slope[2] = {0, 0}, x[2];
  bool beyond = size >= p->reach;
  for (size_t k = 0; k < 2; k++) {
    double step = (LINES - 1) / p->reach;
    x[k] = table_at(p->lines, LINES, 2, k, beyond ? LINES - 1 : size * step, &slope[k]);
    slope[k] = beyond || !(size > 0) ? 0 : slope[k] * step / size;
  }
  for (size_t k = 0; k < w->count; k++) to[k] = (real)x[1] * f[k];
  to[0] += (real)(SQRT_4PI * x[0]);
  for (size_t d = 1; d < w->rows; d++) {
    const real *g = f + d * w->wide;
    real *out = to + d * w->wide;
    double along = 0;
    for (size_t k = 0; k < w->count; k++) along += (double)f[k] * (double)g[k];
    for (size_t k = 0; k < w->count; k++)
      out[k] = (real)x[1] * g[k] + (real)(slope[1] * along) * f[k];
    out[0] += (real)(SQRT_4PI * slope[0] * along);
  }
}

/* Squares the first n functions. */
static ylm_status square(work *w, size_t n) {
  ylm_status s = YLM_OK;
  for (size_t d = w->rows; d-- > 0 && s == YLM_OK;) {
    real *to = w->e + d * w->wide;
    s = times(w, n, w->e, to, w->next);
    for (size_t i = 0; i < n * w->count && s == YLM_OK; i++) to[i] = (d ? 2 : 1) * w->next[i];
  }
  return s;
}

static ylm_status lines(work *w) {
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < w->m; i++) line(w, i);
  for (int k = 1; s == YLM_OK; k++) {
    size_t n = 0; /* those of the most squares come first */
    while (n < w->m && w->halved[n] >= k) n++;
    if (!n) break;
    s = square(w, n);
  }
  return s;
}

/* -- rows --------------------------------------------------------------------------------------- */

/* How often a function is halved. */
static int halvings(const ylm_sh_exponential *p, double size) {
  double most = p->reach < YLM_SH_EXP_HALVED ? p->reach : YLM_SH_EXP_HALVED;
  if (p->method != YLM_SH_EXP_HYB || !(size > most)) return 0;
  return size < 1e18 ? (int)ceil(log2(size / most)) : 64;
}

/* Loads functions into their places: those of the most squares first. */
static void load(work *w, size_t begin, const real *in) {
  int q[EXPONENTIAL_ROWS], most = 0;
  for (size_t i = 0; i < w->m; i++) {
    const real *f = in + (begin + i) * w->rows * w->count;
    q[i] = halvings(w->p, norm(w->count - 1, f + 1));
    most = q[i] > most ? q[i] : most;
  }
  size_t to = 0;
  for (int k = most; k >= 0; k--)
    for (size_t i = 0; i < w->m; i++) {
      if (q[i] != k) continue;
      const real *f = in + (begin + i) * w->rows * w->count;
      w->at[to] = begin + i;
      w->halved[to] = k;
      w->scale[to] = exp((double)f[0] / SQRT_4PI);
      real part = (real)ldexp(1, -k);
      for (size_t d = 0; d < w->rows; d++) {
        real *x = w->f + d * w->wide + to * w->count;
        for (size_t j = 1; j < w->count; j++) x[j] = part * f[d * w->count + j];
        x[0] = 0;
      }
      to++;
    }
}

/* e^(f_00/sqrt(4 pi)) times them, to the results. */
static void store(const work *w, const real *in, real *out) {
  for (size_t i = 0; i < w->m; i++) {
    size_t at = w->at[i] * w->rows * w->count;
    for (size_t d = 0; d < w->rows; d++) {
      const real *x = w->e + i * w->count, *g = x + d * w->wide;
      double slope = d ? (double)in[at + d * w->count] / SQRT_4PI : 0;
      for (size_t k = 0; k < w->count; k++)
        out[at + d * w->count + k] = (real)(w->scale[i] * ((double)g[k] + slope * (double)x[k]));
    }
  }
}

ylm_status EXPONENTIAL(const ylm_sh_exponential *p, size_t begin, size_t end, size_t rows,
                       const real *in, real *out, real *room, ylm_error *e) {
  work w = {.p = p, .m = end - begin, .rows = rows, .count = ylm_sh_count(p->lmax)};
  w.wide = w.m * w.count;
  w.f = room;
  w.e = w.f + rows * w.wide;
  w.next = w.e + rows * w.wide;
  w.other = w.next + w.wide;
  load(&w, begin, in);
  real *term = p->method == YLM_SH_EXP_PS ? ylm_alloc(rows * w.wide, sizeof *term) : NULL;
  ylm_status s = p->method != YLM_SH_EXP_PS ? lines(&w) : term ? series(&w, term, e) : YLM_ENOMEM;
  if (s == YLM_OK) store(&w, in, out);
  ylm_free(term);
  return s;
}
