/* rotate_times.c - rows that are turned each by its point's rotation, then multiplied by its point's factor. */
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

/* Whether kernels do both in one pass. */
static bool in_one(const job *j) {
  return j->p->kernels && j->q->method == YLM_SH_PRODUCT_quadrature && j->q->factors == 2 &&
         j->q->lmax <= ROTATE_TIMES_LMAX;
}

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

ylm_status ylm_sh_rotate_times(const ylm_sh_rotator *p, const ylm_sh_product *q, ylm_dtype t,
                               size_t n, const void *r, int rows, bool halves, const void *in,
                               const void *const *factor, void *out, double *stage, ylm_error *e) {
  int most = p->lmax < YLM_SH_ROTATE_EACH_LMAX ? p->lmax : YLM_SH_ROTATE_EACH_LMAX;
  if (q->lmax > most)
    return ylm_fail(e, YLM_ERANGE, "the product's lmax must be at most %d, got %d", most, q->lmax);
  if (q->factors != 2)
    return ylm_fail(e, YLM_ERANGE, "a product of 2 factors expected, got %d", q->factors);
  if (rows < 1) return ylm_fail(e, YLM_ERANGE, "rows must be at least 1, got %d", rows);
  if (n == 0) return YLM_OK;
  size_t L = (size_t)q->lmax, count = (L + 1) * (L + 1), m = 0,
         *point = ylm_alloc(n, sizeof *point);
  job j = {p,
           q,
           t,
           ylm_dtype_size(t),
           halves ? (L + 1) * (L + 2) / 2 : count,
           count,
           r,
           rows,
           halves,
           in,
           factor,
           out};
  double start = ylm_seconds(), seconds[2] = {0, 0};
  if (!point) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++)
    if (factor[i]) point[m++] = i;
  bool one = m > 0 && in_one(&j);
  ylm_status s = one ? turn_others(&j, n, e) : turn(&j, 0, n, e);
  seconds[0] = ylm_seconds() - start;
  if (s == YLM_OK && one) s = pass(&j, m, point, seconds);
  start = ylm_seconds();
  if (s == YLM_OK && m && !one) s = multiply(&j, m, point);
  seconds[1] += ylm_seconds() - start;
  for (int i = 0; stage && i < 2; i++) stage[i] += seconds[i];
  ylm_free(point);
  return s;
}
