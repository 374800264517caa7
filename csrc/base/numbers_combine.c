/* numbers_combine.c - arithmetic of two arrays, broadcast, and of one. */
#include "ylm_numbers.h"

#include <math.h>

/* -- kernels: z = op(x, y), n numbers --------------------------------------------------------- */

#define CHUNK 1024 /* numbers at a time, so that what is staged stays in the first cache */

#define ARITHMETIC(name, T, expression)                                                            \
  static void name##_##T(size_t n, const void *px, const void *py, void *pz) {                     \
    const T *x = px, *y = py;                                                                      \
    T *z = pz;                                                                                     \
    for (size_t i = 0; i < n; i++) z[i] = (T)(expression);                                         \
  }
#define COMPARISON(name, T, expression)                                                            \
  static void name##_##T(size_t n, const void *px, const void *py, void *pz) {                     \
    const T *x = px, *y = py;                                                                      \
    float *z = pz;                                                                                 \
    for (size_t i = 0; i < n; i++) z[i] = (expression) ? 1.0f : 0.0f;                              \
  }
#define KERNELS(T, pow)                                                                            \
  ARITHMETIC(add, T, x[i] + y[i])                                                                  \
  ARITHMETIC(subtract, T, x[i] - y[i])                                                             \
  ARITHMETIC(multiply, T, x[i] * y[i])                                                             \
  ARITHMETIC(divide, T, x[i] / y[i])                                                               \
  ARITHMETIC(power, T, pow(x[i], y[i]))                                                            \
  ARITHMETIC(minimum, T, x[i] != x[i] || x[i] < y[i] ? x[i] : y[i])                                \
  ARITHMETIC(maximum, T, x[i] != x[i] || x[i] > y[i] ? x[i] : y[i])                                \
  COMPARISON(less, T, x[i] < y[i])                                                                 \
  COMPARISON(less_equal, T, x[i] <= y[i])                                                          \
  COMPARISON(greater, T, x[i] > y[i])                                                              \
  COMPARISON(greater_equal, T, x[i] >= y[i])                                                       \
  COMPARISON(equal, T, x[i] == y[i])                                                               \
  COMPARISON(not_equal, T, x[i] != y[i])
KERNELS(float, powf)
KERNELS(double, pow)

typedef void combine_fn(size_t n, const void *x, const void *y, void *z);

static combine_fn *const kernels[YLM_COMBINE_COUNT][2] = {
#define X(name) {name##_float, name##_double},
    YLM_NUMBERS_COMBINE_LIST(X)
#undef X
};

/* -- operands --------------------------------------------------------------------------------- */

ylm_status ylm_numbers_broadcast(int axes_a, const size_t *shape_a, int axes_b,
                                 const size_t *shape_b, int *axes, size_t *shape) {
  int n = *axes = axes_a > axes_b ? axes_a : axes_b;
  size_t count;
  for (int i = 0; i < n; i++) {
    int ia = i - (n - axes_a), ib = i - (n - axes_b);
    size_t ea = ia < 0 ? 1 : shape_a[ia], eb = ib < 0 ? 1 : shape_b[ib];
    if (ea != eb && ea != 1 && eb != 1) return YLM_ESHAPE;
    shape[i] = ea == 1 ? eb : ea;
  }
  return ylm_shape_count(n, shape, &count) ? YLM_OK : YLM_EOVERFLOW;
}

/* An operand as the result sees it: its axes, of which neighbours that are walked alike are one.
   A stride is 0 where the operand is repeated. */
typedef struct operand {
  ylm_dtype dtype;
  const char *data;
  void *own; /* numbers that were converted, or NULL */
  int axes;  /* 0: one number */
  size_t extent[YLM_MAX_AXES], stride[YLM_MAX_AXES];
} operand;

static ylm_status prepare(const ylm_numbers *x, int axes, const size_t *shape, ylm_dtype t,
                          operand *o) {
  *o = (operand){.dtype = x->dtype, .data = x->data};
  size_t stride = 1, count = 1;
  for (int i = axes - 1; i >= 0; i--) { /* from the last axis on, the last one first */
    int own = i - (axes - x->axes);
    bool repeated = own < 0 || x->shape[own] == 1;
    if (own >= 0) count *= x->shape[own];
    if (shape[i] == 1) continue;
    size_t s = repeated ? 0 : stride;
    int last = o->axes - 1;
    if (last >= 0 && s == o->stride[last] * o->extent[last] && (s > 0) == (o->stride[last] > 0))
      o->extent[last] *= shape[i];
    else {
      o->extent[o->axes] = shape[i];
      o->stride[o->axes++] = s;
    }
    if (!repeated) stride *= x->shape[own];
  }
  if (o->axes == 1 && o->stride[0] == 0) o->axes = 0;
  bool dense = o->axes == 1 && o->stride[0] == 1;
  if (dense || x->dtype == t) return YLM_OK;
  o->own = ylm_alloc(count, ylm_numbers_size(t)); /* what is repeated is converted once */
  if (!o->own) return YLM_ENOMEM;
  o->data = o->own;
  o->dtype = t;
  return ylm_numbers_convert(x->dtype, t, count, x->data, o->own, NULL);
}

/* Numbers begin .. begin + n - 1 of a repeated operand. */
#define STAGE(T)                                                                                   \
  static void stage_##T(const operand *o, size_t begin, size_t n, T *out) {                        \
    const T *data = (const T *)(const void *)o->data;                                              \
    size_t index[YLM_MAX_AXES] = {0}, at = 0;                                                      \
    for (int i = 0; i < o->axes; i++) {                                                            \
      index[i] = begin % o->extent[i];                                                             \
      begin /= o->extent[i];                                                                       \
      at += index[i] * o->stride[i];                                                               \
    }                                                                                              \
    if (o->axes == 0) {                                                                            \
      for (size_t i = 0; i < n; i++) out[i] = data[0];                                             \
      return;                                                                                      \
    }                                                                                              \
    while (n > 0) {                                                                                \
      size_t run = o->extent[0] - index[0];                                                        \
      if (run > n) run = n;                                                                        \
      if (o->stride[0] == 0) {                                                                     \
        T x = data[at];                                                                            \
        for (size_t i = 0; i < run; i++) out[i] = x;                                               \
      } else {                                                                                     \
        for (size_t i = 0; i < run; i++) out[i] = data[at + i];                                    \
      }                                                                                            \
      out += run;                                                                                  \
      n -= run;                                                                                    \
      at -= index[0] * o->stride[0];                                                               \
      index[0] = 0;                                                                                \
      for (int i = 1; i < o->axes; i++) {                                                          \
        at += o->stride[i];                                                                        \
        if (++index[i] < o->extent[i]) break;                                                      \
        at -= o->extent[i] * o->stride[i];                                                         \
        index[i] = 0;                                                                              \
      }                                                                                            \
    }                                                                                              \
  }
STAGE(float)
STAGE(double)

/* Numbers begin .. begin + n - 1 of any operand, as type t: where they lie, or in `buffer`. */
static const void *staged(const operand *o, size_t begin, size_t n, ylm_dtype t, void *buffer) {
  if (o->axes == 1 && o->stride[0] == 1) {
    const char *at = o->data + begin * ylm_numbers_size(o->dtype);
    if (o->dtype == t) return at;
    ylm_numbers_convert(o->dtype, t, n, at, buffer, NULL);
  } else if (t == YLM_DOUBLE)
    stage_double(o, begin, n, buffer);
  else
    stage_float(o, begin, n, buffer);
  return buffer;
}

typedef struct job {
  operand a, b;
  combine_fn *kernel;
  ylm_dtype t, out_type;
  char *out;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  double x[CHUNK], y[CHUNK];
  for (size_t i = begin; i < end; i += CHUNK) {
    size_t n = end - i < CHUNK ? end - i : CHUNK;
    j->kernel(n, staged(&j->a, i, n, j->t, x), staged(&j->b, i, n, j->t, y),
              j->out + i * ylm_numbers_size(j->out_type));
  }
  return YLM_OK;
}

ylm_status ylm_numbers_combine(ylm_numbers_combine_op op, const ylm_numbers *a,
                               const ylm_numbers *b, ylm_dtype t, void *out, int threads) {
  int axes;
  size_t shape[YLM_MAX_AXES], count;
  ylm_status s = ylm_numbers_broadcast(a->axes, a->shape, b->axes, b->shape, &axes, shape);
  if (s != YLM_OK) return s;
  ylm_shape_count(axes, shape, &count);
  if (count == 0) return YLM_OK;
  job j = {.kernel = kernels[op][t == YLM_DOUBLE],
           .t = t,
           .out_type = op >= YLM_COMBINE_less ? YLM_FLOAT : t,
           .out = out};
  s = prepare(a, axes, shape, t, &j.a);
  if (s == YLM_OK) s = prepare(b, axes, shape, t, &j.b);
  enum { GRAIN = 64 * CHUNK };
  if (s == YLM_OK)
    s = count < 4 * GRAIN ? run(&j, 0, count, 0)
                          : ylm_parallel(count, GRAIN, threads, run, &j, NULL, NULL);
  ylm_free(j.a.own);
  ylm_free(j.b.own);
  return s;
}

/* -- one array -------------------------------------------------------------------------------- */

#define MAP(T, fabs, sqrt)                                                                         \
  static void map_##T(ylm_numbers_map_op op, size_t n, const T *x, T *z) {                         \
    if (op == YLM_MAP_negate)                                                                      \
      for (size_t i = 0; i < n; i++) z[i] = -x[i];                                                 \
    else if (op == YLM_MAP_absolute)                                                               \
      for (size_t i = 0; i < n; i++) z[i] = fabs(x[i]);                                            \
    else                                                                                           \
      for (size_t i = 0; i < n; i++) z[i] = sqrt(x[i]);                                            \
  }
MAP(float, fabsf, sqrtf)
MAP(double, fabs, sqrt)

void ylm_numbers_map(ylm_numbers_map_op op, ylm_dtype t, size_t n, const void *in, void *out) {
  ylm_dtype wide = ylm_numbers_wide(t);
  if (t != wide) ylm_numbers_convert(t, wide, n, in, out, NULL);
  const void *from = t != wide ? out : in;
  if (wide == YLM_DOUBLE)
    map_double(op, n, from, out);
  else
    map_float(op, n, from, out);
}
