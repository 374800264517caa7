/* rotate.c - rotation of coefficient vectors: angles, blocks, batches; kernels in rotate_kernel.h. */
#include "ylm_sh.h"

#include <math.h>
#include <string.h>

#include "rotate.h"

/* The angles of an exact rotation R = Rz(a) Ry(b) Rz(c), in the form that the kernels want. */
static void angles_of(const double r[9], ylm__angles *a) {
  double sb2 = r[2] * r[2] + r[5] * r[5], cb = r[8], ca = 1, sa = 0;
  if (sb2 == 0 && cb > 0) {
    *a = (ylm__angles){{1, 1, r[0]}, {0, 0, r[3]}, TURN_FLAT};
    return;
  }
  if (sb2 == 0) { /* R = Rz(a) Rx(pi) */
    *a = (ylm__angles){{r[0], 1, 1}, {r[3], 0, 0}, TURN_HALF};
    return;
  }
  double sb = sqrt(sb2), inverse = 1 / sb;
  ca = r[2] * inverse;
  sa = r[5] * inverse;
  /* Rz(-a) R = Ry(b) Rz(c): its second row is (sin c, cos c, 0), well conditioned for every b */
  double sc = ca * r[3] - sa * r[0], cc = ca * r[4] - sa * r[1];
  if (cb == 0 && (ca == 0 || sa == 0) && (sc == 0 || cc == 0)) {
    /* Ry(pi/2) = Rz(pi/2) Rx(pi/2) Rz(-pi/2): a + pi/2, c - pi/2 */
    *a = (ylm__angles){{-sa, 1, sc}, {ca, 0, -cc}, TURN_QUARTER};
    return;
  }
  *a = (ylm__angles){{-ca, -cb, cc}, {-sa, -sb, sc}, TURN_GENERAL};
}

/* -- blocks ----------------------------------------------------------------------------------- */

struct ylm_sh_rotation {
  int lmax;
  ylm_dtype t;
  ylm_sh_rotator *plan; /* kept alive */
  ylm__rotate_batch batch;
  size_t *at; /* [blocked+1] where each degree's padded columns begin */
  void *blocks, *turns;
};

/* x = Z x, x [2l+1][n] the rows of a degree. */
static void turn_rows(int l, int n, double c1, double s1, double *x) {
  double c = c1, s = s1;
  for (int m = 1; m <= l; m++) {
    double *a = x + (l + m) * n, *b = x + (l - m) * n;
    for (int i = 0; i < n; i++) {
      double ai = a[i], bi = b[i];
      a[i] = c * ai - s * bi;
      b[i] = s * ai + c * bi;
    }
    double next = c * c1 - s * s1;
    s = c * s1 + s * c1;
    c = next;
  }
}

/* y = J x */
static void quarter_rows(int l, const double *j, const double *x, double *y) {
  int n = 2 * l + 1;
  memset(y, 0, (size_t)(n * n) * sizeof *y);
  for (int q = 0; q < n; q++)
    for (int m = 0; m < n; m++) {
      double v = j[q * n + m];
      if (v == 0) continue;
      for (int i = 0; i < n; i++) y[q * n + i] += v * x[m * n + i];
    }
}

/* The block of degree l, row-major, in x; y is scratch of the same size. */
static void build(const ylm_sh_rotator *p, const ylm__angles *a, int l, double *x, double *y) {
  int n = 2 * l + 1;
  const double *j = p->dense + p->dense_at[l];
  memset(x, 0, (size_t)(n * n) * sizeof *x);
  for (int i = 0; i < n; i++) x[i * n + i] = 1;
  turn_rows(l, n, a->c[2], a->s[2], x);
  switch (a->turn) {
  case TURN_FLAT: return;
  case TURN_HALF:
    for (int m = -l; m <= l; m++)
      if (half_turn_sign(l, m) < 0)
        for (int i = 0; i < n; i++) x[(m + l) * n + i] = -x[(m + l) * n + i];
    break;
  case TURN_QUARTER:
    memcpy(y, x, (size_t)(n * n) * sizeof *x);
    quarter_rows(l, j, y, x);
    break;
  default:
    quarter_rows(l, j, x, y);
    turn_rows(l, n, a->c[1], a->s[1], y);
    quarter_rows(l, j, y, x);
  }
  turn_rows(l, n, a->c[0], a->s[0], x);
}

void ylm_sh_rotation_free(ylm_sh_rotation *r) {
  if (!r) return;
  ylm_sh_rotator_free(r->plan);
  ylm_free(r->at);
  ylm_free(r->blocks);
  ylm_free(r->turns);
  ylm_free(r);
}

int ylm_sh_rotation_lmax(const ylm_sh_rotation *r) { return r->lmax; }
ylm_dtype ylm_sh_rotation_dtype(const ylm_sh_rotation *r) { return r->t; }

static int lanes_of(ylm_dtype t) { return t == YLM_DOUBLE ? 8 : 16; }

/* Cosines and sines of m times the three angles. */
static void fill_turns(const ylm__angles *a, int lmax, ylm_dtype t, void *turns) {
  size_t row = (size_t)lmax + 1;
  for (size_t i = 0; i < 3; i++) {
    double c = 1, s = 0;
    for (size_t m = 0; m < row; m++) {
      ylm_put(t, turns, 2 * i * row + m, c);
      ylm_put(t, turns, (2 * i + 1) * row + m, s);
      double next = c * a->c[i] - s * a->s[i];
      s = c * a->s[i] + s * a->c[i];
      c = next;
    }
  }
}

static void fill_blocks(ylm_sh_rotation *r, double *x, double *y) {
  for (int l = 0; l <= r->batch.blocked; l++) {
    int w = 2 * l + 1, padded = rotate_padded(l, lanes_of(r->t));
    build(r->plan, &r->batch.angles, l, x, y);
    for (int q = 0; q < w; q++)
      for (int m = 0; m < w; m++)
        ylm_put(r->t, r->blocks, r->at[l] + (size_t)(m * padded + q), x[q * w + m]);
  }
}

static ylm_status create(const ylm_sh_rotator *p, const ylm__angles *a, int lmax, ylm_dtype t,
                         ylm_sh_rotation **out) {
  int blocked = p->kernels && lmax > ROTATE_BLOCKS ? ROTATE_BLOCKS : lmax;
  size_t n = (size_t)(2 * blocked + 1), total = 0;
  ylm_sh_rotation *r = ylm_alloc_zero(1, sizeof *r);
  if (!r) return YLM_ENOMEM;
  double *x = ylm_alloc(2 * n * n, sizeof *x);
  r->at = ylm_alloc((size_t)blocked + 1, sizeof(size_t));
  for (int l = 0; r->at && l <= blocked; l++) {
    r->at[l] = total;
    total += (size_t)((2 * l + 1) * rotate_padded(l, lanes_of(t)));
  }
  r->blocks = ylm_alloc_zero(total, ylm_dtype_size(t));
  r->turns = ylm_alloc(6 * ((size_t)lmax + 1), ylm_dtype_size(t));
  if (!x || !r->at || !r->blocks || !r->turns) {
    ylm_free(x);
    ylm_sh_rotation_free(r);
    return YLM_ENOMEM;
  }
  r->lmax = lmax;
  r->t = t;
  r->plan = (ylm_sh_rotator *)(uintptr_t)p;
  __atomic_add_fetch(&r->plan->users, 1, __ATOMIC_RELAXED);
  r->batch = (ylm__rotate_batch){p, *a, a->turn, lmax, blocked, r->blocks, r->turns};
  fill_turns(a, lmax, t, r->turns);
  fill_blocks(r, x, x + n * n);
  ylm_free(x);
  *out = r;
  return YLM_OK;
}

static ylm_status check_lmax(const ylm_sh_rotator *p, int lmax, ylm_error *e) {
  if (lmax >= 0 && lmax <= p->lmax) return YLM_OK;
  return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", p->lmax, lmax);
}

ylm_status ylm_sh_rotation_create(const ylm_sh_rotator *p, const double r[9], int lmax, ylm_dtype t,
                                  ylm_sh_rotation **out, ylm_error *e) {
  double exact[9];
  ylm__angles a;
  *out = NULL;
  ylm_status s = check_lmax(p, lmax, e);
  if (s == YLM_OK) s = ylm_sh_rotation_check(r, exact, e);
  if (s != YLM_OK) return s;
  angles_of(exact, &a);
  return create(p, &a, lmax, t, out);
}

ylm_status ylm_sh_rotation_block(const ylm_sh_rotation *r, int l, double *out) {
  if (l < 0 || l > r->lmax) return YLM_ERANGE;
  size_t n = (size_t)(2 * l + 1);
  double *x = ylm_alloc(2 * n * n, sizeof *x);
  if (!x) return YLM_ENOMEM;
  build(r->plan, &r->batch.angles, l, x, x + n * n);
  for (size_t k = 0; k < n * n; k++) out[k] = r->t == YLM_DOUBLE ? x[k] : (double)(float)x[k];
  ylm_free(x);
  return YLM_OK;
}

/* -- applying --------------------------------------------------------------------------------- */

/* The plain form, for the reference set and processors without vectors: every degree has its
   block. */
static void apply_plain(const ylm_sh_rotation *r, int lmax, size_t rows, const void *in,
                        void *out) {
  size_t count = ylm_sh_count(lmax);
  double temporary[2 * YLM_SH_ROTATE_LMAX + 1];
  for (size_t i = 0; i < rows; i++)
    for (int l = 0; l <= lmax; l++) {
      int w = 2 * l + 1, padded = rotate_padded(l, lanes_of(r->t));
      size_t at = i * count + (size_t)(l * l);
      memset(temporary, 0, sizeof temporary);
      for (int m = 0; m < w; m++)
        for (int q = 0; q < w; q++)
          temporary[q] += ylm_get(r->t, r->blocks, r->at[l] + (size_t)(m * padded + q)) *
                          ylm_get(r->t, in, at + (size_t)m);
      for (int q = 0; q < w; q++) ylm_put(r->t, out, at + (size_t)q, temporary[q]);
    }
}

typedef struct job {
  const ylm_sh_rotation *r;
  int lmax;
  const char *in;
  char *out;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t offset = begin * ylm_sh_count(j->lmax) * ylm_dtype_size(j->r->t);
  const void *in = j->in + offset;
  void *out = j->out + offset;
  const ylm__rotate_kernels *k = j->r->plan->kernels;
  if (!k)
    apply_plain(j->r, j->lmax, end - begin, in, out);
  else if (j->r->t == YLM_DOUBLE)
    k->d->apply(&j->r->batch, j->lmax, end - begin, in, out);
  else
    k->f->apply(&j->r->batch, j->lmax, end - begin, in, out);
  return YLM_OK;
}

ylm_status ylm_sh_rotation_apply(const ylm_sh_rotation *r, int lmax, size_t rows, const void *in,
                                 void *out, int threads, const ylm_progress *progress) {
  if (lmax < 0 || lmax > r->lmax) return YLM_ERANGE;
  job j = {r, lmax, in, out};
  size_t grain = lmax > 15 ? 64 : 256;
  if (rows <= grain && !progress) return run(&j, 0, rows, 0);
  return ylm_parallel(rows, grain, threads, run, &j, progress, "rotate");
}

ylm_status ylm_sh_rotate(const ylm_sh_rotator *p, const double r[9], int lmax, ylm_dtype t,
                         size_t rows, const void *in, void *out, int threads,
                         const ylm_progress *progress, ylm_error *e) {
  double exact[9];
  ylm__angles a;
  ylm_status s = check_lmax(p, lmax, e);
  if (s == YLM_OK) s = ylm_sh_rotation_check(r, exact, e);
  if (s != YLM_OK) return s;
  angles_of(exact, &a);
  const ylm__rotate_kernels *k = p->kernels;
  size_t count = ylm_sh_count(lmax);
  /* building the blocks costs about as much as this many rows one at a time */
  if (k && rows <= 4 + (size_t)lmax && in != out) {
    for (size_t i = 0; i < rows; i++) {
      if (t == YLM_DOUBLE)
        k->d->one(p, lmax, &a, (const double *)in + i * count, (double *)out + i * count);
      else
        k->f->one(p, lmax, &a, (const float *)in + i * count, (float *)out + i * count);
    }
    return ylm_report(progress, rows, rows, "rotate");
  }
  ylm_sh_rotation *blocks;
  s = create(p, &a, lmax, t, &blocks);
  if (s == YLM_OK) s = ylm_sh_rotation_apply(blocks, lmax, rows, in, out, threads, progress);
  ylm_sh_rotation_free(blocks);
  return s;
}
