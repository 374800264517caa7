/*
** sampled.c - light that is known at a few places and blended between them, as a kind of light.
**
** The coefficients at a place x are a mean of those of the samples, weighted by 1/distance^power:
**
**   L(x) = sum w_j L_j,   w_j = u_j / sum u_k,   u_j = |x - x_j|^-power
**
** With g_j = grad log u_j = -p (x - x_j)/|x - x_j|^2, b = sum w_k g_k and
** M = sum w_k (g_k g_k' + grad g_k):
**
**   grad w_j = w_j (g_j - b)
**   H w_j    = w_j ((g_j - b)(g_j - b)' + grad g_j - M + b b')
**
** All is summed as differences from the nearest sample m, L = L_m + sum w_j (L_j - L_m): what is
** steep there cancels in b alone. At a sample the light is its own; the gradient is 0, and so is
** the Hessian but for the power 2. The kind has no records: ylm_light_set_sampled makes a set of
** one. Rays see nothing.
**
** Source  Green 2003, "Local Lighting"; Sloan et al. 2002; Shepard 1968; docs/math.md "Light from
**         samples"
*/
#include <float.h>
#include <math.h>
#include <string.h>

#include "../calibration.h"
#include "../finite.h"
#include "../set.h"
#include "ylm_sh.h"

typedef struct sampled {
  ylm_field field; /* whose `self` it is */
  size_t n;
  int lmax;
  double power;
  double *at;           /* [n][3] */
  double *coefficients; /* [n][3][(lmax+1)^2] */
} sampled;

static void release(void *of) {
  sampled *s = of;
  if (!s) return;
  ylm_free(s->at);
  ylm_free(s->coefficients);
  ylm_free(s);
}

/* -- weights -------------------------------------------------------------------------------- */

/* Of a sample at a place: 1, gradient, Hessian xx xy xz yy yz zz of its weight, one after the
   other. */
enum { VALUE, GRADIENT, HESSIAN = 4, WIDE = 10 };
typedef struct weight {
  double of[WIDE], log[3], distance2;
} weight;

/* Nearer than this, squared, a place is the sample. */
#define HERE 1e-280

static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};

/* Squared distances from x, and the nearest sample. */
static size_t measure(const sampled *s, const double x[3], weight *w) {
  size_t nearest = 0;
  for (size_t j = 0; j < s->n; j++) {
    double d2 = 0;
    for (size_t a = 0; a < 3; a++) d2 += (x[a] - s->at[3 * j + a]) * (x[a] - s->at[3 * j + a]);
    w[j].distance2 = d2;
    if (d2 < w[nearest].distance2) nearest = j;
  }
  return nearest;
}

/* At sample m: its weight is 1, and bends only where the power is 2. */
static void settle_here(const sampled *s, size_t m, weight *w) {
  for (size_t j = 0; j < s->n; j++) {
    memset(w[j].of, 0, sizeof w[j].of);
    if (j == m || s->power > 2) continue;
    for (int k = 0; k < 6; k++)
      if (row[k] == column[k]) w[j].of[HESSIAN + k] = 2 / w[j].distance2;
  }
}

/* b and M of the file's head. */
static void means(const sampled *s, const weight *w, double b[3], double m[6]) {
  memset(b, 0, 3 * sizeof *b);
  memset(m, 0, 6 * sizeof *m);
  for (size_t j = 0; j < s->n; j++) {
    const double *g = w[j].log, u = w[j].of[VALUE], round = s->power / w[j].distance2;
    for (int a = 0; a < 3; a++) b[a] += u * g[a];
    for (int k = 0; k < 6; k++)
      m[k] += u * ((1 + 2 / s->power) * g[row[k]] * g[column[k]] - (row[k] == column[k]) * round);
  }
}

/* The weights at x with their derivatives, and the nearest sample, whose own is 1 and at rest. */
static size_t weigh(const sampled *s, const double x[3], bool derivatives, weight *w) {
  size_t m = measure(s, x, w);
  if (w[m].distance2 < HERE) {
    settle_here(s, m, w);
    return m;
  }
  double all = 0, b[3], M[6];
  for (size_t j = 0; j < s->n; j++) {
    w[j].of[VALUE] = pow(w[m].distance2 / w[j].distance2, s->power / 2);
    w[j].of[HESSIAN] = 0;
    all += w[j].of[VALUE];
  }
  for (size_t j = 0; j < s->n; j++) w[j].of[VALUE] /= all;
  if (!derivatives) return m;
  for (size_t j = 0; j < s->n; j++)
    for (size_t a = 0; a < 3; a++)
      w[j].log[a] = -s->power * (x[a] - s->at[3 * j + a]) / w[j].distance2;
  means(s, w, b, M);
  for (size_t j = 0; j < s->n; j++) {
    double u = w[j].of[VALUE], round = s->power / w[j].distance2;
    const double *g = w[j].log;
    for (int a = 0; a < 3; a++) w[j].of[GRADIENT + a] = u * (g[a] - b[a]);
    for (int k = 0; k < 6; k++) {
      int p = row[k], q = column[k];
      double own = 2 / s->power * g[p] * g[q] - (p == q) * round;
      w[j].of[HESSIAN + k] = u * ((g[p] - b[p]) * (g[q] - b[q]) + own - M[k] + b[p] * b[q]);
    }
  }
  return m;
}

/* -- the field ------------------------------------------------------------------------------ */

typedef struct job {
  const sampled *s;
  const ylm_field_query *q;
  const void *points;
  ylm_field_result *r;
  bool derivatives;
} job;

/* Weights that are less than this change nothing. */
#define LEAST 1e-40
/* Of values alone this, which n weights leave below rounding. */
#define LESS 1e-21

/* Adds weighted differences of `count` coefficients to value, gradient and Hessian behind one another. */
static void add_all(size_t count, const double *of, const double *x, const double *base,
                    double *value) {
  double *slope = value + count, *bend = slope + 3 * count;
  for (size_t k = 0; k < count; k++) {
    double d = x[k] - base[k];
    value[k] += of[VALUE] * d;
    for (size_t a = 0; a < 3; a++) slope[3 * k + a] += of[GRADIENT + a] * d;
    for (size_t a = 0; a < 6; a++) bend[6 * k + a] += of[HESSIAN + a] * d;
  }
}

/* Sums [3][10 (lmax+1)^2], as ylm__field_write takes them; those of derivatives are written where they are wanted. */
static void blend(const job *j, const weight *w, size_t m, double *sum) {
  size_t count = ylm_sh_count(j->q->lmax), known = ylm_sh_count(j->s->lmax), wide = WIDE * count;
  const double *base = j->s->coefficients + 3 * m * known;
  if (j->derivatives) memset(sum, 0, 3 * wide * sizeof *sum);
  for (size_t c = 0; c < 3; c++) memcpy(sum + c * wide, base + c * known, count * sizeof *sum);
  for (size_t i = 0; i < j->s->n; i++) {
    const double *x = j->s->coefficients + 3 * i * known, *of = w[i].of;
    if (i == m || (of[VALUE] < (j->derivatives ? LEAST : LESS) && of[HESSIAN] == 0)) continue;
    for (size_t c = 0; c < 3; c++, x += known) {
      const double *from = base + c * known;
      double *value = sum + c * wide;
      if (j->derivatives)
        add_all(count, of, x, from, value);
      else
        for (size_t k = 0; k < count; k++) value[k] += of[VALUE] * (x[k] - from[k]);
    }
  }
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t wide = WIDE * ylm_sh_count(j->q->lmax);
  double *sum = ylm_alloc(3 * wide, sizeof *sum);
  weight *w = ylm_alloc(j->s->n, sizeof *w);
  for (size_t i = begin; i < end && sum && w; i++) {
    double x[3];
    for (size_t a = 0; a < 3; a++) {
      x[a] = ylm_get(j->q->dtype, j->points, 3 * i + a);
      if (j->q->origin) x[a] += j->q->origin[a];
    }
    size_t m = weigh(j->s, x, j->derivatives, w);
    blend(j, w, m, sum);
    ylm__field_write(j->q, i, 3, sum, wide, j->r);
    if (j->r->inside) j->r->inside[i] = 0;
  }
  ylm_status status = sum && w ? YLM_OK : YLM_ENOMEM;
  ylm_free(sum);
  ylm_free(w);
  return status;
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const sampled *s = f->self;
  ylm_status status = ylm_field_check(q, n, points, r, YLM_LIGHT_LMAX, "these lights", e);
  if (status != YLM_OK) return status;
  if (q->lmax > s->lmax)
    return ylm_fail(e, YLM_ERANGE, "a sampled light is known to lmax %d, and asked for at lmax %d",
                    s->lmax, q->lmax);
  job j = {s, q, points, r, q->want & (YLM_WANT_GRADIENT | YLM_WANT_HESSIAN | YLM_WANT_METRIC)};
  status = ylm_parallel(n, SAMPLED_GRAIN, q->threads, run, &j, q->progress, "lights");
  if (status != YLM_OK) return ylm_fail_plain(e, status);
  r->pairs += (uint64_t)n * s->n;
  return ylm_light_finite(q, n, points, r, e);
}

/* The field jumps nowhere. */
static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  (void)f, (void)boxes;
  memset(out, 0, n);
  return YLM_OK;
}

const ylm__light_kind ylm__sampled_kind = {.name = "sampled", .free = release};

/* -- a set of one --------------------------------------------------------------------------- */

static ylm_status check_place(const ylm_light_sampled *l, size_t i, ylm_error *e) {
  for (size_t a = 0; a < 3; a++)
    if (!(fabs(l->at[3 * i + a]) <= YLM_LIGHT_EXTENT))
      return ylm_fail(e, YLM_ERANGE, "sample %zu is not finite, or is too far out", i + 1);
  for (size_t j = 0; j < i; j++) {
    double d2 = 0;
    for (size_t a = 0; a < 3; a++)
      d2 += (l->at[3 * i + a] - l->at[3 * j + a]) * (l->at[3 * i + a] - l->at[3 * j + a]);
    if (d2 < HERE)
      return ylm_fail(e, YLM_EDOMAIN, "samples %zu and %zu are at one place", j + 1, i + 1);
  }
  return YLM_OK;
}

static ylm_status check(const ylm_light_sampled *l, ylm_error *e) {
  size_t where, wide = 3 * ylm_sh_count(l->lmax);
  if (l->n < 1 || l->n > YLM_LIGHT_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "1 to %d samples expected, got %zu", YLM_LIGHT_SAMPLES, l->n);
  if (!(l->power >= 2 && l->power <= 100))
    return ylm_fail(e, YLM_ERANGE, "the power must be from 2 to 100, got %g", l->power);
  for (size_t i = 0; i < l->n; i++) {
    ylm_status s = check_place(l, i, e);
    if (s != YLM_OK) return s;
  }
  if (ylm_all_finite(YLM_DOUBLE, l->coefficients, l->n * wide, &where)) return YLM_OK;
  return ylm_fail(e, YLM_EDOMAIN, "sample %zu: a coefficient is not finite", where / wide + 1);
}

ylm_status ylm_light_set_sampled(const ylm_light_sampled *light, ylm_light_set **set,
                                 ylm_error *e) {
  *set = NULL;
  if (light->lmax < 0 || light->lmax > YLM_LIGHT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be 0 .. %d, got %d", YLM_LIGHT_LMAX, light->lmax);
  ylm_status status = check(light, e);
  if (status != YLM_OK) return status;
  sampled *s = ylm_alloc_zero(1, sizeof *s);
  if (!s) return ylm_no_memory(e);
  *s = (sampled){{.self = s, .evaluate = evaluate, .crosses = crosses, .relative = true},
                 light->n,
                 light->lmax,
                 light->power,
                 NULL,
                 NULL};
  s->at = ylm_alloc_copy(light->at, 3 * light->n, sizeof *s->at);
  s->coefficients = ylm_alloc_copy(light->coefficients, 3 * light->n * ylm_sh_count(light->lmax),
                                   sizeof *s->coefficients);
  if (s->at && s->coefficients) {
    ylm__light_pack made = {&ylm__sampled_kind, s, &s->field, 1, 0};
    return ylm__light_set_of_pack(&made, set, e);
  }
  release(s);
  return ylm_no_memory(e);
}
