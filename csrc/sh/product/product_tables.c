/* product_tables.c - tables of the quadrature of products. */
#include "product.h"

#include <math.h>
#include <string.h>

void ylm__product_tables_free(ylm__product_tables *t) {
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

double ylm__product_cosine(int m, int j, int azimuths) {
  return cos(m * (j + 0.5) * (2 * YLM_PI / azimuths));
}
double ylm__product_sine(int m, int j, int azimuths) {
  return sin(m * (j + 0.5) * (2 * YLM_PI / azimuths));
}

/* Tables at the nodes z >= 0: [half]. */
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
                     (m < 0 ? ylm__product_sine(-m, j, p->azimuths)
                            : ylm__product_cosine(m, j, p->azimuths));
          int k = at[l & 1]++;
          values[(size_t)k * (size_t)out->pairs_padded + (size_t)pair] = y;
          int column = l & 1 ? k - out->evens + out->evens_padded : k;
          weights[(size_t)pair * row + (size_t)column] = y * r->w[h] * 2 * YLM_PI / p->azimuths;
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
              y * r->w[h] * 2 * YLM_PI / p->azimuths * (r->z[h] == 0 ? 0.5 : 1);
        }
    }
  for (int j = 0; ok && j < J; j++)
    for (int m = 0; m <= lmax; m++) {
      cosines[j * (lmax + 1) + m] = ylm__product_cosine(m, j, p->azimuths);
      sines[j * (lmax + 1) + m] = ylm__product_sine(m, j, p->azimuths);
    }
  for (int h = 0; ok && h < p->half; h++) {
    for (int q = 0; q < entries; q++) node[h * entries + q] = r->p[h * entries + q];
    weights[h] = r->w[h] * 2 * YLM_PI / p->azimuths * (r->z[h] == 0 ? 0.5 : 1);
  }
  bool a = finish(t, legendre, nl, &out->legendre), b = finish(t, back, nb, &out->back);
  bool c = finish(t, cosines, nc, &out->cosines), d = finish(t, sines, nc, &out->sines);
  bool f = finish(t, node, nn, &out->node_legendre),
       g = finish(t, weights, (size_t)p->half, &out->node_weights);
  return ok && a && b && c && d && f && g;
}

ylm_status ylm__product_quadrature(ylm_sh_product *p) {
  int degree = p->degree, entries = (p->lmax + 1) * (p->lmax + 2) / 2;
  p->nodes = degree / 2 + 1;
  p->half = (p->nodes + 1) / 2;
  p->azimuths = (degree + 4) / 4 * 4;
  p->dense = p->factors && p->lmax <= 5;
  double *z = ylm_alloc(2 * (size_t)p->nodes, sizeof *z);
  rule r = {NULL, NULL, ylm_alloc((size_t)(p->half * entries), sizeof(double))};
  bool ok = z && r.p;
  if (ok) {
    ylm_sh_gauss_legendre(p->nodes, z, z + p->nodes);
    r.z = z + p->nodes / 2; /* the first that is >= 0 */
    r.w = z + p->nodes + p->nodes / 2;
    for (int h = 0; h < p->half; h++)
      ylm_sh_legendre(p->lmax, r.z[h], sqrt(1 - r.z[h] * r.z[h]), r.p + h * entries);
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
