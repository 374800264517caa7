/* maps.c - how results follow from sums over lights, for kernels elsewhere. */
#include "plan.h"

#include <math.h>

#include "gen/recurrences.h"

int ylm_light_sums_at(int lmax, int kinds, int k) {
  int n = 0;
  for (int kind = 0; kind < 3; kind++) n += ylm__has(lmax, kinds, kind, k);
  return n;
}

double ylm_light_recurrence(int lmax, int m, int k, double constant[4]) {
  double grow = ylm__grow(lmax);
  constant[0] = YLM__SLOWS(k);
  constant[1] = YLM__STEP(k);
  constant[2] = YLM__RHO(k);
  constant[3] = grow * grow * YLM__BETA(k, m);
  return grow;
}

/*
** Rows for sums of the product rule: by order m, side, degree l, then value, x y z, xx .. zz as far
** as there are derivatives. Sums are by the light's position and lack 2 pi and the normalisation.
*/
static ylm_status product_rows(ylm__rows *r, int lmax, int derivatives, int part, int width) {
  static const int parts[3] = {1, 4, 10};
  size_t n = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  if (ylm__rows_create(r, (size_t)width * n, (size_t)width * n) != YLM_OK) return YLM_ENOMEM;
  double sign = part == 1 ? -2 * YLM_PI : 2 * YLM_PI;
  for (int l = 0; l <= lmax; l++)
    for (int m = -l; m <= l; m++) {
      int q = m < 0 ? -m : m;
      /* coefficients of orders below q, and of the cosines of q where this is a sine */
      int before = 0;
      for (int j = 0; j < q; j++) before += (j ? 2 : 1) * (lmax + 1 - j);
      if (m < 0) before += lmax + 1 - q;
      for (int i = 0; i < width; i++) {
        ylm__rows_term(r, (size_t)((before + l - q) * parts[derivatives] + part + i),
                       sign * ylm__harmonic_scale(l, q, 1));
        ylm__rows_end(r);
      }
    }
  return YLM_OK;
}

ylm_status ylm_light_maps_create(int lmax, int need, int kinds, ylm_light_maps *maps) {
  ylm__map map = {0};
  *maps = (ylm_light_maps){.sums = (size_t)ylm__sum_count(lmax, kinds)};
  ylm_status s = ylm__map_create(&map, lmax, need, kinds, ylm__grow(lmax));
  maps->value = map.value;
  maps->gradient = map.gradient;
  maps->to_u = map.to_u;
  if (s == YLM_OK && need & YLM__M2) s = ylm__map_hessian(&maps->hessian, lmax);
  return s;
}

ylm_status ylm_light_product_maps_create(int lmax, int derivatives, ylm_light_maps *maps) {
  static const size_t parts[3] = {1, 4, 10};
  *maps = (ylm_light_maps){.sums = (size_t)(lmax + 1) * (size_t)(lmax + 1) * parts[derivatives]};
  ylm_status s = product_rows(&maps->value, lmax, derivatives, 0, 1);
  if (s == YLM_OK && derivatives > 0) s = product_rows(&maps->gradient, lmax, derivatives, 1, 3);
  if (s == YLM_OK && derivatives > 1) s = product_rows(&maps->hessian, lmax, derivatives, 4, 6);
  return s;
}

/* -- flat lights ---------------------------------------------------------------------------- */

static size_t terms_of(const ylm__rows *r) { return r->start[r->n]; }

void ylm__rows_append(ylm__rows *to, const ylm__rows *from, size_t row, size_t offset,
                      double factor) {
  for (uint32_t t = from->start[row]; t < from->start[row + 1]; t++)
    ylm__rows_term(to, offset + from->index[t], factor * from->coef[t]);
}

void ylm__rows_by_u(ylm__rows *to, const ylm_light_maps *m, size_t i, double *own) {
  for (size_t k = 0; k < m->sums; k++) own[k] = 0;
  for (uint32_t t = m->hessian.start[i]; t < m->hessian.start[i + 1]; t++) {
    size_t u = m->hessian.index[t];
    for (uint32_t j = m->to_u.start[u]; j < m->to_u.start[u + 1]; j++)
      own[m->to_u.index[j]] += m->hessian.coef[t] * m->to_u.coef[j];
  }
  for (size_t j = 0; j < m->sums; j++) /* what cancels leaves a rounding error */
    if (fabs(own[j]) > 1e-13) ylm__rows_term(to, j, own[j]);
}

/* Maps of the terms with c, with its derivatives, with its second derivatives. */
typedef struct flat {
  ylm_light_maps plain, slope, second;
} flat;

/* Terms of a Hessian's row over sums: a row of `hessian` has at most 12, and one of `to_u` too. */
static size_t hessian_terms(size_t sums) { return sums < 144 ? sums : 144; }

/* Derivatives of c are by the light's position, minus those by x. */
static ylm_status flat_gradient(ylm__rows *r, const flat *f) {
  size_t n = f->plain.gradient.n;
  if (ylm__rows_create(r, n, terms_of(&f->plain.gradient) + n) != YLM_OK) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    ylm__rows_append(r, &f->plain.gradient, i, 0, 1);
    ylm__rows_append(r, &f->slope.value, i / 3, f->plain.sums + i % 3 * f->slope.sums, -1);
    ylm__rows_end(r);
  }
  return YLM_OK;
}

static ylm_status flat_hessian(ylm__rows *r, const flat *f) {
  static const size_t row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
  size_t n = f->plain.hessian.n, slope = f->plain.sums, second = slope + 3 * f->slope.sums;
  double *own = ylm_alloc(f->plain.sums, sizeof *own);
  ylm_status s = own ? ylm__rows_create(r, n, n * (hessian_terms(f->plain.sums) + 25)) : YLM_ENOMEM;
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    size_t k = i / 6, a = row[i % 6], b = column[i % 6];
    ylm__rows_by_u(r, &f->plain, i, own);
    ylm__rows_append(r, &f->slope.gradient, 3 * k + a, slope + b * f->slope.sums, -1);
    ylm__rows_append(r, &f->slope.gradient, 3 * k + b, slope + a * f->slope.sums, -1);
    ylm__rows_append(r, &f->second.value, k, second + i % 6 * f->second.sums, 1);
    ylm__rows_end(r);
  }
  ylm_free(own);
  return s;
}

ylm_status ylm_light_flat_maps_create(int lmax, int derivatives, ylm_light_maps *maps) {
  int kinds = derivatives == 2 ? 7 : derivatives ? 3 : 1, lower = derivatives == 2 ? 3 : 1;
  flat f = {0};
  *maps = (ylm_light_maps){0};
  ylm_status s = ylm_light_maps_create(lmax, kinds, kinds, &f.plain);
  if (s == YLM_OK && derivatives) s = ylm_light_maps_create(lmax, lower, lower, &f.slope);
  if (s == YLM_OK && derivatives > 1) s = ylm_light_maps_create(lmax, 1, 1, &f.second);
  maps->sums = f.plain.sums + 3 * f.slope.sums + 6 * f.second.sums;
  if (s == YLM_OK && derivatives) s = flat_gradient(&maps->gradient, &f);
  if (s == YLM_OK && derivatives > 1) s = flat_hessian(&maps->hessian, &f);
  maps->value = f.plain.value;
  f.plain.value = (ylm__rows){0};
  ylm_light_maps_free(&f.plain);
  ylm_light_maps_free(&f.slope);
  ylm_light_maps_free(&f.second);
  return s;
}

void ylm_light_maps_free(ylm_light_maps *maps) {
  ylm__rows_free(&maps->value);
  ylm__rows_free(&maps->gradient);
  ylm__rows_free(&maps->to_u);
  ylm__rows_free(&maps->hessian);
}

void ylm_light_kinds(const ylm_field_query *q, int *lum, int *rgb) {
  *lum = ylm__kinds_of(q, 1);
  *rgb = ylm__kinds_of(q, 3);
}
