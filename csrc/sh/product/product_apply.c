/* product_apply.c - applies a plan of products to rows of coefficients, one at a time and in
 * batches. */
#include "product.h"

#include <string.h>

/* -- the plain form of the quadrature: the reference set, processors without vectors -- */

static void plain(const ylm_sh_product *p, const double *const *c, double *out) {
  const ylm__product_tables *t = &p->d;
  int lmax = p->lmax, entries = (lmax + 1) * (lmax + 2) / 2;
  memset(out, 0, ylm_sh_count(lmax) * sizeof *out);
  for (int h = 0; h < p->half; h++)
    for (int side = 1; side >= -1; side -= 2)
      for (int j = 0; j < p->azimuths; j++) {
        const double *legendre = (const double *)t->node_legendre + h * entries;
        double product = ((const double *)t->node_weights)[h];
        for (int pass = 0; pass <= p->factors; pass++) {
          double sum = 0;
          for (int l = 0; l <= lmax; l++)
            for (int m = -l; m <= l; m++) {
              int am = m < 0 ? -m : m;
              double y = legendre[l * (l + 1) / 2 + am] *
                         (m < 0 ? ylm__product_sine(am, j, p->azimuths)
                                : ylm__product_cosine(am, j, p->azimuths));
              if (side < 0 && ((l - am) & 1)) y = -y;
              if (pass < p->factors)
                sum += c[pass][ylm_sh_index(l, m)] * y;
              else
                out[ylm_sh_index(l, m)] += product * y;
            }
          if (pass < p->factors) product *= sum;
        }
      }
}

/* -- applying -- */

typedef struct job {
  const ylm_sh_product *p;
  ylm_dtype t;
  const void *const *factor;
  const size_t *stride;
  char *out;
  size_t scratch; /* bytes that one row needs */
  double *stage;
} job;

/* One row; scratch is the worker's. */
static void row_f(const ylm_sh_product *p, const float *const *c, float *out, void *scratch,
                  double *stage);
static void row_d(const ylm_sh_product *p, const double *const *c, double *out, void *scratch,
                  double *stage);

static void plain_f(const ylm_sh_product *p, const float *const *c, float *out, double *scratch) {
  size_t count = ylm_sh_count(p->lmax);
  const double *wide[YLM_SH_PRODUCT_FACTORS] = {NULL};
  for (int k = 0; k < p->factors; k++) {
    wide[k] = scratch + (size_t)(k + 1) * count;
    for (size_t i = 0; i < count; i++) scratch[(size_t)(k + 1) * count + i] = (double)c[k][i];
  }
  plain(p, wide, scratch);
  for (size_t i = 0; i < count; i++) out[i] = (float)scratch[i];
}

/* Two factors of a degree for which there are generated kernels. */
static bool low_gaunt(const ylm_sh_product *p) {
  return p->method == YLM_SH_PRODUCT_gaunt && p->factors == 2 && p->lmax <= PRODUCT_GAUNT_LOW;
}

/* One factor after the other, by the tables; exact, because the partial product keeps every degree
 * that can still reach the result. */
#define CHAIN(S, T)                                                                                \
  static void chain_##S(const ylm_sh_product *p, const T *const *c, T *out, T *scratch) {          \
    size_t size = ylm_sh_count(p->lmax) * sizeof(T);                                               \
    if (p->factors == 2) {                                                                         \
      memset(out, 0, size);                                                                        \
      ylm__gaunt_##S(p->gaunt, c[0], c[1], out);                                                   \
      return;                                                                                      \
    }                                                                                              \
    size_t wide = ylm_sh_count(product_gaunt_top(p->lmax, p->factors));                            \
    T *product = scratch, *next = product + wide, *factor = next + wide;                           \
    memset(product, 0, wide * sizeof(T));                                                          \
    memset(factor, 0, wide * sizeof(T));                                                           \
    memcpy(product, c[0], size);                                                                   \
    for (int i = 1; i < p->factors; i++) {                                                         \
      memcpy(factor, c[i], size);                                                                  \
      memset(next, 0, wide * sizeof(T));                                                           \
      ylm__gaunt_##S(p->gaunt, product, factor, next);                                             \
      T *swap = product;                                                                           \
      product = next;                                                                              \
      next = swap;                                                                                 \
    }                                                                                              \
    memcpy(out, product, size);                                                                    \
  }
CHAIN(f, float)
CHAIN(d, double)

#define ROW(S, T, DTYPE, PLAIN)                                                                    \
  static void row_##S(const ylm_sh_product *p, const T *const *c, T *out, void *scratch,           \
                      double *stage) {                                                             \
    size_t size = ylm_sh_count(p->lmax) * sizeof(T);                                               \
    const ylm__product_kernels *k = p->kernels;                                                    \
    switch (p->method) {                                                                           \
    case YLM_SH_PRODUCT_gaunt:                                                                     \
      if (k && low_gaunt(p))                                                                       \
        k->S->gaunt(p->lmax, c[0], c[1], out);                                                     \
      else                                                                                         \
        chain_##S(p, c, out, scratch);                                                             \
      break;                                                                                       \
    case YLM_SH_PRODUCT_fourier:                                                                   \
    case YLM_SH_PRODUCT_brute:                                                                     \
    case YLM_SH_PRODUCT_list:                                                                      \
      p->rival->apply(p->rival_plan, DTYPE, (const void *const *)c, out, scratch, stage);          \
      break;                                                                                       \
    case YLM_SH_PRODUCT_recursive: {                                                               \
      T *a = scratch, *b = a + ylm_sh_count(p->lmax);                                              \
      void *rest = (char *)scratch + (2 * size + YLM_ALIGN - 1) / YLM_ALIGN * YLM_ALIGN;           \
      memcpy(a, c[0], size);                                                                       \
      for (int i = 1; i < p->factors; i++) {                                                       \
        const T *pair[2] = {a, c[i]};                                                              \
        row_##S(p->inner, pair, i + 1 < p->factors ? b : out, rest, stage);                        \
        T *swap = a;                                                                               \
        a = b;                                                                                     \
        b = swap;                                                                                  \
      }                                                                                            \
      break;                                                                                       \
    }                                                                                              \
    default:                                                                                       \
      if (!k)                                                                                      \
        PLAIN;                                                                                     \
      else if (p->dense && !stage)                                                                 \
        k->S->dense(p, c, out, scratch);                                                           \
      else                                                                                         \
        k->S->separable(p, c, out, scratch, stage);                                                \
    }                                                                                              \
  }
ROW(f, float, YLM_FLOAT, plain_f(p, c, out, scratch))
ROW(d, double, YLM_DOUBLE, plain(p, c, out))

/* Bytes of scratch that a row needs. */
static size_t scratch_of(const ylm_sh_product *p, ylm_dtype t) {
  size_t size = ylm_dtype_size(t), count = ylm_sh_count(p->lmax);
  switch (p->method) {
  case YLM_SH_PRODUCT_gaunt:
    return p->factors == 2 ? YLM_ALIGN
                           : 3 * ylm_sh_count(product_gaunt_top(p->lmax, p->factors)) * size;
  case YLM_SH_PRODUCT_fourier:
  case YLM_SH_PRODUCT_brute:
  case YLM_SH_PRODUCT_list: return p->rival->scratch(p->rival_plan, t);
  case YLM_SH_PRODUCT_recursive: return 2 * count * size + YLM_ALIGN + scratch_of(p->inner, t);
  case YLM_SH_PRODUCT_quadrature: {
    size_t vector = product_scratch(p, t == YLM_DOUBLE ? &p->d : &p->f) * size;
    size_t scalar = (size_t)(p->factors + 1) * count * sizeof(double);
    return vector > scalar ? vector : scalar;
  }
  default: return YLM_ALIGN;
  }
}

/* The number of products that the kernels do at once; 0 if they do one at a time. */
static size_t lanes_of(const job *j) {
  const ylm__product_kernels *k = j->p->kernels;
  if (!k || j->stage || !(low_gaunt(j->p) || j->p->method == YLM_SH_PRODUCT_quadrature)) return 0;
  return (size_t)(j->t == YLM_DOUBLE ? k->d->lanes : k->f->lanes);
}

/* Rows r .. r+n-1 in the lanes; lanes that are left repeat the last row. */
static void run_lanes(const job *j, size_t r, size_t n, size_t lanes, void *scratch) {
  const char *rows[YLM_SH_PRODUCT_FACTORS * 16];
  char *out[16];
  size_t size = ylm_dtype_size(j->t), row = ylm_sh_count(j->p->lmax) * size;
  for (size_t i = 0; i < lanes; i++) {
    size_t at = r + (i < n ? i : n - 1);
    out[i] = j->out + at * row;
    for (int k = 0; k < j->p->factors; k++)
      rows[(size_t)k * lanes + i] = (const char *)j->factor[k] + at * j->stride[k] * size;
  }
  if (j->t == YLM_DOUBLE)
    j->p->kernels->d->batch(j->p, (const double *const *)rows, (double *const *)out, scratch);
  else
    j->p->kernels->f->batch(j->p, (const float *const *)rows, (float *const *)out, scratch);
}

static void run_row(const job *j, size_t r, void *scratch) {
  const void *at[YLM_SH_PRODUCT_FACTORS];
  size_t size = ylm_dtype_size(j->t);
  for (int i = 0; i < j->p->factors; i++)
    at[i] = (const char *)j->factor[i] + r * j->stride[i] * size;
  void *out = j->out + r * ylm_sh_count(j->p->lmax) * size;
  if (j->t == YLM_DOUBLE)
    row_d(j->p, (const double *const *)at, out, scratch, j->stage);
  else
    row_f(j->p, (const float *const *)at, out, scratch, j->stage);
}

static ylm_status run(void *context, size_t r, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  char small[16384] __attribute__((aligned(YLM_ALIGN)));
  size_t lanes = lanes_of(j), few = (lanes + 3) / 4, size = j->scratch;
  if (lanes && end - r >= few) { /* fewer rows are faster one at a time */
    size_t batch = product_batch_scratch(j->p, lanes) * ylm_dtype_size(j->t);
    if (batch > size) size = batch;
  } else
    lanes = 0;
  void *scratch = size <= sizeof small ? small : ylm_alloc(size, 1);
  if (!scratch) return YLM_ENOMEM;
  while (lanes && end - r >= few) {
    size_t n = end - r < lanes ? end - r : lanes;
    run_lanes(j, r, n, lanes, scratch);
    r += n;
  }
  for (; r < end; r++) run_row(j, r, scratch);
  if (scratch != (void *)small) ylm_free(scratch);
  return YLM_OK;
}

ylm_status ylm_sh_product_apply(const ylm_sh_product *p, ylm_dtype t, size_t rows,
                                const void *const *factor, const size_t *stride, void *out,
                                int threads, const ylm_progress *progress, double *stage) {
  size_t same[YLM_SH_PRODUCT_FACTORS];
  for (int i = 0; i < p->factors; i++) same[i] = stride ? stride[i] : ylm_sh_count(p->lmax);
  job j = {p, t, factor, same, out, scratch_of(p, t), stage};
  if ((rows <= 64 && !progress) || stage) return run(&j, 0, rows, 0);
  return ylm_parallel(rows, PRODUCT_GRAIN, threads, run, &j, progress, "product");
}
