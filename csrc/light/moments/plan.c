/* plan.c - what has to be summed for a query, and the linear maps from sums to results. */
#include "plan.h"
#include "gen/recurrences.h"

#include <math.h>
#include <string.h>

/* -- sparse matrices that are built row by row -------------------------------------- */

void ylm__rows_free(ylm__rows *r) {
  ylm_free(r->start);
  ylm_free(r->index);
  ylm_free(r->coef);
  ylm_free(r->coef_f);
}

ylm_status ylm__rows_create(ylm__rows *r, size_t n, size_t terms) {
  r->n = 0;
  r->start = ylm_alloc_zero(n + 2, sizeof *r->start); /* ylm__rows_end begins one more */
  r->index = ylm_alloc(terms, sizeof *r->index);
  r->coef = ylm_alloc(terms, sizeof *r->coef);
  r->coef_f = ylm_alloc(terms, sizeof *r->coef_f);
  return r->start && r->index && r->coef && r->coef_f ? YLM_OK : YLM_ENOMEM;
}

void ylm__rows_term(ylm__rows *r, size_t index, double coef) {
  if (coef == 0) return;
  uint32_t t = r->start[r->n + 1]++;
  r->index[t] = (uint32_t)index;
  r->coef[t] = coef;
  r->coef_f[t] = (float)coef;
}

void ylm__rows_end(ylm__rows *r) {
  r->n++;
  r->start[r->n + 1] = r->start[r->n];
}

/* -- from a kernel's sums to moments --------------------------------------------------- */

/* Where the sums of a set of kinds lie, and what each is to be multiplied by to be the moment. */
typedef struct layout {
  int lmax;
  uint32_t *at;  /* [3][(lmax+3)^2] */
  double *scale; /* the same */
} layout;

static size_t place(const layout *y, int kind, int k, int m) {
  size_t n = (size_t)(y->lmax + 3) * (size_t)(y->lmax + 3);
  return (size_t)kind * n + (size_t)(k * (k + 1) + m);
}

/* Factors that the weight of a kind lacks: constants, the normalisation of its polynomial. */
static double weight_scale(int kind, int k) {
  if (k == 0) return 2 * YLM_PI;
  if (kind == 0) return YLM_PI;
  if (kind == 1) return YLM_PI * k * (k + 1.0);
  return -YLM_PI * (k - 1.0) * (k + 1.0) * (k + 2.0) / (2.0 * k + 1);
}

double ylm__harmonic_scale(int k, int m, double grow) {
  double c = sqrt(0.25 / YLM_PI) * (m ? M_SQRT2 : 1);
  for (int j = 1; j <= m; j++) c *= -sqrt((2.0 * j + 1) / (2.0 * j));
  for (int j = m + 1; j <= k; j++) c /= grow * sqrt(YLM__BETA(j, m));
  return c;
}

static ylm_status layout_create(layout *y, int lmax, int kinds, double grow) {
  size_t n = 3 * (size_t)(lmax + 3) * (size_t)(lmax + 3);
  uint32_t next = 0;
  y->lmax = lmax;
  y->at = ylm_alloc_zero(n, sizeof *y->at);
  y->scale = ylm_alloc_zero(n, sizeof *y->scale);
  if (!y->at || !y->scale) return YLM_ENOMEM;
  int K = ylm__degree_of(lmax, kinds);
  for (int m = 0; m <= K; m++)
    for (int side = 0; side < (m ? 2 : 1); side++)
      for (int k = m; k <= K; k++) {
        double norm = ylm__harmonic_scale(k, m, grow);
        for (int kind = 0; kind < 3; kind++) {
          if (!ylm__has(lmax, kinds, kind, k)) continue;
          size_t i = place(y, kind, k, side ? -m : m);
          y->at[i] = next++;
          y->scale[i] = norm * weight_scale(kind, k);
        }
      }
  return YLM_OK;
}

static void layout_free(layout *y) {
  ylm_free(y->at);
  ylm_free(y->scale);
}

/* Adds coef times the moment (kind, k, m) to the row being built. */
static void moment(ylm__rows *r, const layout *y, int kind, int k, int m, double coef) {
  if (coef == 0) return;
  size_t i = place(y, kind, k, m);
  ylm__rows_term(r, y->at[i], coef * y->scale[i]);
}

/* -- the maps of docs/math.md ----------------------------------------------------------- */

/* The orders m' that a coupling along axis a can join with m: |m'| differs by at most one. */
static int neighbours(int m, int out[6]) {
  int n = 0, p = m < 0 ? -m : m;
  for (int q = p - 1; q <= p + 1; q++) {
    if (q < 0) continue;
    out[n++] = q;
    if (q > 0) out[n++] = -q;
  }
  return n;
}

static ylm_status map_value(ylm__rows *r, const layout *y) {
  size_t n = (size_t)(y->lmax + 1) * (size_t)(y->lmax + 1);
  if (ylm__rows_create(r, n, n) != YLM_OK) return YLM_ENOMEM;
  for (int l = 0; l <= y->lmax; l++)
    for (int m = -l; m <= l; m++) {
      moment(r, y, 0, l, m, 1);
      ylm__rows_end(r);
    }
  return YLM_OK;
}

/* A row of up[l] * sum_m' X_a^l[m,m'] x_(l+1)m' + down * sum_m' X_a^(l-1)[m',m] x_(l-1)m'. */
static ylm_status map_gradient(ylm__rows *r, const layout *y) {
  size_t n = (size_t)(y->lmax + 1) * (size_t)(y->lmax + 1);
  if (ylm__rows_create(r, 3 * n, 3 * n * 12) != YLM_OK) return YLM_ENOMEM;
  for (int l = 0; l <= y->lmax; l++)
    for (int m = -l; m <= l; m++) {
      int near[6], count = neighbours(m, near);
      for (int a = 0; a < 3; a++) {
        for (int i = 0; i < count; i++) {
          moment(r, y, 1, l + 1, near[i], ylm__coupling(a, l, m, near[i]) / (l + 1));
          if (l >= 2) moment(r, y, 1, l - 1, near[i], -ylm__coupling(a, l - 1, near[i], m) / l);
        }
        ylm__rows_end(r);
      }
    }
  return YLM_OK;
}

/* U_a[k,m], k = 0 .. lmax+1 (row 0 is empty). */
static ylm_status map_u(ylm__rows *r, const layout *y) {
  size_t n = (size_t)(y->lmax + 2) * (size_t)(y->lmax + 2);
  if (ylm__rows_create(r, 3 * n, 3 * n * 12) != YLM_OK) return YLM_ENOMEM;
  for (int k = 0; k <= y->lmax + 1; k++)
    for (int m = -k; m <= k; m++) {
      int near[6], count = neighbours(m, near);
      for (int a = 0; a < 3; a++) {
        for (int i = 0; k > 0 && i < count; i++) {
          moment(r, y, 2, k + 1, near[i], (k + 1) * ylm__coupling(a, k, m, near[i]));
          if (k != 2) moment(r, y, 2, k - 1, near[i], -k * ylm__coupling(a, k - 1, near[i], m));
        }
        ylm__rows_end(r);
      }
    }
  return YLM_OK;
}

ylm_status ylm__map_hessian(ylm__rows *r, int lmax) {
  static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
  size_t n = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  if (ylm__rows_create(r, 6 * n, 6 * n * 12) != YLM_OK) return YLM_ENOMEM;
  for (int l = 0; l <= lmax; l++)
    for (int m = -l; m <= l; m++) {
      int near[6], count = neighbours(m, near);
      for (int j = 0; j < 6; j++) {
        int a = row[j], b = column[j];
        for (int i = 0; i < count; i++) {
          int p = near[i], up = (l + 1) * (l + 2) + p, down = (l - 1) * l + p;
          ylm__rows_term(r, (size_t)(3 * up + b), -ylm__coupling(a, l, m, p) / (l + 1));
          if (l >= 2) ylm__rows_term(r, (size_t)(3 * down + b), ylm__coupling(a, l - 1, p, m) / l);
        }
        ylm__rows_end(r);
      }
    }
  return YLM_OK;
}

ylm_status ylm__map_create(ylm__map *map, int lmax, int need, int kinds, double grow) {
  layout y = {0};
  if (!need) return YLM_OK;
  ylm_status s = layout_create(&y, lmax, kinds, grow);
  if (s == YLM_OK && need & YLM__M0) s = map_value(&map->value, &y);
  if (s == YLM_OK && need & YLM__M1) s = map_gradient(&map->gradient, &y);
  if (s == YLM_OK && need & YLM__M2) s = map_u(&map->to_u, &y);
  layout_free(&y);
  return s;
}

void ylm__map_free(ylm__map *map) {
  ylm__rows_free(&map->value);
  ylm__rows_free(&map->gradient);
  ylm__rows_free(&map->to_u);
}

/* -- plans ------------------------------------------------------------------------------- */

int ylm__kinds_of(const ylm_field_query *q, int channels) {
  int kinds = 0;
  if (q->channels == channels) {
    if (q->want & YLM_WANT_VALUE) kinds |= YLM__M0;
    if (q->want & YLM_WANT_GRADIENT) kinds |= YLM__M1;
    if (q->want & YLM_WANT_HESSIAN) kinds |= YLM__M2;
  }
  if ((q->want & YLM_WANT_METRIC) && q->metric_channels == channels) kinds |= YLM__M0 | YLM__M2;
  return kinds;
}

/* The smallest set that has a kernel. */
static int with_kernel(int kinds) {
  return kinds == YLM__M1 ? YLM__M0 | YLM__M1 : kinds == (YLM__M1 | YLM__M2) ? 7 : kinds;
}

ylm_status ylm__plan_create(ylm__plan *p, const ylm_lights *lights, const ylm_field_query *q,
                            const ylm__moment_kernel *kernel) {
  *p = (ylm__plan){.q = q, .lights = lights, .kernel = kernel};
  p->need_lum = ylm__kinds_of(q, 1);
  p->need_rgb = ylm__kinds_of(q, 3);
  p->kinds_rgb = with_kernel(p->need_rgb);
  p->kinds_lum = with_kernel(p->need_lum & ~p->kinds_rgb);
  p->n_lum = ylm__sum_count(q->lmax, p->kinds_lum);
  p->n_rgb = ylm__sum_count(q->lmax, p->kinds_rgb);
  ylm_status s = ylm__map_create(&p->rgb, q->lmax, p->need_rgb, p->kinds_rgb, kernel->grow);
  if (s == YLM_OK)
    s = ylm__map_create(&p->lum, q->lmax, p->need_lum & p->kinds_lum, p->kinds_lum, kernel->grow);
  if (s == YLM_OK)
    s = ylm__map_create(&p->mixed, q->lmax, p->need_lum & ~p->kinds_lum, p->kinds_rgb,
                        kernel->grow);
  if (s == YLM_OK && (p->need_lum | p->need_rgb) & YLM__M2)
    s = ylm__map_hessian(&p->hessian, q->lmax);
  return s;
}

void ylm__plan_free(ylm__plan *p) {
  ylm__map_free(&p->lum);
  ylm__map_free(&p->mixed);
  ylm__map_free(&p->rgb);
  ylm__rows_free(&p->hessian);
}
