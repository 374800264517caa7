/*
** sh_kernel.h - evaluation by Cartesian recurrences for any lmax, included once for each `real`.
**
** Degree by degree, W points at a time. F_l,m are values at the unit vector, c cosine, s sine:
**   F_lq = a z F_(l-1)q - b F_(l-2)q,   F_ll = a (x, y) turned by F_(l-1)(l-1)
** In float that loses l^1.5 units of rounding near the poles; there (g the sign of z, o = 1 - |z|)
**   D_lq = g b' D_(l-1)q - g a o F_(l-1)q,   F_lq = g c' F_(l-1)q + D_lq
** and derivatives of the solid harmonics come from those of the degree below, by the ladder
**   dS_lq/dx = A S_(l-1)(q-1) + B S_(l-1)(q+1)       (like with like)
**   dS_lq/dy = -+ A S_(l-1)(q-1) +- B S_(l-1)(q+1)   (cosine with sine)
**   dS_lq/dz = e S_(l-1)q
** whose seven coefficients a b e A B b' c' stand in job->table for each l, q. Second
** derivatives climb it twice. Then derivatives of Y at v = d w follow from Iwasaki & Dobashi 2025,
** Eq. 17, with trace(HY) = -l(l+1) Y / d^2. docs/math.md "Evaluating the basis" derives this. The
** steps are generated, for shaders/sh_recurrence.real.comp too: gen/recurrence.h.
*/
#include "../calibration.h"
#include "sh_simd.h"

/* Values and derivatives that go out together: columns of one array of results. */
typedef struct columns {
  vreal *v;       /* the columns that wait: the last W written, then new ones */
  size_t have;    /* number of new ones */
  size_t written; /* number of columns in the array already */
  real *out;
  size_t stride;
} columns;

/* Rows of one degree, indexed by q = 0 .. l: cosine and sine (s[0] = 0). */
typedef struct row {
  vreal *c, *s;
} row;

typedef struct state {
  vreal w[3], inverse, wd[3];
  row f0, f1, f2; /* values of degrees l, l-1, l-2 */
  row d0, d1;     /* float: D of degrees l, l-1 */
  vreal sign, o;  /* float: the sign of z, 1 - |z| times it */
  row p0, p1;     /* those over d (surface), the same (solid); ladder's foot */
  row g0, g1;     /* solid gradients of degrees l, l-1, over d: [q][3] */
  columns out[3];
} state;

/* Writes what waits, all of it at the end, and keeps W columns of it for the last block. */
static void flush(columns *k, bool last, size_t rows) {
  size_t whole = last && rows < W ? k->have : k->have / W * W, part = last ? k->have - whole : 0;
  sh_store_columns(k->v + W, whole, k->out + k->written, k->stride, rows);
  if (part && k->written + k->have >= W)
    sh_store_block(k->v + k->have, k->out + k->written + k->have - W, k->stride);
  else if (part)
    sh_store_columns(k->v + W + whole, part, k->out + k->written + whole, k->stride, rows);
  k->written += whole + part;
  k->have -= whole + part;
  if (!last && whole) memmove(k->v, k->v + whole, (W + k->have) * sizeof(vreal));
}

/* Where columns of degree l, `width` to a coefficient, go. */
YLM_INLINE vreal *place(columns *k) { return k->v + W + k->have; }

YLM_INLINE void rotate_rows(state *s) {
  row r = s->d1;
  s->d1 = s->d0, s->d0 = r;
  r = s->f2;
  s->f2 = s->f1, s->f1 = s->f0, s->f0 = r;
  r = s->p1, s->p1 = s->p0, s->p0 = r;
  r = s->g1, s->g1 = s->g0, s->g0 = r;
}

/* Values of degree l >= 1; `r2` is |v|^2 for solid harmonics, else unused. */
YLM_INLINE void values(state *s, int l, const real *k, bool solid, vreal r2) {
  const vreal z = s->w[2], sign = s->sign, o = s->o;
  const row f0 = s->f0, f1 = s->f1, f2 = s->f2, d0 = s->d0, d1 = s->d1;
  const bool stable = sizeof(real) == sizeof(float) && !solid;
  for (int q = 0; q < l; q++, k += 7)
    if (stable)
      sh_stable(k[0], k[5], k[6], sign, o, f1.c[q], f1.s[q], d1.c[q], d1.s[q], &f0.c[q], &f0.s[q],
                &d0.c[q], &d0.s[q]);
    else if (solid)
      sh_solid(k[0], k[1], z, r2, f1.c[q], f1.s[q], f2.c[q], f2.s[q], &f0.c[q], &f0.s[q]);
    else
      sh_plain(k[0], k[1], z, f1.c[q], f1.s[q], f2.c[q], f2.s[q], &f0.c[q], &f0.s[q]);
  sh_turn(k[0], s->w[0], s->w[1], f1.c[l - 1], f1.s[l - 1], &f0.c[l], &f0.s[l]);
  if (stable) d0.c[l] = d0.s[l] = sh_set(0);
}

/* A coefficient's gradient and Hessian: from those of the solid harmonic to those of Y. */
YLM_INLINE void finish(const state *s, int order, bool solid, real l, const vreal lwd[3], vreal p,
                       const vreal g[3], vreal h[6], vreal *dy, vreal *ddy, vreal *scaled) {
  if (solid) {
    for (int c = 0; c < 3; c++) dy[c] = g[c];
    if (order < 2) return;
    for (int c = 0; c < 3; c++) scaled[c] = g[c];
    h[3] = sh_yy(h[0], h[5]);
    for (int c = 0; c < 6; c++) ddy[c] = h[c];
    return;
  }
  vreal u[3];
  sh_surface(l, p, s->w, g, u);
  for (int c = 0; c < 3; c++) dy[c] = u[c];
  if (order < 2) return;
  for (int c = 0; c < 3; c++) scaled[c] = g[c] * s->inverse;
  sh_surface_twice(l, s->inverse, p, s->w, lwd, u, h, ddy);
}

/* Derivatives of degree l from the rows of degree l-1. */
YLM_INLINE void derivatives(state *s, int l, const real *k, int order, bool solid, vreal *dy,
                            vreal *ddy) {
  const row p0 = s->p0, p1 = s->p1, g0 = s->g0, g1 = s->g1;
  vreal g[3], h[6], lwd[3];
  for (int c = 0; c < 3; c++) lwd[c] = (real)l * s->wd[c];
  sh_gradient_zero(k[2], k[4], p1.c[0], p1.c[1], p1.s[1], g);
  if (order > 1) sh_hessian_zero(k[2], k[4], g1.c + 3, g1.c, h);
  finish(s, order, solid, (real)l, lwd, p0.c[0], g, h, dy + 3 * l, ddy + 6 * l, g0.c);
  for (int q = 1; q <= l; q++) {
    k += 7;
    const real e = k[2], A = k[3], B = k[4];
    const vreal *c = p1.c + q, *sine = p1.s + q, *gc = g1.c + 3 * q, *gs = g1.s + 3 * q;
    sh_gradient_cosine(e, A, B, c[0], c[-1], sine[-1], c[1], sine[1], g);
    if (order > 1) sh_hessian(e, A, B, gc - 3, gc + 3, gc, h);
    finish(s, order, solid, (real)l, lwd, p0.c[q], g, h, dy + 3 * (l + q), ddy + 6 * (l + q),
           g0.c + 3 * q);
    sh_gradient_sine(e, A, B, sine[0], c[-1], sine[-1], c[1], sine[1], g);
    if (order > 1) sh_hessian(e, A, B, gs - 3, gs + 3, gs, h);
    finish(s, order, solid, (real)l, lwd, p0.s[q], g, h, dy + 3 * (l - q), ddy + 6 * (l - q),
           g0.s + 3 * q);
  }
}

/* Degree l: values, derivatives, and the columns they fill. */
YLM_INLINE void degree(state *s, int l, const real *k, int order, bool solid, vreal r2) {
  rotate_rows(s);
  if (l == 0) {
    s->f0.c[0] = sh_set((real)0.28209479177387814347);
    s->f0.s[0] = s->d0.c[0] = s->d0.s[0] = sh_set(0);
  } else
    values(s, l, k, solid, r2);
  vreal *y = place(&s->out[0]);
  y[l] = s->f0.c[0];
  for (int q = 1; q <= l; q++) y[l + q] = s->f0.c[q], y[l - q] = s->f0.s[q];
  s->out[0].have += 2 * (size_t)l + 1;
  if (order == 0) return;
  for (int q = 0; q <= l; q++) {
    s->p0.c[q] = solid ? s->f0.c[q] : s->f0.c[q] * s->inverse;
    s->p0.s[q] = solid ? s->f0.s[q] : s->f0.s[q] * s->inverse;
  }
  vreal *dy = place(&s->out[1]), *ddy = place(&s->out[2]);
  if (l == 0) {
    for (int c = 0; c < 3; c++) dy[c] = sh_set(0), s->g0.c[c] = s->g0.s[c] = sh_set(0);
    if (order > 1)
      for (int c = 0; c < 6; c++) ddy[c] = sh_set(0);
  } else
    derivatives(s, l, k, order, solid, dy, ddy);
  s->out[1].have += 3 * (2 * (size_t)l + 1);
  if (order > 1) s->out[2].have += 6 * (2 * (size_t)l + 1);
}

/* All degrees at `rows` points. */
YLM_INLINE void batch(const ylm__sh_job *job, state *s, size_t at, size_t rows, int order,
                      bool solid) {
  static const size_t width[3] = {1, 3, 6};
  void *const outs[3] = {job->y, job->dy, job->ddy};
  size_t count = ylm_sh_count(job->lmax);
  for (int i = 0; i < 3; i++) {
    columns *k = &s->out[i];
    k->stride = count * width[i];
    k->out = i <= order && outs[i] ? (real *)outs[i] + at * k->stride : NULL;
    k->have = k->written = 0;
  }
  sh_load_points((const real *)job->p + 3 * at, rows, s->w);
  vreal r2 = {0};
  if (solid)
    r2 = s->w[0] * s->w[0] + s->w[1] * s->w[1] + s->w[2] * s->w[2];
  else {
    sh_unit(s->w, &s->inverse, job->tame);
    for (int c = 0; c < 3; c++) s->wd[c] = s->w[c] * s->inverse;
    sh_pole(s->w, &s->sign, &s->o);
    s->o *= s->sign;
  }
  const real *k = job->table;
  for (int l = 0; l <= job->lmax; k += l ? 7 * (l + 1) : 0, l++) {
    degree(s, l, k, order, solid, r2);
    for (int i = 0; i <= order; i++) {
      if (!s->out[i].out)
        s->out[i].have = 0;
      else if (l == job->lmax || s->out[i].have >= SH_WAITING)
        flush(&s->out[i], l == job->lmax, rows);
    }
  }
}

YLM_INLINE void batches(const ylm__sh_job *job, state *s, size_t begin, size_t end, int order,
                        bool solid) {
  for (size_t i = begin; i < end; i += W) batch(job, s, i, end - i < W ? end - i : W, order, solid);
}

/* Columns that results of order i may have waiting, the last block included. */
static size_t capacity(int lmax, int i) {
  static const size_t width[3] = {1, 3, 6};
  return W + SH_WAITING + width[i] * (2 * (size_t)lmax + 1);
}

/* Number of vectors that the rows of one degree take: three past the last are read. */
static size_t row_size(int lmax) { return (size_t)lmax + 3; }

size_t YLM_REAL_KERNEL(ylm__sh_scratch)(int lmax) {
  size_t n = 26 * row_size(lmax);
  for (int i = 0; i < 3; i++) n += capacity(lmax, i);
  return n * sizeof(vreal);
}

void YLM_REAL_KERNEL(ylm__sh_recurrence)(const ylm__sh_job *job, size_t begin, size_t end,
                                         void *scratch) {
  state s;
  vreal *next = scratch;
  size_t n = row_size(job->lmax);
  row *const rows[] = {&s.f0, &s.f1, &s.f2, &s.d0, &s.d1, &s.p0, &s.p1, &s.g0, &s.g1};
  memset(scratch, 0, 26 * n * sizeof(vreal));
  for (size_t i = 0; i < 9; i++) {
    size_t size = i < 7 ? n : 3 * n;
    rows[i]->c = next, rows[i]->s = next + size;
    next += 2 * size;
  }
  for (int i = 0; i < 3; i++) {
    s.out[i].v = next;
    next += capacity(job->lmax, i);
  }
  switch (job->derivatives + (job->solid ? 3 : 0)) {
  case 0: batches(job, &s, begin, end, 0, false); break;
  case 1: batches(job, &s, begin, end, 1, false); break;
  case 2: batches(job, &s, begin, end, 2, false); break;
  case 3: batches(job, &s, begin, end, 0, true); break;
  case 4: batches(job, &s, begin, end, 1, true); break;
  default: batches(job, &s, begin, end, 2, true); break;
  }
}
