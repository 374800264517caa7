/*
** gaunt.c - integrals of three basis functions, and products by sums over those that are not zero.
*/
#include "../calibration.h"
#include "ylm_sh.h"

#include <math.h>
#include <string.h>

#include "product.h"
#include "ylm_list.h"

/* For each pair i <= j with integrals: its k's and values. */
struct ylm__gaunt {
  size_t pairs, integrals;
  uint32_t *i, *j, *first; /* [pairs], first[pairs] = integrals */
  uint32_t *k;
  float *value_f;
  double *value_d;
};

void ylm__gaunt_free(ylm__gaunt *g) {
  if (!g) return;
  ylm_free(g->i);
  ylm_free(g->j);
  ylm_free(g->first);
  ylm_free(g->k);
  ylm_free(g->value_f);
  ylm_free(g->value_d);
  ylm_free(g);
}

size_t ylm__gaunt_count(const ylm__gaunt *g) { return g ? g->integrals : 0; }

/* Integral over the azimuth of cos or sin (negative m) of each, without the factors sqrt 2. */
static double azimuth(int a, int b, int c) {
  int sines = (a < 0) + (b < 0) + (c < 0);
  if (sines & 1) return 0;
  int m[3] = {a < 0 ? -a : a, b < 0 ? -b : b, c < 0 ? -c : c};
  bool sine[3] = {a < 0, b < 0, c < 0};
  double sum = 0;
  for (int signs = 0; signs < 8; signs++) {
    int total = 0;
    double term = 1;
    for (int q = 0; q < 3; q++) {
      int negative = signs >> q & 1;
      if (m[q] == 0) {
        if (negative) term = 0;
        continue;
      }
      total += negative ? -m[q] : m[q];
      term *= 0.5;
      if (sine[q] && negative) term = -term;
    }
    if (total == 0) sum += term;
  }
  return 2 * YLM_PI * (sines == 2 ? -sum : sum); /* (1/i)^2 */
}

/* Appends a number to a growing array; false where memory runs out. */
#define PUSH(array, used, room, x)                                                                 \
  do {                                                                                             \
    if (!ylm_list_reserve(&(array), used, (used) + 1, &(room), sizeof *(array))) goto fail;        \
    (array)[(used)++] = (x);                                                                       \
  } while (0)

/* Legendre parts at the nodes of a rule: [l(l+1)/2+m][nodes], and the weights. */
static double *node_table(int lmax, int nodes, double **weights) {
  size_t entries = (size_t)(lmax + 1) * (size_t)(lmax + 2) / 2;
  double *memory = ylm_alloc((entries + 2) * (size_t)nodes + entries, sizeof *memory);
  if (!memory) return NULL;
  double *x = memory + entries * (size_t)nodes, *w = x + nodes, *p = w + nodes;
  ylm_sh_gauss_legendre(nodes, x, w);
  for (int h = 0; h < nodes; h++) {
    ylm_sh_legendre(lmax, x[h], sqrt(1 - x[h] * x[h]), p);
    for (size_t k = 0; k < entries; k++) memory[k * (size_t)nodes + (size_t)h] = p[k];
  }
  *weights = w;
  return memory;
}

ylm_status ylm__gaunt_create(int lmax, int top, ylm__gaunt **out, ylm_error *e) {
  *out = NULL;
  if (top > 30)
    return ylm_fail(e, YLM_ELIMIT, "tables of integrals are made up to degree 30, needed is %d",
                    top);
  int nodes = (lmax + 2 * top) / 2 + 1;
  double *weights, *table = node_table(top, nodes, &weights),
                   *pair = ylm_alloc((size_t)nodes, sizeof *pair);
  ylm__gaunt *g = ylm_alloc_zero(1, sizeof *g);
  size_t ni = 0, nj = 0, nf = 0, nk = 0, nv = 0, ri = 0, rj = 0, rf = 0, rk = 0, rv = 0;
  if (!g || !table || !pair) goto fail;
#define ROW(l, m) (table + ((size_t)((l) * ((l) + 1) / 2 + ((m) < 0 ? -(m) : (m)))) * (size_t)nodes)
  for (int l1 = 0; l1 <= lmax; l1++)
    for (int m1 = -l1; m1 <= l1; m1++)
      for (int l2 = l1; l2 <= top; l2++)
        for (int m2 = l2 == l1 ? m1 : -l2; m2 <= l2; m2++) {
          size_t before = nk;
          const double *a = ROW(l1, m1), *b = ROW(l2, m2);
          for (int h = 0; h < nodes; h++) pair[h] = a[h] * b[h] * weights[h];
          int am1 = m1 < 0 ? -m1 : m1, am2 = m2 < 0 ? -m2 : m2,
              difference = am1 > am2 ? am1 - am2 : am2 - am1;
          for (int l3 = l2 - l1; l3 <= l1 + l2 && l3 <= top; l3 += 2)
            for (int which = 0; which < 4; which++) { /* m3 = +-(m1 + m2), +-|m1 - m2| */
              int m3 = which & 2 ? difference : am1 + am2;
              if (m3 > l3 || ((which & 2) && difference == am1 + am2) || ((which & 1) && m3 == 0))
                continue;
              if (which & 1) m3 = -m3;
              double phi = azimuth(m1, m2, m3), sum = 0;
              if (phi == 0) continue;
              const double *c = ROW(l3, m3);
              for (int h = 0; h < nodes; h++) sum += pair[h] * c[h];
              sum *= phi;
              if (fabs(sum) < 1e-11) continue;
              if (nk == GAUNT_MOST) {
                ylm__gaunt_free(g);
                ylm_free(table);
                ylm_free(pair);
                return ylm_fail(e, YLM_ELIMIT, "more than %d integrals", GAUNT_MOST);
              }
              PUSH(g->k, nk, rk, (uint32_t)ylm_sh_index(l3, m3));
              PUSH(g->value_d, nv, rv, sum);
            }
          if (nk == before) continue;
          PUSH(g->i, ni, ri, (uint32_t)ylm_sh_index(l1, m1));
          PUSH(g->j, nj, rj, (uint32_t)ylm_sh_index(l2, m2));
          PUSH(g->first, nf, rf, (uint32_t)before);
        }
#undef ROW
  PUSH(g->first, nf, rf, (uint32_t)nk);
  g->pairs = ni;
  g->integrals = nk;
  g->value_f = ylm_alloc(nk, sizeof(float));
  if (!g->value_f) goto fail;
  for (size_t q = 0; q < nk; q++) g->value_f[q] = (float)g->value_d[q];
  ylm_free(table);
  ylm_free(pair);
  *out = g;
  return YLM_OK;
fail:
  ylm__gaunt_free(g);
  ylm_free(table);
  ylm_free(pair);
  return YLM_ENOMEM;
}

#define APPLY(name, T, values)                                                                     \
  void name(const ylm__gaunt *g, const T *a, const T *b, T *out) {                                 \
    for (size_t p = 0; p < g->pairs; p++) {                                                        \
      uint32_t i = g->i[p], j = g->j[p];                                                           \
      T s = i == j ? a[i] * b[i] : a[i] * b[j] + a[j] * b[i];                                      \
      for (uint32_t q = g->first[p]; q < g->first[p + 1]; q++) out[g->k[q]] += g->values[q] * s;   \
    }                                                                                              \
  }

/* out must be zero. */
APPLY(ylm__gaunt_f, float, value_f)
APPLY(ylm__gaunt_d, double, value_d)

/* -- matrices of products
 * ------------------------------------------------------------------------------- */

/* Columns j of M: the function times Y_j, by the quadrature rule exact for degree 4 lmax. */
ylm_status ylm_sh_product_matrix(int clmax, const double *c, int lmax, double *matrix,
                                 ylm_error *e) {
  if (lmax < 0 || lmax > YLM_SH_PRODUCT_LMAX / 2)
    return ylm_fail(e, YLM_ERANGE, "lmax of a matrix of products must be from 0 to %d, got %d",
                    YLM_SH_PRODUCT_LMAX / 2, lmax);
  if (clmax < 0 || clmax > YLM_LMAX) return ylm_fail(e, YLM_ERANGE, "no such lmax: %d", clmax);
  int both = clmax < 2 * lmax ? clmax : 2 * lmax, top = both > lmax ? both : lmax;
  int nodes = (both + 2 * lmax) / 2 + 1, orders = 2 * both + 1;
  double *weights, *table = node_table(top, nodes, &weights);
  /* f[m][node]: the function's orders at the nodes */
  double *f = ylm_alloc_zero((size_t)orders * (size_t)nodes, sizeof *f);
  if (!table || !f) {
    ylm_free(table);
    ylm_free(f);
    return YLM_ENOMEM;
  }
#define ROW(l, m) (table + ((size_t)((l) * ((l) + 1) / 2 + ((m) < 0 ? -(m) : (m)))) * (size_t)nodes)
  for (int l = 0; l <= both; l++)
    for (int m = -l; m <= l; m++)
      for (int h = 0; h < nodes; h++)
        f[(m + both) * nodes + h] += c[ylm_sh_index(l, m)] * ROW(l, m)[h] * weights[h];
  size_t count = ylm_sh_count(lmax);
  memset(matrix, 0, count * count * sizeof *matrix);
  for (int l1 = 0; l1 <= lmax; l1++)
    for (int m1 = -l1; m1 <= l1; m1++)
      for (int l2 = 0; l2 <= lmax; l2++)
        for (int m2 = -l2; m2 <= l2; m2++) {
          size_t i = ylm_sh_index(l1, m1), j = ylm_sh_index(l2, m2);
          if (j > i) continue;
          int am1 = m1 < 0 ? -m1 : m1, am2 = m2 < 0 ? -m2 : m2,
              difference = am1 > am2 ? am1 - am2 : am2 - am1;
          double sum = 0;
          for (int which = 0; which < 4; which++) {
            int m3 = which & 2 ? difference : am1 + am2;
            if (m3 > both || ((which & 2) && difference == am1 + am2) || ((which & 1) && m3 == 0))
              continue;
            if (which & 1) m3 = -m3;
            double phi = azimuth(m1, m2, m3), part = 0;
            if (phi == 0) continue;
            for (int h = 0; h < nodes; h++)
              part += ROW(l1, m1)[h] * ROW(l2, m2)[h] * f[(m3 + both) * nodes + h];
            sum += phi * part;
          }
          matrix[i * count + j] = matrix[j * count + i] = sum;
        }
#undef ROW
  ylm_free(table);
  ylm_free(f);
  return YLM_OK;
}

typedef struct transfer_job {
  size_t n, padded;
  ylm_dtype t;
  const void *matrix; /* [n][padded] */
  const char *in;
  char *out;
  const ylm__product_kernels *kernels;
} transfer_job;

#define PLAIN(name, T)                                                                             \
  /* M is symmetric: its rows are its columns. */                                                  \
  static void name(size_t n, size_t padded, const T *m, size_t rows, const T *in, T *out) {        \
    for (; rows > 0; rows--, in += n, out += n) {                                                  \
      memset(out, 0, n * sizeof *out);                                                             \
      for (size_t k = 0; k < n; k++)                                                               \
        for (size_t i = 0; i < n; i++) out[i] += m[k * padded + i] * in[k];                        \
    }                                                                                              \
  }
PLAIN(transfer_plain_f, float)
PLAIN(transfer_plain_d, double)

static ylm_status transfer_rows(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const transfer_job *j = context;
  size_t offset = begin * j->n * ylm_dtype_size(j->t), rows = end - begin;
  const void *in = j->in + offset;
  void *out = j->out + offset;
  if (j->t == YLM_DOUBLE)
    (j->kernels ? j->kernels->d->transfer : transfer_plain_d)(j->n, j->padded, j->matrix, rows, in,
                                                              out);
  else
    (j->kernels ? j->kernels->f->transfer : transfer_plain_f)(j->n, j->padded, j->matrix, rows, in,
                                                              out);
  return YLM_OK;
}

ylm_status ylm_sh_apply(size_t n, ylm_dtype t, const void *matrix, size_t rows, const void *in,
                        void *out, int threads, const ylm_progress *progress) {
  size_t size = ylm_dtype_size(t), lanes = 128 / size, padded = (n + lanes - 1) / lanes * lanes;
  char *copy = ylm_alloc_zero(n * padded, size);
  if (!copy) return YLM_ENOMEM;
  for (size_t k = 0; k < n; k++)
    memcpy(copy + k * padded * size, (const char *)matrix + k * n * size, n * size);
  transfer_job j = {n, padded, t, copy, in, out, ylm__product_kernels_now()};
  ylm_status s = rows <= 64 && !progress ? transfer_rows(&j, 0, rows, 0)
                                         : ylm_parallel(rows, TRANSFER_GRAIN, threads,
                                                        transfer_rows, &j, progress, "transfer");
  ylm_free(copy);
  return s;
}
