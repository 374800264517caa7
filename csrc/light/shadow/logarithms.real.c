/* logarithms.real.c - exponentials of sums of logarithms: the visibility of many spheres at once. */
#include "block.h"

#include <math.h>

/* Adds the logarithm of a circle to a row: its table, turned to where the circle stands. y, dy: the basis there. */
static void add_logarithm(const shadow_query *w, const shadow_seen *s, const shadow_part *x,
                          const real *y, const real *dy, real *to) {
  double z[YLM_SH_LOG_LMAX + 1], slope[YLM_SH_LOG_LMAX + 1], over = 1 / fmax(1e-300, s->distance);
  double wide = s->sine < 1 ? s->sine / sqrt(1 - s->sine * s->sine) * over : 0;
  ylm_sh_exponential_circle(w->exponential, shadow_angle(s), z, slope);
  for (int l = 0; l <= w->q->lmax; l++) {
    double part = LIGHT_ONE / sqrt(2 * l + 1);
    for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++) {
      double value = part * z[l] * (double)y[k];
      to[k] += (real)(x->weight * value);
      for (size_t d = 0; d + 1 < w->rows; d++)
        to[(d + 1) * w->count + k] += (real)(x->weight * part *
                                                 (slope[l] * wide * s->w[d] * (double)y[k] -
                                                  z[l] * over * (double)dy[3 * k + d]) +
                                             x->slope[d] * value);
    }
  }
}

/* Sums of logarithms of the lanes' casters. */
static ylm_status sum_logarithms(const tile *t, real *sum) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  size_t n = 0, k = 0;
  for (size_t i = 0; i < t->n; i++) n += t->term[i]->n;
  real *at = ylm_alloc(3 * n, sizeof *at), *y = ylm_alloc(n * w->count, sizeof *y),
       *dy = w->rows > 1 ? ylm_alloc(3 * n * w->count, sizeof *dy) : NULL;
  ylm_status s = at && y && (w->rows == 1 || dy) ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < t->n && s == YLM_OK; i++)
    for (size_t j = 0; j < t->term[i]->n; j++, k++) {
      const double *v = b->seen[b->before[t->term[i]->first + j].seen].w;
      bool middle = v[0] == 0 && v[1] == 0 && v[2] == 0; /* of the caster: dark in any case */
      for (size_t a = 0; a < 3; a++) at[3 * k + a] = middle ? 1 : (real)v[a];
    }
  if (s == YLM_OK && n)
    s = ylm_sh_eval(w->q->lmax, w->rows > 1, false, DTYPE, n, at, y, dy, NULL, 1, b->e);
  k = 0;
  for (size_t i = 0; i < t->n && s == YLM_OK; i++)
    for (size_t j = 0; j < t->term[i]->n; j++, k++) {
      const shadow_before *x = &b->before[t->term[i]->first + j];
      add_logarithm(w, &b->seen[x->seen], &b->part[x->part], y + k * w->count,
                    dy ? dy + 3 * k * w->count : NULL, sum + i * w->rows * w->count);
    }
  ylm_free(at);
  ylm_free(y);
  ylm_free(dy);
  return s;
}

ylm_status SHADOW(exponentials)(const tile *t) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  size_t wide = w->rows * w->count;
  real *sum = ylm_alloc_zero(t->n * wide, sizeof *sum),
       *open = ylm_alloc(t->n * wide, sizeof *open);
  const real *row[16];
  ylm_status s = sum && open ? sum_logarithms(t, sum) : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm_sh_exponential_apply(w->exponential, DTYPE, t->n, w->rows > 1 ? 3 : 0, sum, open, 1,
                                 NULL, NULL);
  if (s == YLM_ERANGE) {
    const double *p = b->point[t->term[0]->point];
    ylm_fail(
        b->e, s,
        "the series of the exponential diverges near {%.6g, %.6g, %.6g}, where casters look too "
        "large: exp = 'HYB' does not",
        p[0], p[1], p[2]);
  }
  for (size_t i = 0; i < t->lanes && s == YLM_OK; i++)
    row[i] = open + (i < t->n ? i : t->n - 1) * wide;
  for (size_t d = 0; d < w->rows && s == YLM_OK; d++)
    SHADOW(to_nodes)(t, row, d, false, d ? t->g[d - 1] : t->f);
  ylm_free(sum);
  ylm_free(open);
  return s;
}
