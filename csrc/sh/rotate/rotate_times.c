/* rotate_times.c - rows that are turned each by its point's rotation, then multiplied by its point's factor and lit. */
#include "ylm_sh.h"

#include <string.h>

#include "../product/product.h"
#include "rotate.h"

typedef struct job {
  const ylm_sh_rotator *p;
  const ylm_sh_product *q;
  ylm_dtype t;
  size_t size, width, count; /* of a number; of a row of `in`, of `out` */
  const char *r;
  int rows;
  bool halves;
  const char *in;
  const void *const *factor;
  char *out;
} job;

bool ylm_sh_rotate_in_one(const ylm_sh_rotator *p, const ylm_sh_product *q) {
  return p->kernels && q->method == YLM_SH_PRODUCT_quadrature && q->factors == 2 &&
         q->lmax <= ROTATE_TIMES_LMAX;
}

static bool in_one(const job *j) { return ylm_sh_rotate_in_one(j->p, j->q); }

/* The points that have a factor, which are `point`, in one pass. */
static ylm_status pass(const job *j, size_t n, const size_t *point, double *stage) {
  const ylm__rotate_kernels *k = j->p->kernels;
  size_t lanes = (size_t)(j->t == YLM_DOUBLE ? k->d->lanes : k->f->lanes);
  size_t numbers = 2 * ((size_t)j->rows + 2) * j->count * lanes;
  void *room = ylm_alloc(numbers + product_shared_scratch(j->q, lanes), j->size);
  if (!room) return YLM_ENOMEM;
  if (j->t == YLM_DOUBLE)
    k->d->times(j->p, j->q, n, point, (const double *)j->r, j->rows, j->halves,
                (const double *)j->in, (const double *const *)j->factor, (double *)j->out, room,
                stage);
  else
    k->f->times(j->p, j->q, n, point, (const float *)j->r, j->rows, j->halves, (const float *)j->in,
                (const float *const *)j->factor, (float *)j->out, room, stage);
  ylm_free(room);
  return YLM_OK;
}

/* Turns points from .. behind - 1. */
static ylm_status turn(const job *j, size_t from, size_t behind, ylm_error *e) {
  size_t rows = (size_t)j->rows, at = from * rows;
  return ylm_sh_rotate_each(j->p, j->q->lmax, j->t, behind - from, j->r + 9 * from * j->size,
                            j->rows, j->halves, j->in + at * j->width * j->size,
                            j->out + at * j->count * j->size, 1, NULL, e);
}

/* Turns the points that have no factor, run by run. */
static ylm_status turn_others(const job *j, size_t n, ylm_error *e) {
  ylm_status s = YLM_OK;
  for (size_t i = 0, behind; s == YLM_OK && i < n; i = behind) {
    for (behind = i + 1; behind < n && !j->factor[behind] == !j->factor[i];) behind++;
    if (!j->factor[i]) s = turn(j, i, behind, e);
  }
  return s;
}

/* Rows of `out`, turned already, times factors. */
static ylm_status multiply(const job *j, size_t n, const size_t *point) {
  size_t rows = (size_t)j->rows, bytes = j->count * j->size;
  char *a = ylm_alloc(3 * n, bytes), *b = a + n * bytes, *ab = b + n * bytes;
  ylm_status s = a ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) memcpy(b + i * bytes, j->factor[point[i]], bytes);
  for (size_t k = 0; s == YLM_OK && k < rows; k++) {
    for (size_t i = 0; i < n; i++)
      memcpy(a + i * bytes, j->out + (point[i] * rows + k) * bytes, bytes);
    s = ylm_sh_product_apply(j->q, j->t, n, (const void *[]){a, b}, NULL, ab, 1, NULL, NULL);
    for (size_t i = 0; s == YLM_OK && i < n; i++)
      memcpy(j->out + (point[i] * rows + k) * bytes, ab + i * bytes, bytes);
  }
  ylm_free(a);
  return s;
}

/* The job, checked. */
static ylm_status begin(const job *given, job *j, ylm_error *e) {
  int top = given->p->lmax, most = top < YLM_SH_ROTATE_EACH_LMAX ? top : YLM_SH_ROTATE_EACH_LMAX;
  size_t L = (size_t)given->q->lmax;
  *j = *given;
  if (j->q->lmax > most)
    return ylm_fail(e, YLM_ERANGE, "the product's lmax must be at most %d, got %d", most,
                    j->q->lmax);
  if (j->q->factors != 2)
    return ylm_fail(e, YLM_ERANGE, "a product of 2 factors expected, got %d", j->q->factors);
  if (j->rows < 1) return ylm_fail(e, YLM_ERANGE, "rows must be at least 1, got %d", j->rows);
  j->size = ylm_dtype_size(j->t);
  j->count = (L + 1) * (L + 1);
  j->width = j->halves ? (L + 1) * (L + 2) / 2 : j->count;
  return YLM_OK;
}

ylm_status ylm_sh_rotate_times(const ylm_sh_rotator *p, const ylm_sh_product *q, ylm_dtype t,
                               size_t n, const void *r, int rows, bool halves, const void *in,
                               const void *const *factor, void *out, double *stage, ylm_error *e) {
  job j;
  ylm_status s = begin(&(job){.p = p,
                              .q = q,
                              .t = t,
                              .r = r,
                              .rows = rows,
                              .halves = halves,
                              .in = in,
                              .factor = factor,
                              .out = out},
                       &j, e);
  if (s != YLM_OK || n == 0) return s;
  size_t m = 0, *point = ylm_alloc(n, sizeof *point);
  double start = ylm_seconds(), seconds[2] = {0, 0};
  if (!point) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++)
    if (factor[i]) point[m++] = i;
  bool one = m > 0 && in_one(&j);
  s = one ? turn_others(&j, n, e) : turn(&j, 0, n, e);
  seconds[0] = ylm_seconds() - start;
  if (s == YLM_OK && one) s = pass(&j, m, point, seconds);
  start = ylm_seconds();
  if (s == YLM_OK && m && !one) s = multiply(&j, m, point);
  seconds[1] += ylm_seconds() - start;
  for (int i = 0; stage && i < 2; i++) stage[i] += seconds[i];
  ylm_free(point);
  return s;
}

/* -- integrals ---------------------------------------------------------------------------------- */

/* Integrals of the m points `point`, of which all or none have factors, in one pass. */
static ylm_status integrate(const job *j, size_t m, const size_t *point, bool factors,
                            const void *const *light, const void *mix, void *out, double *stage) {
  const ylm__rotate_kernels *k = j->p->kernels;
  size_t lanes = (size_t)(j->t == YLM_DOUBLE ? k->d->lanes : k->f->lanes);
  size_t numbers = (2 * ((size_t)j->rows + 1) + 1) * j->count * lanes;
  size_t nodes = (size_t)j->q->half * (size_t)j->q->azimuths / 4 * 24;
  void *room = ylm_alloc(numbers + product_shared_scratch(j->q, lanes) + nodes, j->size);
  if (!room) return YLM_ENOMEM;
  if (j->t == YLM_DOUBLE)
    k->d->integrate(j->p, j->q, m, point, (const double *)j->r, j->rows, j->halves,
                    (const double *)j->in, factors ? (const double *const *)j->factor : NULL,
                    (const double *const *)light, mix, out, room, stage);
  else
    k->f->integrate(j->p, j->q, m, point, (const float *)j->r, j->rows, j->halves,
                    (const float *)j->in, factors ? (const float *const *)j->factor : NULL,
                    (const float *const *)light, mix, out, room, stage);
  ylm_free(room);
  return YLM_OK;
}

/* Points that have factors, then those that have none. */
static ylm_status integrate_all(const job *j, size_t n, const void *const *light, const void *mix,
                                void *out, double *stage) {
  size_t m = 0, others = n, *point = ylm_alloc(n, sizeof *point);
  if (!point) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++)
    if (j->factor[i]) point[m++] = i;
  for (size_t i = n; i > 0; i--)
    if (!j->factor[i - 1]) point[--others] = i - 1;
  ylm_status s = m ? integrate(j, m, point, true, light, mix, out, stage) : YLM_OK;
  if (s == YLM_OK && m < n) s = integrate(j, n - m, point + m, false, light, mix, out, stage);
  ylm_free(point);
  return s;
}

/* Integrals by products, then sums. */
static ylm_status integrate_rows(const job *j, size_t n, const void *const *light, const void *mix,
                                 void *out, double *stage, ylm_error *e) {
  size_t rows = (size_t)j->rows;
  char *to = ylm_alloc(n * rows * j->count, j->size);
  if (!to) return YLM_ENOMEM;
  ylm_status s = ylm_sh_rotate_times(j->p, j->q, j->t, n, j->r, j->rows, j->halves, j->in,
                                     j->factor, to, stage, e);
  for (size_t i = 0; s == YLM_OK && i < 3 * n; i++) {
    double sum = 0;
    for (size_t k = 0; k < rows; k++) {
      double one = 0;
      const char *row = to + (i / 3 * rows + k) * j->count * j->size;
      for (size_t a = 0; a < j->count; a++)
        one += ylm_get(j->t, row, a) * ylm_get(j->t, light[i % 3], a);
      sum += ylm_get(j->t, mix, i % 3 * 3 + k) * one;
    }
    ylm_put(j->t, out, i, sum);
  }
  ylm_free(to);
  return s;
}

ylm_status ylm_sh_rotate_integrate(const ylm_sh_rotator *p, const ylm_sh_product *q, ylm_dtype t,
                                   size_t n, const void *r, int rows, bool halves, const void *in,
                                   const void *const *factor, const void *const *light,
                                   const void *mix, void *out, double *stage, ylm_error *e) {
  job j;
  double seconds[2] = {0, 0};
  ylm_status s = begin(&(job){.p = p,
                              .q = q,
                              .t = t,
                              .r = r,
                              .rows = rows,
                              .halves = halves,
                              .in = in,
                              .factor = factor},
                       &j, e);
  if (s == YLM_OK && rows > 3) s = ylm_fail(e, YLM_ERANGE, "rows must be at most 3, got %d", rows);
  if (s != YLM_OK || n == 0) return s;
  s = in_one(&j) ? integrate_all(&j, n, light, mix, out, seconds)
                 : integrate_rows(&j, n, light, mix, out, seconds, e);
  for (int i = 0; stage && i < 2; i++) stage[i] += seconds[i];
  return s;
}
