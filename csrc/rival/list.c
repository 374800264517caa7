/* list.c - the product of two factors by a list of all integrals of three basis functions that are not
   zero, walked one by one: the triple product of relighting before it had Fourier series (Ng et al.
   2004). */
#include "rival.h"
#include "ylm_list.h"

#include <string.h>

/* A list of more integrals is refused: lmax 19 has 1.4 million. */
#define MOST 20000000

typedef struct list {
  size_t count, n, room; /* coefficients; integrals, and room for them */
  uint16_t (*place)[3];  /* [n] of the two factors and of the result */
  float *value_f;
  double *value_d;
} list;

static void list_free(void *plan) {
  list *x = plan;
  if (!x) return;
  ylm_free(x->place);
  ylm_free(x->value_f);
  ylm_free(x->value_d);
  ylm_free(x);
}

static ylm_status grow(list *x, ylm_error *e) {
  if (x->room >= MOST)
    return ylm_fail(e, YLM_ELIMIT, "a list of integrals has at most %d: lower lmax", MOST);
  size_t room = ylm_list_room(x->room, x->room + 1);
  if (!ylm_list_resize(&x->place, x->room, room, sizeof *x->place) ||
      !ylm_list_resize(&x->value_d, x->room, room, sizeof *x->value_d))
    return YLM_ENOMEM;
  x->room = room;
  return YLM_OK;
}

/* Appends the integrals of Y_i with all pairs, matrix [count][count]. */
static ylm_status append(list *x, size_t i, const double *matrix, ylm_error *e) {
  for (size_t jk = 0; jk < x->count * x->count; jk++) {
    if (matrix[jk] > -1e-12 && matrix[jk] < 1e-12) continue;
    ylm_status s = x->n == x->room ? grow(x, e) : YLM_OK;
    if (s != YLM_OK) return s;
    x->place[x->n][0] = (uint16_t)i;
    x->place[x->n][1] = (uint16_t)(jk / x->count);
    x->place[x->n][2] = (uint16_t)(jk % x->count);
    x->value_d[x->n++] = matrix[jk];
  }
  return YLM_OK;
}

static ylm_status create(int lmax, int factors, void **out, ylm_error *e) {
  *out = NULL;
  if (factors != 2)
    return ylm_fail(e, YLM_EINVAL, "a list of integrals multiplies two factors, here are %d",
                    factors);
  size_t count = ylm_sh_count(lmax);
  if (lmax > 30) return ylm_fail(e, YLM_ELIMIT, "lists of integrals are made up to lmax 30");
  list *x = ylm_alloc_zero(1, sizeof *x);
  double *unit = ylm_alloc_zero(count, sizeof *unit);
  double *matrix = ylm_alloc(count * count, sizeof *matrix);
  ylm_status s = x && unit && matrix ? YLM_OK : YLM_ENOMEM;
  if (x) x->count = count;
  for (size_t i = 0; s == YLM_OK && i < count; i++) {
    unit[i] = 1;
    s = ylm_sh_product_matrix(lmax, unit, lmax, matrix, e);
    unit[i] = 0;
    if (s == YLM_OK) s = append(x, i, matrix, e);
  }
  if (s == YLM_OK && !(x->value_f = ylm_alloc(x->n, sizeof(float)))) s = YLM_ENOMEM;
  for (size_t q = 0; s == YLM_OK && q < x->n; q++) x->value_f[q] = (float)x->value_d[q];
  ylm_free(unit);
  ylm_free(matrix);
  if (s == YLM_OK)
    *out = x;
  else
    list_free(x);
  return s;
}

static size_t scratch_of(const void *plan, ylm_dtype t) {
  (void)plan, (void)t;
  return YLM_ALIGN;
}

/* out must be zero. */
#define APPLY(name, T, values)                                                                     \
  static void name(const list *x, const T *a, const T *b, T *out) {                                \
    for (size_t q = 0; q < x->n; q++) {                                                            \
      const uint16_t *p = x->place[q];                                                             \
      out[p[2]] += x->values[q] * a[p[0]] * b[p[1]];                                               \
    }                                                                                              \
  }
APPLY(apply_f, float, value_f)
APPLY(apply_d, double, value_d)

static void apply(const void *plan, ylm_dtype t, const void *const *c, void *out, void *scratch,
                  double *stage) {
  const list *x = plan;
  (void)scratch, (void)stage;
  memset(out, 0, x->count * ylm_dtype_size(t));
  if (t == YLM_DOUBLE)
    apply_d(x, c[0], c[1], out);
  else
    apply_f(x, c[0], c[1], out);
}

const ylm_sh_rival_product ylm__rival_list = {create, list_free, scratch_of, apply};
