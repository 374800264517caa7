/* circles.h - the tables of approximate exponentials. Private to the room. */
#ifndef YLM_SH_CIRCLES_H
#define YLM_SH_CIRCLES_H

#include "product.h"
#include "ylm_sh_exponential.h"

#define SQRT_4PI 3.54490770181103205459
#define CIRCLES 1024        /* angles, from 0 to 90 degrees */
#define LINES 1024          /* places of a and b, from 0 to `reach` */
#define SERIES_DIVERGES 1e6 /* a term of the series that is so many times the first */
#define EXPONENTIAL_ROWS 32 /* functions at a time */

struct ylm_sh_exponential {
  int lmax, terms;
  ylm_sh_exp_method method;
  ylm_sh_product *product;
  double *log;   /* [CIRCLES][lmax+1] */
  double *lines; /* [LINES][2]: a, b */
  double reach;
};

/* The value of a table of rows of `width` numbers at place t, 0 .. n-1, of column k, and its slope: a cubic through
   four rows, whose slope has no steps. */
static inline double table_at(const double *table, size_t n, size_t width, size_t k, double t,
                              double *slope) {
  size_t i = t <= 0 ? 0 : t >= (double)(n - 2) ? n - 2 : (size_t)t;
  double u = t - (double)i, p1 = table[i * width + k], p2 = table[(i + 1) * width + k];
  double p0 = i ? table[(i - 1) * width + k] : 2 * p1 - p2;
  double p3 = i + 2 < n ? table[(i + 2) * width + k] : 2 * p2 - p1;
  double a = p2 - p0, b = 2 * p0 - 5 * p1 + 4 * p2 - p3, c = 3 * (p1 - p2) + p3 - p0;
  *slope = (a + u * (2 * b + 3 * u * c)) / 2;
  return p1 + u * (a + u * (b + u * c)) / 2;
}

/* Functions begin .. end-1 of a call of ylm_sh_exponential_apply, EXPONENTIAL_ROWS at most; `room` has
   exponential_room numbers. exponential_float.c, exponential_double.c */
ylm_status ylm__sh_exponential_f(const ylm_sh_exponential *p, size_t begin, size_t end, size_t rows,
                                 const float *in, float *out, float *room, ylm_error *e);
ylm_status ylm__sh_exponential_d(const ylm_sh_exponential *p, size_t begin, size_t end, size_t rows,
                                 const double *in, double *out, double *room, ylm_error *e);

static inline size_t exponential_room(const ylm_sh_exponential *p, size_t rows) {
  return (2 * rows + 2) * EXPONENTIAL_ROWS * ylm_sh_count(p->lmax);
}

#endif
