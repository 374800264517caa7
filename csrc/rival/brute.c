/* brute.c - the product of k factors by all integrals of k+1 basis functions that are not zero. */
#include "rival.h"
#include "ylm_list.h"

#include <math.h>
#include <string.h>

/* Combinations of one basis function for each factor that may be looked at. */
#define MOST_TUPLES 1200000

typedef struct brute {
  int factors;
  size_t count, tuples;
  uint32_t *first; /* [tuples+1]; the tuple is a number with `factors` digits to base count */
  uint16_t *k;
  float *value_f;
  double *value_d;
} brute;

static void brute_free(void *plan) {
  brute *b = plan;
  if (!b) return;
  ylm_free(b->first);
  ylm_free(b->k);
  ylm_free(b->value_f);
  ylm_free(b->value_d);
  ylm_free(b);
}

/* Basis functions at the points of a rule exact to degree (factors+1) lmax: [count][points];
 * weights. */
static double *basis(int lmax, int factors, size_t *points, double **weights) {
  int degree = (factors + 1) * lmax, nodes = degree / 2 + 1, around = degree + 1;
  size_t count = ylm_sh_count(lmax), n = (size_t)nodes * (size_t)around;
  double *y = ylm_alloc((count + 1) * n, sizeof *y);
  double *x = ylm_alloc(2 * (size_t)nodes + (size_t)(lmax + 1) * (size_t)(lmax + 2), sizeof *x);
  if (!x || !y) {
    ylm_free(x);
    ylm_free(y);
    return NULL;
  }
  double *w = x + nodes, *p = w + nodes;
  *weights = y + count * n;
  *points = n;
  ylm_sh_gauss_legendre(nodes, x, w);
  for (int h = 0; h < nodes; h++) {
    ylm_sh_legendre(lmax, x[h], sqrt(1 - x[h] * x[h]), p);
    for (int j = 0; j < around; j++) {
      double phi = 2 * YLM_PI * j / around;
      size_t at = (size_t)h * (size_t)around + (size_t)j;
      (*weights)[at] = w[h] * 2 * YLM_PI / around;
      for (int l = 0; l <= lmax; l++)
        for (int m = -l; m <= l; m++)
          y[ylm_sh_index(l, m) * n + at] =
              p[l * (l + 1) / 2 + (m < 0 ? -m : m)] * (m < 0 ? sin(-m * phi) : cos(m * phi));
    }
  }
  ylm_free(x);
  return y;
}

static ylm_status create(int lmax, int factors, void **out, ylm_error *e) {
  *out = NULL;
  size_t count = ylm_sh_count(lmax), tuples = 1, n = 0, used = 0, room = 0;
  for (int k = 0; k < factors; k++) {
    tuples *= count;
    if (tuples > MOST_TUPLES)
      return ylm_fail(e, YLM_ELIMIT,
                      "brute force: %d factors of lmax %d have too many combinations", factors,
                      lmax);
  }
  double *weights = NULL, *y = basis(lmax, factors, &n, &weights);
  double *product =
      ylm_alloc((size_t)factors * n, sizeof *product); /* of the first 1 .. factors functions */
  brute *b = ylm_alloc_zero(1, sizeof *b);
  if (!y || !product || !b) goto fail;
  b->factors = factors;
  b->count = count;
  b->tuples = tuples;
  b->first = ylm_alloc(tuples + 1, sizeof *b->first);
  if (!b->first) goto fail;
  size_t digits[YLM_SH_PRODUCT_FACTORS] = {0};
  for (size_t tuple = 0; tuple < tuples; tuple++) {
    size_t rest = tuple;
    int changed = 0;
    for (int k = factors - 1; k >= 0; k--) {
      size_t digit = rest % count;
      rest /= count;
      if (digit != digits[k] || tuple == 0) changed = k;
      digits[k] = digit;
    }
    for (int k = changed; k < factors; k++)
      for (size_t q = 0; q < n; q++)
        product[(size_t)k * n + q] =
            (k ? product[(size_t)(k - 1) * n + q] : weights[q]) * y[digits[k] * n + q];
    b->first[tuple] = (uint32_t)used;
    for (size_t i = 0; i < count; i++) {
      double sum = 0;
      for (size_t q = 0; q < n; q++) sum += product[(size_t)(factors - 1) * n + q] * y[i * n + q];
      if (fabs(sum) < 1e-12) continue;
      if (used == room) {
        room = ylm_list_room(room, used + 1);
        if (!ylm_list_resize(&b->k, used, room, sizeof *b->k) ||
            !ylm_list_resize(&b->value_d, used, room, sizeof *b->value_d))
          goto fail;
      }
      b->k[used] = (uint16_t)i;
      b->value_d[used++] = sum;
    }
  }
  b->first[tuples] = (uint32_t)used;
  b->value_f = ylm_alloc(used, sizeof(float));
  if (!b->value_f) goto fail;
  for (size_t q = 0; q < used; q++) b->value_f[q] = (float)b->value_d[q];
  ylm_free(y);
  ylm_free(product);
  *out = b;
  return YLM_OK;
fail:
  ylm_free(y);
  ylm_free(product);
  brute_free(b);
  return YLM_ENOMEM;
}

#define APPLY(name, T, values)                                                                     \
  static void name(const brute *b, const T *const *c, T *out) {                                    \
    size_t digits[YLM_SH_PRODUCT_FACTORS] = {0};                                                   \
    T product[YLM_SH_PRODUCT_FACTORS];                                                             \
    int changed = 0;                                                                               \
    for (size_t tuple = 0; tuple < b->tuples; tuple++) {                                           \
      for (int k = changed; k < b->factors; k++)                                                   \
        product[k] = (k ? product[k - 1] : 1) * c[k][digits[k]];                                   \
      T s = product[b->factors - 1];                                                               \
      for (uint32_t q = b->first[tuple]; q < b->first[tuple + 1]; q++)                             \
        out[b->k[q]] += b->values[q] * s;                                                          \
      for (changed = b->factors - 1; changed >= 0 && ++digits[changed] == b->count; changed--)     \
        digits[changed] = 0;                                                                       \
    }                                                                                              \
  }

/* out must be zero. */
APPLY(apply_f, float, value_f)
APPLY(apply_d, double, value_d)

static size_t scratch_of(const void *plan, ylm_dtype t) {
  (void)plan, (void)t;
  return YLM_ALIGN;
}

static void apply(const void *plan, ylm_dtype t, const void *const *c, void *out, void *scratch,
                  double *stage) {
  const brute *b = plan;
  (void)scratch, (void)stage;
  memset(out, 0, b->count * ylm_dtype_size(t));
  if (t == YLM_DOUBLE)
    apply_d(b, (const double *const *)c, out);
  else
    apply_f(b, (const float *const *)c, out);
}

const ylm_sh_rival_product ylm__rival_brute = {create, brute_free, scratch_of, apply};
