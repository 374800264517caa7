/* products.real.isa.c - sums of lights as products of rows, which have harmonics and distances, and emissions. */
#include "kernel.h"

YLM_INLINE void weigh(const int lmax, const int order, const vreal *B, vreal invd, weights *w) {
  vreal inv2 = invd * invd;
  for (int l = 0; l <= lmax; l++) {
    const vreal b0 = B[4 * l], b1 = B[4 * l + 1], b2 = B[4 * l + 2];
    const real n = (real)l;
    w->value[l] = b0;
    if (order < 1) continue;
    w->up[l + 1] = (b1 - n * b0) * invd;
    if (l) w->down[l - 1] = (b1 + (n + 1) * b0) * invd;
    if (order < 2) continue;
    w->upup[l + 2] = (b2 - (2 * n + 2) * b1 + n * (n + 2) * b0) * inv2;
    w->same[l] = (b2 + b1 - n * (n + 1) * b0) * inv2;
    if (l > 1) w->downdown[l - 2] = (b2 + 2 * n * b1 + (n * n - 1) * b0) * inv2;
  }
}

/* The rows that have the harmonic at place `at` of degree k, q. */
YLM_INLINE void put_rows(const int lmax, const int order, const weights *w, const int k,
                         const int at, vreal q, vreal *S) {
  const int n0 = (lmax + 1) * (lmax + 1), n1 = (lmax + 2) * (lmax + 2) - 1;
  const int once = n0, twice = n0 + n1 + lmax * lmax, same = twice + (lmax + 3) * (lmax + 3) - 4;
  if (k <= lmax) S[at] = q * w->value[k];
  if (order < 1) return;
  if (k > 0 && k <= lmax + 1) S[once + at - 1] = q * w->up[k];
  if (k < lmax) S[once + n1 + at] = q * w->down[k];
  if (order < 2) return;
  if (k > 1) S[twice + at - 4] = q * w->upup[k];
  if (k <= lmax) S[same + at] = q * w->same[k];
  if (k < lmax - 1) S[same + n0 + at] = q * w->downdown[k];
}

/* All rows of a light. */
YLM_INLINE void make_rows(const int lmax, const int order, const double *beta, const weights *w,
                          vreal x, vreal y, vreal z, vreal *S) {
  const int top = lmax + order, across = lmax + 3;
  vreal c = vreal_set(1), s = vreal_set(0);
#pragma GCC unroll 8
  for (int m = 0; m <= top; m++) {
    vreal a = c, b = s, a0 = vreal_set(0), b0 = a0;
#pragma GCC unroll 8
    for (int k = m; k <= top; k++) {
      put_rows(lmax, order, w, k, k * (k + 1) + m, a, S);
      if (m) put_rows(lmax, order, w, k, k * (k + 1) - m, b, S);
      if (k == top) break;
      const real t = k == m                         ? 0
                     : lmax <= YLM__VIRTUAL_SPECIAL ? (real)YLM__BETA(k, m)
                                                    : (real)beta[k * across + m];
      vreal next = z * a - t * a0;
      a0 = a, a = next;
      if (!m) continue;
      next = z * b - t * b0;
      b0 = b, b = next;
    }
    vreal next = c * x - s * y;
    s = c * y + s * x;
    c = next;
  }
}

/* -- products ------------------------------------------------------------------------------- */

/* Sums [C][..] of R rows in C channels grow by those of n lights; numbers of a light are this far from the
   next's. */
YLM_INLINE void multiply_block(const int R, const int C, int n, const vreal *S, size_t S_step,
                               const vreal *E, size_t E_step, vreal *to, size_t to_step) {
  vreal a[32];
#pragma GCC unroll 8
  for (int c = 0; c < C; c++)
#pragma GCC unroll 16
    for (int r = 0; r < R; r++) a[c * R + r] = to[(size_t)c * to_step + (size_t)r];
  for (int j = 0; j < n; j++, S += S_step, E += E_step) {
    vreal row[16];
#pragma GCC unroll 16
    for (int r = 0; r < R; r++) row[r] = S[r];
#pragma GCC unroll 8
    for (int c = 0; c < C; c++) {
      const vreal e = E[c];
#pragma GCC unroll 16
      for (int r = 0; r < R; r++) a[c * R + r] += row[r] * e;
    }
  }
#pragma GCC unroll 8
  for (int c = 0; c < C; c++)
#pragma GCC unroll 16
    for (int r = 0; r < R; r++) to[(size_t)c * to_step + (size_t)r] = a[c * R + r];
}

/* Rows that fit into registers, of six channels, of three, of one. */
#if defined(__AVX512F__) || defined(__aarch64__)
#define ROWS_6 4
#define ROWS_3 7
#define ROWS_1 12
#else
#define ROWS_6 2
#define ROWS_3 3
#define ROWS_1 7
#endif

YLM_INLINE void multiply_channels(const int R, const int C, size_t rows, int n, const vreal *S,
                                  size_t S_step, const vreal *E, size_t E_step, vreal *to) {
  size_t r = 0;
  for (; r + (size_t)R <= rows; r += (size_t)R)
    multiply_block(R, C, n, S + r, S_step, E, E_step, to + r, rows);
  for (; r < rows; r++) multiply_block(1, C, n, S + r, S_step, E, E_step, to + r, rows);
}

static void multiply(size_t rows, int channels, int n, const vreal *S, size_t S_step,
                     const vreal *E, size_t E_step, vreal *to) {
  int c = 0;
  for (; c + 6 <= channels; c += 6)
    multiply_channels(ROWS_6, 6, rows, n, S, S_step, E + c, E_step, to + (size_t)c * rows);
  for (; c + 3 <= channels; c += 3)
    multiply_channels(ROWS_3, 3, rows, n, S, S_step, E + c, E_step, to + (size_t)c * rows);
  for (; c < channels; c++)
    multiply_channels(ROWS_1, 1, rows, n, S, S_step, E + c, E_step, to + (size_t)c * rows);
}

typedef void rows_fn(const ylm__virtual_plan *p, const weights *w, const vreal u[3], vreal *S);

#define ROWS(lmax, order)                                                                          \
  static void rows_##lmax##_##order(const ylm__virtual_plan *p, const weights *w,                  \
                                    const vreal u[3], vreal *S) {                                  \
    make_rows(lmax, order, p->beta, w, u[0], u[1], u[2], S);                                       \
  }
#define DEGREES(X, order) X(0, order) X(1, order) X(2, order) X(3, order) X(4, order)
DEGREES(ROWS, 0)
DEGREES(ROWS, 1)
DEGREES(ROWS, 2)
#define ENTRY(lmax, order) rows_##lmax##_##order,
#define ROWS_ANY(order)                                                                            \
  static void rows_any_##order(const ylm__virtual_plan *p, const weights *w, const vreal u[3],     \
                               vreal *S) {                                                         \
    make_rows(p->lmax, order, p->beta, w, u[0], u[1], u[2], S);                                    \
  }
ROWS_ANY(0)
ROWS_ANY(1)
ROWS_ANY(2)
static rows_fn *const makers[3][YLM__VIRTUAL_SPECIAL + 2] = {
    {DEGREES(ENTRY, 0) rows_any_0}, {DEGREES(ENTRY, 1) rows_any_1}, {DEGREES(ENTRY, 2) rows_any_2}};

void VIRTUAL(sum_products)(const ylm__virtual_plan *p, work *k) {
  const size_t first[3] = {0, p->rows[0], p->rows[0] + p->rows[1]};
  const int order = order_of(p->kinds);
  rows_fn *make =
      makers[order][p->lmax <= YLM__VIRTUAL_SPECIAL ? p->lmax : YLM__VIRTUAL_SPECIAL + 1];
  for (int j = 0; j < k->held; j++) {
    const sight *s = &k->sight[j];
    seen of;
    seen_of(s, k->lamp[j], &of);
    VIRTUAL(weighers)[order][p->lights->profile](p, k->lamp[j], s, k->B);
    weigh(p->lmax, order, k->B, s->inv, &k->weights);
    make(p, &k->weights, s->w, k->S + (size_t)j * p->width);
    for (int i = 0; i < 2; i++)
      if (p->of[i].kinds) VIRTUAL(senders)
    [i][jet_of(p->of[i].kinds)](&of, p->lights->degree, k->beta, k->lamp[j],
                                k->E + j * p->numbers + p->of[i].from);
  }
  for (int i = 0; i < p->products; i++) {
    const ylm__virtual_product *x = &p->product[i];
    multiply(p->rows[x->block], x->channels, k->held, k->S + first[x->block], p->width,
             k->E + x->from, (size_t)p->numbers, k->part + x->to);
  }
}
