/*
** low_kernel.h - evaluation of low degrees by generated, unrolled functions, once for each `real`.
**
** gen/sh_plain.h and sh_stable.h compute all columns of W points from the unit vectors; here points are loaded
** and columns stored as rows. Solid harmonics are left to sh_kernel.h.
*/
#include "sh_simd.h"

#define YLM_T vreal
#define YLM_K(c) ((real)(c))
#define YLM_SET(c) sh_set((real)(c))

/* Every lmax with a kernel: first those of sh_plain.h, which take the unit vector alone, then those of
   sh_stable.h, which take the sign of z and 1 - |z| too, for Hessians, gradients, values. */
#define STABLE_FROM 5
#define LOW_PLAIN(X) X(0) X(1) X(2) X(3) X(4)
#define LOW_2(X) X(5) X(6)
#define LOW_1(X) LOW_2(X) X(7) X(8) X(9) X(10)
#define LOW_0(X) LOW_1(X) X(11) X(12)

#include "../gen/sh_plain.h"
#include "../gen/sh_stable.h"

/* Columns from which on one function stores them: inlined into each kernel they are half of its code. */
#define MANY 64

static __attribute__((noinline)) void put_many(real *out, size_t rows, const vreal *v,
                                               size_t count) {
  sh_store_columns(v, count, out, count, rows);
}

/* Stores `count` columns of one array of results, if it is wanted. */
YLM_INLINE void put(void *out, size_t at, size_t rows, const vreal *v, size_t count) {
  if (!out) return;
  real *to = (real *)out + at * count;
  if (count >= MANY)
    put_many(to, rows, v, count);
  else
    sh_store_columns(v, count, to, count, rows);
}

/* One kernel for each lmax and number of derivatives. */
#define KERNEL(lmax, order, outs, call)                                                            \
  static void low_##lmax##_##order(const ylm__sh_job *job, size_t begin, size_t end,               \
                                   void *scratch) {                                                \
    (void)scratch;                                                                                 \
    for (size_t i = begin; i < end; i += W) {                                                      \
      enum { COUNT = (lmax + 1) * (lmax + 1) };                                                    \
      size_t rows = end - i < W ? end - i : W;                                                     \
      vreal v[3], s, g, o, outs;                                                                   \
      sh_load_points((const real *)job->p + 3 * i, rows, v);                                       \
      sh_unit(v, &s, job->tame);                                                                   \
      if (lmax >= STABLE_FROM) sh_pole(v, &g, &o);                                                 \
      call;                                                                                        \
      put(job->y, i, rows, y, COUNT);                                                              \
      if (order > 0) put(job->dy, i, rows, dy, 3 * COUNT);                                         \
      if (order > 1) put(job->ddy, i, rows, ddy, 6 * COUNT);                                       \
    }                                                                                              \
  }
#define COMMA ,
#define OUTS_0 y[COUNT] COMMA *dy = NULL COMMA *ddy = NULL
#define OUTS_1 y[COUNT] COMMA dy[3 * COUNT] COMMA *ddy = NULL
#define OUTS_2 y[COUNT] COMMA dy[3 * COUNT] COMMA ddy[6 * COUNT]
#define X(lmax) KERNEL(lmax, 0, OUTS_0, sh_plain_0(lmax, v[0], v[1], v[2], y))
LOW_PLAIN(X)
#undef X
#define X(lmax) KERNEL(lmax, 0, OUTS_0, sh_stable_0(lmax, v[0], v[1], v[2], g, o, y))
LOW_0(X)
#undef X
#define X(lmax) KERNEL(lmax, 1, OUTS_1, sh_plain_1(lmax, v[0], v[1], v[2], s, y, dy))
LOW_PLAIN(X)
#undef X
#define X(lmax) KERNEL(lmax, 1, OUTS_1, sh_stable_1(lmax, v[0], v[1], v[2], g, o, s, y, dy))
LOW_1(X)
#undef X
#define X(lmax) KERNEL(lmax, 2, OUTS_2, sh_plain_2(lmax, v[0], v[1], v[2], s, y, dy, ddy))
LOW_PLAIN(X)
#undef X
#define X(lmax) KERNEL(lmax, 2, OUTS_2, sh_stable_2(lmax, v[0], v[1], v[2], g, o, s, y, dy, ddy))
LOW_2(X)
#undef X

/* The kernel for this lmax and number of derivatives, NULL if none was generated. */
ylm__sh_kernel *YLM_REAL_KERNEL(ylm__sh_low)(int lmax, int derivatives) {
#define X(lmax) low_##lmax##_0,
  static ylm__sh_kernel *const values[] = {LOW_PLAIN(X) LOW_0(X)};
#undef X
#define X(lmax) low_##lmax##_1,
  static ylm__sh_kernel *const gradients[] = {LOW_PLAIN(X) LOW_1(X)};
#undef X
#define X(lmax) low_##lmax##_2,
  static ylm__sh_kernel *const hessians[] = {LOW_PLAIN(X) LOW_2(X)};
#undef X
  static const struct {
    ylm__sh_kernel *const *kernels;
    size_t n;
  } lists[3] = {{values, sizeof values / sizeof *values},
                {gradients, sizeof gradients / sizeof *gradients},
                {hessians, sizeof hessians / sizeof *hessians}};
  return (size_t)lmax < lists[derivatives].n ? lists[derivatives].kernels[lmax] : NULL;
}

bool YLM_REAL_KERNEL(ylm__sh_all_between)(const void *p, size_t n, double least, double most) {
  vreal low = sh_set((real)(3 * least * least)), high = sh_set((real)(most * most)), v[3];
  sh_mask good = ~(sh_mask){0};
  for (size_t i = 0; i < n; i += W) {
    sh_load_points((const real *)p + 3 * i, n - i < W ? n - i : W, v);
    vreal d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    good &= (d2 >= low) & (d2 <= high); /* false for NaN */
  }
  long all = -1;
  for (size_t j = 0; j < W; j++) all &= (long)good[j];
  return all != 0;
}
