/* product.c - products of functions given by coefficients: plans, choice of method, batches. */
#include "product.h"

#include <math.h>
#include <string.h>

#include "quadrature.h"

static const char *const names[] = {
#define X(name) #name,
    YLM_SH_PRODUCT_METHOD_LIST(X)
#undef X
};

const char *ylm_sh_product_method_name(ylm_sh_product_method m) {
  return (unsigned)m < YLM_SH_PRODUCT_METHOD_COUNT ? names[m] : "?";
}

const ylm__product_kernels *ylm__product_kernels_now(void) {
  switch (ylm_isa_current()) {
#define X(isa)                                                                                     \
  case YLM_ISA_##isa: return &ylm__product_kernels_##isa;
    PRODUCT_ISAS(X)
#undef X
  default: return NULL;
  }
}

/* -- tables of the quadrature
 * ---------------------------------------------------------------------- */

static void free_tables(ylm__product_tables *t) {
  ylm_free(t->values);
  ylm_free(t->weights);
  ylm_free(t->legendre);
  ylm_free(t->back);
  ylm_free(t->back_at);
  ylm_free(t->cosines);
  ylm_free(t->sines);
  ylm_free(t->node_legendre);
  ylm_free(t->node_weights);
  memset(t, 0, sizeof *t);
}

void ylm_sh_product_free(ylm_sh_product *p) {
  if (!p) return;
  free_tables(&p->f);
  free_tables(&p->d);
  ylm__gaunt_free(p->gaunt);
  ylm__fourier_free(p->fourier);
  ylm__brute_free(p->brute);
  ylm_sh_product_free(p->inner);
  ylm_free(p);
}

/* n doubles, zeroed, that become numbers of type t by finish(). */
static double *begin(size_t n) { return ylm_alloc_zero(n, sizeof(double)); }

/* Turns the doubles of *table into floats where t asks for it; false where memory ran out. */
static bool finish(ylm_dtype t, double *x, size_t n, void **table) {
  *table = x;
  if (!x || t == YLM_DOUBLE) return x != NULL;
  float *f = ylm_alloc(n, sizeof *f);
  *table = f;
  for (size_t i = 0; f && i < n; i++) f[i] = (float)x[i];
  ylm_free(x);
  return f != NULL;
}

static double cosine(int m, int j, int azimuths) {
  return cos(m * (j + 0.5) * (2 * 3.14159265358979323846 / azimuths));
}
static double sine(int m, int j, int azimuths) {
  return sin(m * (j + 0.5) * (2 * 3.14159265358979323846 / azimuths));
}

/* What is known of the nodes z >= 0: [half]. */
typedef struct rule {
  double *z, *w, *p; /* p: [half][(lmax+1)(lmax+2)/2] */
} rule;

static bool dense_tables(const ylm_sh_product *p, const rule *r, ylm_dtype t,
                         ylm__product_tables *out) {
  int lanes = t == YLM_DOUBLE ? 8 : 16, lmax = p->lmax, entries = (lmax + 1) * (lmax + 2) / 2;
  for (int l = 0; l <= lmax; l++) *(l & 1 ? &out->odds : &out->evens) += 2 * l + 1;
  out->pairs = p->nodes * p->azimuths / 2;
  out->pairs_padded = product_padded(out->pairs, lanes);
  out->evens_padded = product_padded(out->evens, lanes);
  out->odds_padded = product_padded(out->odds, lanes);
  size_t row = (size_t)(out->evens_padded + out->odds_padded);
  size_t nv = (size_t)(out->evens + out->odds) * (size_t)out->pairs_padded,
         nw = (size_t)out->pairs * row;
  double *values = begin(nv), *weights = begin(nw);
  int pair = 0;
  for (int h = 0; values && weights && h < p->half; h++) {
    /* on the equator the second half of the azimuths is opposite to the first */
    int around = r->z[h] == 0 ? p->azimuths / 2 : p->azimuths;
    for (int j = 0; j < around; j++, pair++) {
      int at[2] = {0, out->evens};
      for (int l = 0; l <= lmax; l++)
        for (int m = -l; m <= l; m++) {
          double y = r->p[h * entries + l * (l + 1) / 2 + (m < 0 ? -m : m)] *
                     (m < 0 ? sine(-m, j, p->azimuths) : cosine(m, j, p->azimuths));
          int k = at[l & 1]++;
          values[(size_t)k * (size_t)out->pairs_padded + (size_t)pair] = y;
          int column = l & 1 ? k - out->evens + out->evens_padded : k;
          weights[(size_t)pair * row + (size_t)column] =
              y * r->w[h] * 2 * 3.14159265358979323846 / p->azimuths;
        }
    }
  }
  bool a = finish(t, values, nv, &out->values), b = finish(t, weights, nw, &out->weights);
  return a && b;
}

static bool separable_tables(const ylm_sh_product *p, const rule *r, ylm_dtype t,
                             ylm__product_tables *out) {
  int lanes = t == YLM_DOUBLE ? 8 : 16, lmax = p->lmax, entries = (lmax + 1) * (lmax + 2) / 2,
      J = p->azimuths / 4;
  out->half_padded = product_padded(p->half, lanes);
  size_t row = (size_t)out->half_padded, nl = (size_t)entries * row, nb = 0,
         nc = (size_t)J * (size_t)(lmax + 1);
  size_t nn = (size_t)p->half * (size_t)entries;
  out->back_at = ylm_alloc(2 * (size_t)(lmax + 1), sizeof(int));
  if (!out->back_at) return false;
  for (int m = 0; m <= lmax; m++)
    for (int parity = 0; parity < 2; parity++) {
      out->back_at[2 * m + parity] = (int)nb;
      nb += (size_t)(p->half * product_padded(product_degrees(lmax, m, parity), lanes));
    }
  double *legendre = begin(nl), *back = begin(nb), *cosines = begin(nc), *sines = begin(nc);
  double *node = begin(nn), *weights = begin((size_t)p->half);
  bool ok = legendre && back && cosines && sines && node && weights;
  size_t k = 0;
  for (int m = 0; ok && m <= lmax; m++)
    for (int parity = 0; parity < 2; parity++) {
      int padded = product_padded(product_degrees(lmax, m, parity), lanes), i = 0;
      for (int l = m + parity; l <= lmax; l += 2, i++, k++)
        for (int h = 0; h < p->half; h++) {
          double y = r->p[h * entries + l * (l + 1) / 2 + m];
          legendre[k * row + (size_t)h] = y;
          back[(size_t)out->back_at[2 * m + parity] + (size_t)(h * padded + i)] =
              y * r->w[h] * 2 * 3.14159265358979323846 / p->azimuths * (r->z[h] == 0 ? 0.5 : 1);
        }
    }
  for (int j = 0; ok && j < J; j++)
    for (int m = 0; m <= lmax; m++) {
      cosines[j * (lmax + 1) + m] = cosine(m, j, p->azimuths);
      sines[j * (lmax + 1) + m] = sine(m, j, p->azimuths);
    }
  for (int h = 0; ok && h < p->half; h++) {
    for (int q = 0; q < entries; q++) node[h * entries + q] = r->p[h * entries + q];
    weights[h] = r->w[h] * 2 * 3.14159265358979323846 / p->azimuths * (r->z[h] == 0 ? 0.5 : 1);
  }
  bool a = finish(t, legendre, nl, &out->legendre), b = finish(t, back, nb, &out->back);
  bool c = finish(t, cosines, nc, &out->cosines), d = finish(t, sines, nc, &out->sines);
  bool f = finish(t, node, nn, &out->node_legendre),
       g = finish(t, weights, (size_t)p->half, &out->node_weights);
  return ok && a && b && c && d && f && g;
}

static ylm_status quadrature(ylm_sh_product *p) {
  int degree = (p->factors + 1) * p->lmax, entries = (p->lmax + 1) * (p->lmax + 2) / 2;
  p->nodes = degree / 2 + 1;
  p->half = (p->nodes + 1) / 2;
  p->azimuths = (degree + 4) / 4 * 4;
  p->dense = p->lmax <= 5;
  double *z = ylm_alloc(2 * (size_t)p->nodes, sizeof *z);
  rule r = {NULL, NULL, ylm_alloc((size_t)(p->half * entries), sizeof(double))};
  bool ok = z && r.p;
  if (ok) {
    ylm__gauss_legendre(p->nodes, z, z + p->nodes);
    r.z = z + p->nodes / 2; /* the first that is >= 0 */
    r.w = z + p->nodes + p->nodes / 2;
    for (int h = 0; h < p->half; h++)
      ylm__legendre(p->lmax, r.z[h], sqrt(1 - r.z[h] * r.z[h]), r.p + h * entries);
    for (int t = YLM_FLOAT; ok && t <= YLM_DOUBLE; t++) {
      ylm__product_tables *out = t == YLM_DOUBLE ? &p->d : &p->f;
      ok = separable_tables(p, &r, (ylm_dtype)t, out) &&
           (!p->dense || dense_tables(p, &r, (ylm_dtype)t, out));
    }
  }
  ylm_free(z);
  ylm_free(r.p);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* -- plans
 * ---------------------------------------------------------------------------------------------- */

static ylm_sh_product_method best(int lmax, int factors) {
  if (factors == 2 && lmax <= PRODUCT_GAUNT_LOW) return YLM_SH_PRODUCT_gaunt;
  return YLM_SH_PRODUCT_quadrature;
}

ylm_status ylm_sh_product_create(int lmax, int factors, ylm_sh_product_method method,
                                 ylm_sh_product_method inner, ylm_sh_product **out, ylm_error *e) {
  *out = NULL;
  if (lmax < 0 || lmax > YLM_SH_PRODUCT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax of a product must be from 0 to %d, got %d",
                    YLM_SH_PRODUCT_LMAX, lmax);
  if (factors < 2 || factors > YLM_SH_PRODUCT_FACTORS)
    return ylm_fail(e, YLM_ERANGE, "a product of 2 to %d factors expected, got %d",
                    YLM_SH_PRODUCT_FACTORS, factors);
  if ((unsigned)method >= YLM_SH_PRODUCT_METHOD_COUNT ||
      (unsigned)inner >= YLM_SH_PRODUCT_METHOD_COUNT)
    return ylm_fail(e, YLM_EINVAL, "no such method");
  if (method == YLM_SH_PRODUCT_auto) method = best(lmax, factors);
  if (method == YLM_SH_PRODUCT_recursive && inner == YLM_SH_PRODUCT_recursive)
    return ylm_fail(e, YLM_EINVAL, "the steps of 'recursive' need another method");
  ylm_sh_product *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  p->lmax = lmax;
  p->factors = factors;
  p->method = method;
  p->kernels = ylm__product_kernels_now();
  ylm_status s = YLM_OK;
  switch (method) {
  case YLM_SH_PRODUCT_gaunt:
    s = ylm__gaunt_create(lmax, product_gaunt_top(lmax, factors), &p->gaunt, e);
    break;
  case YLM_SH_PRODUCT_fourier: s = ylm__fourier_create(lmax, factors, &p->fourier, e); break;
  case YLM_SH_PRODUCT_brute: s = ylm__brute_create(lmax, factors, &p->brute, e); break;
  case YLM_SH_PRODUCT_recursive:
    s = ylm_sh_product_create(lmax, 2, inner, inner, &p->inner, e);
    break;
  default: s = quadrature(p);
  }
  if (s != YLM_OK) {
    ylm_sh_product_free(p);
    return s;
  }
  *out = p;
  return YLM_OK;
}

ylm_sh_product_method ylm_sh_product_method_of(const ylm_sh_product *p) { return p->method; }
size_t ylm_sh_product_integrals(const ylm_sh_product *p) { return ylm__gaunt_count(p->gaunt); }

/* -- the plain form of the quadrature, for the reference set and processors without vectors
 * ----------- */

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
                         (m < 0 ? sine(am, j, p->azimuths) : cosine(am, j, p->azimuths));
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

/* -- applying
 * ---------------------------------------------------------------------------------------------- */

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
  const double *wide[YLM_SH_PRODUCT_FACTORS];
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

#define ROW(S, T, OTHER, PLAIN)                                                                    \
  static void row_##S(const ylm_sh_product *p, const T *const *c, T *out, void *scratch,           \
                      double *stage) {                                                             \
    size_t size = ylm_sh_count(p->lmax) * sizeof(T);                                               \
    const ylm__product_kernels *k = p->kernels;                                                    \
    switch (p->method) {                                                                           \
    case YLM_SH_PRODUCT_gaunt:                                                                     \
      if (k && low_gaunt(p))                                                                       \
        k->gaunt_##S(p->lmax, c[0], c[1], out);                                                    \
      else                                                                                         \
        chain_##S(p, c, out, scratch);                                                             \
      break;                                                                                       \
    case YLM_SH_PRODUCT_fourier: ylm__fourier_##S(p->fourier, c, out, scratch, stage); break;      \
    case YLM_SH_PRODUCT_brute:                                                                     \
      memset(out, 0, size);                                                                        \
      ylm__brute_##S(p->brute, c, out);                                                            \
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
        k->dense_##S(p, c, out, scratch);                                                          \
      else                                                                                         \
        k->separable_##S(p, c, out, scratch, stage);                                               \
    }                                                                                              \
  }
ROW(f, float, double, plain_f(p, c, out, scratch))
ROW(d, double, float, plain(p, c, out))

/* Bytes of scratch that a row needs. */
static size_t scratch_of(const ylm_sh_product *p, ylm_dtype t) {
  size_t size = ylm_dtype_size(t), count = ylm_sh_count(p->lmax);
  switch (p->method) {
  case YLM_SH_PRODUCT_gaunt:
    return p->factors == 2 ? YLM_ALIGN
                           : 3 * ylm_sh_count(product_gaunt_top(p->lmax, p->factors)) * size;
  case YLM_SH_PRODUCT_fourier: return ylm__fourier_scratch(p->fourier);
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
  return (size_t)(j->t == YLM_DOUBLE ? k->lanes_d : k->lanes_f);
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
    j->p->kernels->batch_d(j->p, (const double *const *)rows, (double *const *)out, scratch);
  else
    j->p->kernels->batch_f(j->p, (const float *const *)rows, (float *const *)out, scratch);
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
  return ylm_parallel(rows, 64, threads, run, &j, progress, "product");
}
