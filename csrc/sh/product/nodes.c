/* nodes.c - values of functions at the directions of one rule: to them, and back. */
#include "product.h"

#include <math.h>
#include <string.h>

struct ylm_sh_nodes {
  ylm_sh_product rule; /* its tables */
  double *direction;   /* [count][3] */
};

/* The directions, in the order of product_nodes.h. */
static bool list_directions(ylm_sh_nodes *n) {
  const ylm_sh_product *p = &n->rule;
  double *z = ylm_alloc(2 * (size_t)p->nodes, sizeof *z),
         *to = ylm_alloc(3 * ylm_sh_nodes_count(n), sizeof *to);
  n->direction = to;
  if (z && to) {
    ylm_sh_gauss_legendre(p->nodes, z, z + p->nodes);
    for (int h = 0; h < p->half; h++)
      for (int j = 0; j < p->azimuths / 4; j++)
        for (int k = 0; k < 8; k++, to += 3) {
          double above = z[p->nodes / 2 + h], sine = sqrt(1 - above * above);
          double c = ylm__product_cosine(1, j, p->azimuths),
                 s = ylm__product_sine(1, j, p->azimuths);
          to[0] = (k & 2 ? -c : c) * sine;
          to[1] = (k & 1 ? -s : s) * sine;
          to[2] = k & 4 ? -above : above;
        }
  }
  bool ok = z && n->direction;
  ylm_free(z);
  return ok;
}

ylm_status ylm_sh_nodes_create(int lmax, int degree, ylm_sh_nodes **out, ylm_error *e) {
  *out = NULL;
  if (lmax < 0 || lmax > YLM_SH_PRODUCT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax of a product must be from 0 to %d, got %d",
                    YLM_SH_PRODUCT_LMAX, lmax);
  if (degree < lmax || degree > YLM_SH_NODES_DEGREE)
    return ylm_fail(e, YLM_ERANGE, "a rule of degree %d to %d expected, got %d", lmax,
                    YLM_SH_NODES_DEGREE, degree);
  ylm_sh_nodes *n = ylm_alloc_zero(1, sizeof *n);
  if (!n) return YLM_ENOMEM;
  n->rule.lmax = lmax;
  n->rule.degree = degree;
  n->rule.method = YLM_SH_PRODUCT_quadrature;
  n->rule.kernels = ylm__product_kernels_now();
  if (ylm__product_quadrature(&n->rule) == YLM_OK && list_directions(n)) {
    *out = n;
    return YLM_OK;
  }
  ylm_sh_nodes_free(n);
  return YLM_ENOMEM;
}

void ylm_sh_nodes_free(ylm_sh_nodes *n) {
  if (!n) return;
  ylm__product_tables_free(&n->rule.f);
  ylm__product_tables_free(&n->rule.d);
  ylm_free(n->direction);
  ylm_free(n);
}

size_t ylm_sh_nodes_count(const ylm_sh_nodes *n) {
  return 2 * (size_t)n->rule.half * (size_t)n->rule.azimuths;
}

const double *ylm_sh_nodes_directions(const ylm_sh_nodes *n) { return n->direction; }

size_t ylm_sh_nodes_lanes(const ylm_sh_nodes *n, ylm_dtype t) {
  const ylm__product_kernels *k = n->rule.kernels;
  return !k ? 1 : (size_t)(t == YLM_DOUBLE ? k->d->lanes : k->f->lanes);
}

size_t ylm_sh_nodes_scratch(const ylm_sh_nodes *n, ylm_dtype t) {
  return product_nodes_scratch(&n->rule, ylm_sh_nodes_lanes(n, t)) * ylm_dtype_size(t);
}

/* -- the plain form: the reference set, processors without vectors ----------------------------- */

/* cos(m phi), or sin(|m| phi) for m < 0, at quadrant k of azimuth j. */
static double around(const ylm_sh_product *p, int j, int k, int m) {
  int am = m < 0 ? -m : m;
  const double *table = m < 0 ? p->d.sines : p->d.cosines;
  double x = table[j * (p->lmax + 1) + am];
  if ((k & 2) && (am & 1)) x = -x;                   /* pi - phi, pi + phi */
  return m < 0 && ((k & 1) ^ (k >> 1 & 1)) ? -x : x; /* -phi, pi - phi */
}

/* One row to values, or values, times `by` where it is not NULL, to the row that is added to; ring [2 lmax + 1] by the way. */
static void plain(const ylm_sh_product *p, ylm_dtype t, bool back, bool multiply, void *row,
                  void *value, const void *by, double *ring) {
  int lmax = p->lmax, entries = (lmax + 1) * (lmax + 2) / 2, at = 0;
  for (int h = 0; h < p->half; h++) {
    const double *legendre = (const double *)p->d.node_legendre + h * entries;
    double weight = ((const double *)p->d.node_weights)[h];
    for (int side = 0; side < 2; side++) {
      for (int m = -lmax; m <= lmax; m++) {
        int am = m < 0 ? -m : m;
        double sum = 0;
        for (int l = am; l <= lmax && !back; l++)
          sum += ylm_get(t, row, ylm_sh_index(l, m)) * legendre[l * (l + 1) / 2 + am] *
                 (side && (l - am) % 2 ? -1 : 1);
        for (int i = 0; i < p->azimuths && back; i++) {
          size_t k = (size_t)(at + i / 4 * 8 + 4 * side + i % 4);
          sum += ylm_get(t, value, k) * (by ? ylm_get(t, by, k) : 1) * around(p, i / 4, i % 4, m);
        }
        ring[m + lmax] = sum;
        for (int l = am; l <= lmax && back; l++) {
          size_t k = ylm_sh_index(l, m);
          ylm_put(t, row, k,
                  ylm_get(t, row, k) + weight * sum * legendre[l * (l + 1) / 2 + am] *
                                           (side && (l - am) % 2 ? -1 : 1));
        }
      }
      for (int i = 0; i < p->azimuths && !back; i++) {
        size_t k = (size_t)(at + i / 4 * 8 + 4 * side + i % 4);
        double sum = 0;
        for (int m = -lmax; m <= lmax; m++) sum += ring[m + lmax] * around(p, i / 4, i % 4, m);
        ylm_put(t, value, k, multiply ? ylm_get(t, value, k) * sum : sum);
      }
    }
    at += 2 * p->azimuths;
  }
}

/* -- rows to nodes and back --------------------------------------------------------------------- */

void ylm_sh_nodes_synthesise(const ylm_sh_nodes *n, ylm_dtype t, const void *const *row,
                             bool multiply, void *value, void *scratch) {
  const ylm_sh_product *p = &n->rule;
  double ring[2 * YLM_SH_PRODUCT_LMAX + 1];
  if (!p->kernels)
    plain(p, t, false, multiply, (void *)(uintptr_t)row[0], value, NULL, ring);
  else if (t == YLM_DOUBLE)
    p->kernels->d->synthesise(p, (const double *const *)row, multiply, value, scratch);
  else
    p->kernels->f->synthesise(p, (const float *const *)row, multiply, value, scratch);
}

void ylm_sh_nodes_analyse(const ylm_sh_nodes *n, ylm_dtype t, const void *value, const void *by,
                          void *const *out, void *scratch) {
  const ylm_sh_product *p = &n->rule;
  double ring[2 * YLM_SH_PRODUCT_LMAX + 1];
  if (!p->kernels) {
    memset(out[0], 0, ylm_sh_count(p->lmax) * ylm_dtype_size(t));
    plain(p, t, true, false, out[0], (void *)(uintptr_t)value, by, ring);
  } else if (t == YLM_DOUBLE)
    p->kernels->d->analyse(p, value, by, (double *const *)out, scratch);
  else
    p->kernels->f->analyse(p, value, by, (float *const *)out, scratch);
}

/* -- products of any number of factors ---------------------------------------------------------- */

typedef struct job {
  const ylm_sh_nodes *n;
  ylm_dtype t;
  size_t factors;
  const void *const *factor;
  const size_t *stride;
  char *out;
} job;

/* Rows r .. r+n-1 in the lanes; lanes that are left repeat the last row. */
static void run_lanes(const job *j, size_t r, size_t n, size_t lanes, void *value, void *scratch) {
  const void *row[16];
  void *out[16];
  size_t size = ylm_dtype_size(j->t), count = ylm_sh_count(j->n->rule.lmax) * size;
  for (size_t k = 0; k < j->factors; k++) {
    for (size_t i = 0; i < lanes; i++)
      row[i] = (const char *)j->factor[k] + (r + (i < n ? i : n - 1)) * j->stride[k] * size;
    ylm_sh_nodes_synthesise(j->n, j->t, row, k > 0, value, scratch);
  }
  for (size_t i = 0; i < lanes; i++) out[i] = j->out + (r + (i < n ? i : n - 1)) * count;
  ylm_sh_nodes_analyse(j->n, j->t, value, NULL, out, scratch);
}

static ylm_status run(void *context, size_t r, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t lanes = ylm_sh_nodes_lanes(j->n, j->t), size = ylm_dtype_size(j->t),
         values = ylm_sh_nodes_count(j->n) * lanes * size;
  char *room = ylm_alloc(values + ylm_sh_nodes_scratch(j->n, j->t), 1);
  if (!room) return YLM_ENOMEM;
  for (; r < end; r += lanes)
    run_lanes(j, r, end - r < lanes ? end - r : lanes, lanes, room, room + values);
  ylm_free(room);
  return YLM_OK;
}

ylm_status ylm_sh_nodes_product(const ylm_sh_nodes *n, ylm_dtype t, size_t factors, size_t rows,
                                const void *const *factor, const size_t *stride, void *out,
                                int threads, const ylm_progress *progress) {
  job j = {n, t, factors, factor, stride, out};
  if (rows <= PRODUCT_GRAIN && !progress) return run(&j, 0, rows, 0);
  return ylm_parallel(rows, PRODUCT_GRAIN, threads, run, &j, progress, "product");
}
