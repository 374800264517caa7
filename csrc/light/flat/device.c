/* device.c - exact flat lights for kernels elsewhere: rules, maps from sums. */
#include <math.h>
#include <string.h>

#include "../moments/plan.h"
#include "kernel.h"
#include "ylm_sh.h"

double ylm_light_rim_speed(const double *u, const double *v) { return ylm__rim_speed(u, v); }

size_t ylm_light_rim_rules(double *to) {
  const size_t row = 3 + 2 * YLM__MOST_NODES;
  for (size_t i = 0; to && i < YLM__RULES; i++) {
    const ylm__rule *r = &ylm__rule_table[i];
    to[i * row] = r->n, to[i * row + 1] = r->fine, to[i * row + 2] = r->rough;
    memcpy(to + i * row + 3, r->x, sizeof r->x);
    memcpy(to + i * row + 3 + YLM__MOST_NODES, r->w, sizeof r->w);
  }
  return YLM__RULES * row;
}

/* -- maps ------------------------------------------------------------------------------ */

/* Sums of an axis. */
static size_t width_of(int lmax, int kinds) {
  size_t n = 0;
  for (int k = 0; k < 3; k++)
    if (kinds >> k & 1) n += (size_t)(lmax + k) * (size_t)(lmax + k);
  return n;
}

size_t ylm_light_rim_sums(int lmax, int kinds, bool cut) {
  return 3 * width_of(lmax, kinds) + 1 + (cut && kinds & 4 ? 6 * ylm_sh_count(lmax) : 0);
}

/* Appends row i of what there was. */
static void append_base(ylm__rows *r, const ylm__rows *base, size_t i) {
  if (base->n) ylm__rows_append(r, base, i, 0, 1);
}

static ylm_status value_rows(ylm__rows *r, const ylm__flat_plan *p, const ylm__rows *base,
                             size_t first) {
  size_t n = p->count, terms = base->n ? base->start[base->n] : 0;
  if (ylm__rows_create(r, n, terms + p->value.begin[n] + 1) != YLM_OK) return YLM_ENOMEM;
  for (size_t k = 0; k < n; k++) {
    append_base(r, base, k);
    if (!k) ylm__rows_term(r, first + 3 * p->width, sqrt(1 / (4 * YLM_PI)));
    for (size_t i = p->value.begin[k]; i < p->value.begin[k + 1]; i++) {
      const ylm__flat_entry *e = p->value.entry + i;
      ylm__rows_term(r, first + (size_t)e->axis * p->width + e->from, e->factor);
    }
    ylm__rows_end(r);
  }
  return YLM_OK;
}

static ylm_status gradient_rows(ylm__rows *r, const ylm__flat_plan *p, const ylm__rows *base,
                                size_t first) {
  size_t n = 3 * p->count, terms = base->n ? base->start[base->n] : 0;
  if (ylm__rows_create(r, n, terms + n) != YLM_OK) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    append_base(r, base, i);
    ylm__rows_term(r, first + i % 3 * p->width + p->offset[1] + i / 3, p->norm[i / 3]);
    ylm__rows_end(r);
  }
  return YLM_OK;
}

/* Of result q = (a, b): sym_ab of axis a and a row of D_b. */
static void hessian_row(ylm__rows *r, const ylm__flat_plan *p, size_t k, int a, int b,
                        size_t first) {
  for (size_t i = p->hessian.begin[k]; i < p->hessian.begin[k + 1]; i++) {
    const ylm__flat_entry *e = p->hessian.entry + i;
    double factor = a == b ? e->factor : 0.5 * e->factor;
    if (e->axis == b) ylm__rows_term(r, first + (size_t)a * p->width + e->from, factor);
    if (e->axis == a && a != b) ylm__rows_term(r, first + (size_t)b * p->width + e->from, factor);
  }
}

static ylm_status hessian_rows(ylm__rows *r, const ylm__flat_plan *p, const ylm_light_maps *base,
                               size_t first, bool cut) {
  static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
  size_t n = 6 * p->count, sums = base->sums;
  size_t terms = (sums < 144 ? sums : 144) + (base->to_u.n ? 0 : 64) + 21;
  double *own = ylm_alloc(sums + 1, sizeof *own);
  ylm_status s = own ? ylm__rows_create(r, n, n * terms) : YLM_ENOMEM;
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    if (base->to_u.n) {
      ylm__rows_by_u(r, base, i, own);
    } else {
      append_base(r, &base->hessian, i);
    }
    hessian_row(r, p, i / 6, row[i % 6], column[i % 6], first);
    if (cut) ylm__rows_term(r, first + 3 * p->width + 1 + i % 6 * p->count + i / 6, p->norm[i / 6]);
    ylm__rows_end(r);
  }
  ylm_free(own);
  return s;
}

ylm_status ylm_light_rim_maps_create(int lmax, int need, int kinds, bool cut,
                                     const ylm_light_maps *base, ylm_light_maps *maps) {
  const ylm_polygons none = {0};
  ylm_field_query q = {.lmax = lmax, .channels = 1, .metric_channels = 1, .dtype = YLM_DOUBLE};
  q.want =
      YLM_WANT_VALUE | (kinds & 2 ? YLM_WANT_GRADIENT : 0u) | (kinds & 4 ? YLM_WANT_HESSIAN : 0u);
  ylm__flat_plan p = {0};
  *maps = (ylm_light_maps){.sums = base->sums + ylm_light_rim_sums(lmax, kinds, cut)};
  ylm_status s = ylm__flat_plan_make(&p, &none, &q, YLM_ISA_reference);
  if (s == YLM_OK && need & 1) s = value_rows(&maps->value, &p, &base->value, base->sums);
  if (s == YLM_OK && need & 2) s = gradient_rows(&maps->gradient, &p, &base->gradient, base->sums);
  if (s == YLM_OK && need & 4) s = hessian_rows(&maps->hessian, &p, base, base->sums, cut);
  ylm__flat_plan_free(&p);
  return s;
}
