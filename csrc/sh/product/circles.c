/*
** circles.c - logarithms of circles, and approximate exponentials by tables of them.
**
** log f = R q(max(D, epsilon max D)) R' (f - 1) of exponential.c, with the block of order 0 of the matrix alone.
** A circle whose logarithm has |f^| gives the line of OL: a = g_00/sqrt(4 pi), b = g.f^/f^.f^,
** with g = e^(-f_00/sqrt(4 pi)) times the circle.
**
** Source  Ren et al. 2006; docs/shadow_fields.md
*/
#include "circles.h"

#include <math.h>
#include <string.h>

static const char *const names[] = {
#define X(name) #name,
    YLM_SH_EXP_METHOD_LIST(X)
#undef X
};

const char *ylm_sh_exp_method_name(ylm_sh_exp_method m) {
  return (unsigned)m < YLM_SH_EXP_METHOD_COUNT ? names[m] : "?";
}

/* -- logarithms of circles ----------------------------------------------------------------------- */

/* Coefficients Y(l, 0) of 1 outside of a circle about z. */
static void circle(int lmax, double angle, double *f) {
  double x = cos(angle), s = sin(angle), half = sin(angle / 2);
  double p = 1, after = x, before = 0, derivative = 1; /* P_l, and P_l' by its recurrence */
  f[0] = SQRT_4PI * (1 - half * half);
  for (int l = 1; l <= lmax; l++) {
    double next = ((2 * l + 1) * x * after - l * p) / (l + 1), degree = 2 * l + 1;
    f[l] = -SQRT_4PI / 2 * sqrt(degree) / (l * (l + 1.0)) * s * s * derivative;
    double raised = before + degree * after;
    before = derivative;
    derivative = raised;
    p = after;
    after = next;
  }
}

/* The rule by which matrices of order 0 are integrated: [nodes] weights, then [nodes][lmax+1] values of Y(l, 0). */
typedef struct rule {
  int lmax, nodes;
  double *weight, *y;
} rule;

static ylm_status rule_create(int lmax, rule *r) {
  size_t n = 2 * (size_t)lmax + 2, count = (size_t)lmax + 1;
  *r = (rule){.lmax = lmax, .nodes = (int)n};
  r->weight = ylm_alloc(2 * n + n * count, sizeof *r->weight);
  if (!r->weight) return YLM_ENOMEM;
  double *z = r->weight + n;
  r->y = z + n;
  ylm_sh_gauss_legendre((int)n, z, r->weight);
  for (size_t i = 0; i < n; i++) {
    double before = 0, p = 1;
    for (int l = 0; l <= lmax; l++) {
      r->y[i * count + (size_t)l] = sqrt(2 * l + 1) / SQRT_4PI * p;
      double next = ((2 * l + 1) * z[i] * p - l * before) / (l + 1);
      before = p;
      p = next;
    }
  }
  return YLM_OK;
}

/* M_ij = 2 pi int f Y(i, 0) Y(j, 0) dz */
static void multiplier(const rule *r, const double *f, double *matrix) {
  size_t n = (size_t)r->lmax + 1;
  memset(matrix, 0, n * n * sizeof *matrix);
  for (int k = 0; k < r->nodes; k++) {
    const double *y = r->y + (size_t)k * n;
    double value = 0;
    for (size_t l = 0; l < n; l++) value += f[l] * y[l];
    value *= SQRT_4PI * SQRT_4PI / 2 * r->weight[k];
    for (size_t i = 0; i < n; i++)
      for (size_t j = 0; j < n; j++) matrix[i * n + j] += value * y[i] * y[j];
  }
}

/* log x/(x - 1) */
static double quotient(double x) {
  double d = x - 1;
  return fabs(d) < 1e-4 ? 1 - d / 2 + d * d / 3 - d * d * d / 4 : log(x) / d;
}

/* room: [n][n], 3 [n] */
static ylm_status circle_log(const rule *r, double angle, double epsilon, double *z, double *room,
                             ylm_error *e) {
  size_t n = (size_t)r->lmax + 1;
  double *matrix = room, *w = matrix + n * n, *f = w + n, *part = f + n;
  circle(r->lmax, angle, f);
  multiplier(r, f, matrix);
  ylm_status s = ylm__sh_eigen((int)n, matrix, w);
  if (s != YLM_OK) return s;
  double most = 0;
  for (size_t i = 0; i < n; i++) most = fmax(most, w[i]);
  if (!(most > 1e-12))
    return ylm_fail(e, YLM_EDOMAIN, "the circle leaves nothing open, which has no logarithm");
  f[0] -= SQRT_4PI;
  for (size_t k = 0; k < n; k++) {
    part[k] = 0;
    for (size_t i = 0; i < n; i++) part[k] += matrix[i * n + k] * f[i];
    part[k] *= quotient(fmax(w[k], epsilon * most));
  }
  for (size_t i = 0; i < n; i++) {
    z[i] = 0;
    for (size_t k = 0; k < n; k++) z[i] += matrix[i * n + k] * part[k];
  }
  return YLM_OK;
}

static size_t log_room(int lmax) {
  size_t n = (size_t)lmax + 1;
  return n * n + 3 * n;
}

ylm_status ylm_sh_circle_log(int lmax, double angle, double epsilon, double *z, ylm_error *e) {
  if (lmax < 0 || lmax > YLM_SH_PRODUCT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_SH_PRODUCT_LMAX, lmax);
  rule r;
  ylm_status s = rule_create(lmax, &r);
  double *room = ylm_alloc(log_room(lmax), sizeof *room);
  if (!room) s = YLM_ENOMEM;
  if (s == YLM_OK) s = circle_log(&r, angle, epsilon, z, room, e);
  ylm_free(room);
  ylm_free(r.weight);
  return s;
}

/* -- tables ----------------------------------------------------------------------------------------- */

static double angle_of(size_t i) { return SQRT_4PI * SQRT_4PI / 8 * (double)i / (CIRCLES - 1); }

/* |f^|, a and b of circle i. */
static void line_of(const ylm_sh_exponential *p, size_t i, double *g, double out[3]) {
  size_t n = (size_t)p->lmax + 1;
  const double *f = p->log + i * n;
  double square = 0, along = 0, scale = exp(-f[0] / SQRT_4PI);
  circle(p->lmax, angle_of(i), g);
  for (size_t l = 1; l < n; l++) {
    square += f[l] * f[l];
    along += scale * g[l] * f[l];
  }
  out[0] = sqrt(square);
  out[1] = scale * g[0] / SQRT_4PI;
  out[2] = square > 0 ? along / square : 1;
}

/* a and b at even steps of |f^|, of the angles up to the one of the largest |f^|. */
static ylm_status fill_lines(ylm_sh_exponential *p, double *room) {
  double *line = ylm_alloc(3 * CIRCLES, sizeof *line);
  if (!line) return YLM_ENOMEM;
  size_t n = 0;
  for (size_t i = 0; i < CIRCLES; i++) {
    line_of(p, i, room, line + 3 * n);
    if (n == 0 || line[3 * n] > line[3 * n - 3]) n++;
  }
  p->reach = n > 1 ? line[3 * n - 3] : 1;
  for (size_t k = 0, i = 0; k < LINES; k++) {
    double x = p->reach * (double)k / (LINES - 1);
    while (i + 2 < n && line[3 * i + 3] < x) i++;
    const double *a = line + 3 * i, *b = n > 1 ? a + 3 : a;
    double t = b[0] > a[0] ? fmin(1, fmax(0, (x - a[0]) / (b[0] - a[0]))) : 0;
    for (size_t c = 0; c < 2; c++) p->lines[2 * k + c] = a[c + 1] + t * (b[c + 1] - a[c + 1]);
  }
  ylm_free(line);
  return YLM_OK;
}

static ylm_status fill(ylm_sh_exponential *p, ylm_error *e) {
  size_t n = (size_t)p->lmax + 1;
  rule r;
  p->log = ylm_alloc(CIRCLES * n, sizeof *p->log);
  p->lines = ylm_alloc((size_t)LINES * 2, sizeof *p->lines);
  double *room = ylm_alloc(log_room(p->lmax), sizeof *room);
  ylm_status s = rule_create(p->lmax, &r);
  if (!p->log || !p->lines || !room) s = YLM_ENOMEM;
  for (size_t i = 0; i < CIRCLES && s == YLM_OK; i++)
    s = circle_log(&r, angle_of(i), YLM_SH_EXP_EPSILON, p->log + i * n, room, e);
  if (s == YLM_OK) s = fill_lines(p, room);
  ylm_free(room);
  ylm_free(r.weight);
  return s;
}

ylm_status ylm_sh_exponential_create(int lmax, ylm_sh_exp_method m, int terms,
                                     ylm_sh_exponential **out, ylm_error *e) {
  *out = NULL;
  if (lmax < 0 || lmax > YLM_SH_LOG_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax of logarithms must be from 0 to %d, got %d",
                    YLM_SH_LOG_LMAX, lmax);
  if ((unsigned)m >= YLM_SH_EXP_METHOD_COUNT)
    return ylm_fail(e, YLM_EINVAL, "there is no such exponential");
  if (terms < 1 || terms > YLM_SH_EXP_TERMS)
    return ylm_fail(e, YLM_ERANGE, "1 to %d terms expected, got %d", YLM_SH_EXP_TERMS, terms);
  ylm_sh_exponential *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  p->lmax = lmax;
  p->method = m;
  p->terms = terms;
  ylm_status s =
      ylm_sh_product_create(lmax, 2, YLM_SH_PRODUCT_auto, YLM_SH_PRODUCT_auto, &p->product, e);
  if (s == YLM_OK) s = fill(p, e);
  if (s == YLM_OK)
    *out = p;
  else
    ylm_sh_exponential_free(p);
  return s;
}

void ylm_sh_exponential_free(ylm_sh_exponential *p) {
  if (!p) return;
  ylm_sh_product_free(p->product);
  ylm_free(p->log);
  ylm_free(p->lines);
  ylm_free(p);
}

double ylm_sh_exponential_reach(const ylm_sh_exponential *p) { return p->reach; }

void ylm_sh_exponential_circle(const ylm_sh_exponential *p, double angle, double *z,
                               double *slope) {
  size_t n = (size_t)p->lmax + 1;
  double step = 1 / angle_of(1), t = fmin(CIRCLES - 1, fmax(0, angle * step)), along;
  for (size_t l = 0; l < n; l++) {
    z[l] = table_at(p->log, CIRCLES, n, l, t, &along);
    if (slope) slope[l] = t < CIRCLES - 1 ? along * step : 0;
  }
}

/* -- rows --------------------------------------------------------------------------------------------- */

typedef struct job {
  const ylm_sh_exponential *p;
  ylm_dtype t;
  size_t rows;
  const void *in;
  void *out;
  ylm_error *e;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  void *room = ylm_alloc(exponential_room(j->p, j->rows), ylm_dtype_size(j->t));
  ylm_status s = room ? YLM_OK : YLM_ENOMEM;
  for (; begin < end && s == YLM_OK; begin += EXPONENTIAL_ROWS) {
    size_t to = end - begin < EXPONENTIAL_ROWS ? end : begin + EXPONENTIAL_ROWS;
    s = j->t == YLM_DOUBLE
            ? ylm__sh_exponential_d(j->p, begin, to, j->rows, j->in, j->out, room, j->e)
            : ylm__sh_exponential_f(j->p, begin, to, j->rows, j->in, j->out, room, j->e);
  }
  ylm_free(room);
  return s;
}

ylm_status ylm_sh_exponential_apply(const ylm_sh_exponential *p, ylm_dtype t, size_t n,
                                    int derivatives, const void *in, void *out, int threads,
                                    const ylm_progress *progress, ylm_error *e) {
  if (derivatives != 0 && derivatives != 3)
    return ylm_fail(e, YLM_ERANGE, "derivatives must be 0 or 3, got %d", derivatives);
  job j = {.p = p, .t = t, .rows = 1 + (size_t)derivatives, .in = in, .out = out};
  ylm_status s = YLM_ERANGE;
  if (n > EXPONENTIAL_ROWS || progress) {
    s = ylm_parallel(n, 4 * EXPONENTIAL_ROWS, threads, run, &j, progress, "exp");
    if (s != YLM_ERANGE) return s;
  }
  j.e = e; /* one thread names the first row that fails */
  return run(&j, 0, n, 0);
}
