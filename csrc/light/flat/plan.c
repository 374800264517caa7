/* plan.c - what the kernels of polygons need to know about a query. */
#include "../moments/gen/recurrences.h"
#include "kernel.h"

#include <math.h>
#include <stdlib.h>

#include "ylm_sets.h"
#include "ylm_sh.h"

YLM_KERNEL_CHOICE_OF(ylm__flat_range, ylm__flat_kernel, ylm__flat_range, NULL);

/* Coefficients of the monic recurrence, and what makes Y of monic polynomials. */
static void make_harmonics(ylm__flat_plan *plan) {
  int top = plan->lmax + 1;
  double start = sqrt(1 / (4 * YLM_PI));
  for (int m = 0; m <= top; m++) {
    if (m > 0) start *= -sqrt((2 * m + 1.0) / (2 * m)) * (m == 1 ? M_SQRT2 : 1);
    double norm = start;
    for (int l = m; l <= top; l++) {
      double c = YLM__BETA(l, m);
      if (l > m) norm /= sqrt(c);
      plan->monic[m * (top + 1) + l] = l > m ? c : 0;
      plan->norm[ylm_sh_index(l, m)] = plan->norm[ylm_sh_index(l, -m)] = norm;
    }
  }
}

/* Appends to a map what result row (l, m) gains from degree k of sums at `offset`, along the axis:
   factor * X between degrees l and k. */
static size_t couple(const ylm__flat_plan *plan, ylm__flat_entry *out, int l, int m, int k,
                     int axis, size_t offset, double factor) {
  size_t n = 0;
  for (int side = 0; side < 3; side++)
    for (int sign = -1; sign <= 1; sign += 2) {
      int p = sign * (abs(m) + side - 1);
      if (abs(m) + side - 1 < 0 || (p == 0 && sign < 0) || abs(p) > k) continue;
      double x = k < l ? ylm__coupling(axis, k, p, m) : ylm__coupling(axis, l, m, p);
      if (x == 0) continue;
      size_t from = ylm_sh_index(k, p);
      out[n++] = (ylm__flat_entry){axis, (uint32_t)(offset + from), factor * x * plan->norm[from]};
    }
  return n;
}

static void make_maps(ylm__flat_plan *plan) {
  size_t nv = 0, nh = 0, row = 0;
  for (int l = 0; l <= plan->lmax; l++)
    for (int m = -l; m <= l; m++, row++) {
      plan->value.begin[row] = nv;
      plan->hessian.begin[row] = nh;
      for (int a = 0; a < 3; a++) {
        if (l > 0)
          nv += couple(plan, plan->value.entry + nv, l, m, l - 1, a, plan->offset[0],
                       (2 * l + 1.0) / (l * (l + 1.0)));
        if (!(plan->kinds & YLM__K2)) continue;
        if (l > 0)
          nh += couple(plan, plan->hessian.entry + nh, l, m, l - 1, a, plan->offset[2], 2.0 - l);
        nh += couple(plan, plan->hessian.entry + nh, l, m, l + 1, a, plan->offset[2], l + 3.0);
      }
    }
  plan->value.begin[row] = nv;
  plan->hessian.begin[row] = nh;
}

static double *radiances(const ylm_polygons *p, int channels) {
  double *out = ylm_alloc(p->n, (size_t)channels * sizeof *out);
  for (size_t i = 0; out && i < p->n; i++)
    for (int c = 0; c < channels; c++)
      out[i * (size_t)channels + (size_t)c] = ylm__emission(p->radiance + 3 * i, channels, c);
  return out;
}

ylm_status ylm__flat_plan_make(ylm__flat_plan *plan, const ylm_polygons *p,
                               const ylm_field_query *q, ylm_isa isa) {
  bool metric = q->want & YLM_WANT_METRIC;
  size_t count = ylm_sh_count(q->lmax), high = ylm_sh_count(q->lmax + 1);
  size_t size[3] = {q->lmax ? ylm_sh_count(q->lmax - 1) : 0, count, high};
  *plan = (ylm__flat_plan){.p = p,
                           .range = ylm__flat_kernel(isa),
                           .lmax = q->lmax,
                           .count = count,
                           .wide = ylm__flat_wide(q)};
  plan->kinds = YLM__K0 | (q->want & YLM_WANT_GRADIENT ? YLM__K1 : 0) |
                (metric || (q->want & YLM_WANT_HESSIAN) ? YLM__K2 : 0);
  plan->channels = q->channels == 3 || (metric && q->metric_channels == 3) ? 3 : 1;
  plan->top = q->lmax + (plan->kinds & YLM__K2 ? 1 : plan->kinds & YLM__K1 ? 0 : -1);
  plan->far = q->dtype == YLM_FLOAT ? 1e-6 : YLM__FAR;
  plan->digits = q->dtype == YLM_FLOAT ? 23 : 37; /* e^-23 = 1e-10, e^-37 = 1e-16 */
  plan->degree = q->lmax + (plan->kinds & YLM__K2 ? 3 : plan->kinds & YLM__K1 ? 1 : 0);
  for (int k = 0; k < 3; k++) {
    plan->offset[k] = plan->width;
    if (plan->kinds & 1 << k) plan->width += size[k];
  }
  plan->radiance = radiances(p, plan->channels);
  plan->monic = ylm_alloc((size_t)(q->lmax + 2) * (size_t)(q->lmax + 2), sizeof(double));
  plan->norm = ylm_alloc(high, sizeof(double));
  plan->value.begin = ylm_alloc(count + 1, sizeof(size_t));
  plan->hessian.begin = ylm_alloc(count + 1, sizeof(size_t));
  plan->value.entry = ylm_alloc(count * 5, sizeof(ylm__flat_entry));
  plan->hessian.entry = ylm_alloc(count * 10, sizeof(ylm__flat_entry));
  if (!plan->radiance || !plan->monic || !plan->norm || !plan->value.begin ||
      !plan->hessian.begin || !plan->value.entry || !plan->hessian.entry)
    return YLM_ENOMEM;
  for (int i = 0; i < YLM__RULES; i++)
    plan->reach[i] = q->dtype == YLM_FLOAT ? ylm__rule_table[i].rough : ylm__rule_table[i].fine;
  make_harmonics(plan);
  make_maps(plan);
  return YLM_OK;
}

void ylm__flat_plan_free(ylm__flat_plan *plan) {
  ylm_free((void *)plan->radiance);
  ylm_free(plan->monic);
  ylm_free(plan->norm);
  ylm_free(plan->value.begin);
  ylm_free(plan->hessian.begin);
  ylm_free(plan->value.entry);
  ylm_free(plan->hessian.entry);
}
