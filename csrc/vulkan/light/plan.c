/* plan.c - what has to be summed for a query, and the maps to results, on a device. */
#include <string.h>

#include "../calibration.h"
#include "lights.h"

/* -- matrices --------------------------------------------------------------------- */

static void rows_free(device_rows *r) {
  ylm_gpu_buffer_free(r->start);
  ylm_gpu_buffer_free(r->index);
  ylm_gpu_buffer_free(r->coef);
}

static ylm_status rows_upload(ylm_gpu *g, const ylm_light_rows *from, ylm_dtype t, device_rows *r,
                              ylm_error *e) {
  if (!from->n) return YLM_OK;
  uint32_t terms = from->start[from->n];
  r->n = (uint32_t)from->n;
  r->terms = terms;
  ylm_status s = ylm_gpu_buffer_from(g, (from->n + 1) * 4, from->start, &r->start, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(g, terms * 4u, from->index, &r->index, e);
  const void *coef = t == YLM_DOUBLE ? (const void *)from->coef : (const void *)from->coef_f;
  if (s == YLM_OK) s = ylm_gpu_buffer_from(g, terms * ylm_dtype_size(t), coef, &r->coef, e);
  return s;
}

static void maps_free(device_maps *m) {
  rows_free(&m->value);
  rows_free(&m->gradient);
  rows_free(&m->to_u);
  rows_free(&m->hessian);
}

/* From the sums of spheres, and of flat lights that these approximate. */
static ylm_status base_maps(const ylm_gpu_lights *l, const sum_plan *p, int need,
                            const sum_set *set, ylm_light_maps *maps) {
  int derivatives = ylm__sum_derivatives(set->kinds);
  return !ylm__sum_base(l) ? YLM_OK
         : ylm__loops(l)   ? ylm_light_product_maps_create(p->lmax, derivatives, maps)
         : l->cosines.kind ? ylm_light_flat_maps_create(p->lmax, derivatives, maps)
                           : ylm_light_maps_create(p->lmax, need, (int)set->kinds, maps);
}

/* The maps for results of kinds `need` from a set's sums. */
static ylm_status maps_create(const ylm_gpu_lights *l, const sum_plan *p, int need,
                              const sum_set *set, device_maps *m, ylm_error *e) {
  ylm_light_maps base = {0}, all = {0}, *maps = &base;
  if (!need) return YLM_OK;
  ylm_status s = base_maps(l, p, need, set, &base);
  if (s == YLM_OK && l->rims.objects) {
    s = ylm_light_rim_maps_create(p->lmax, need, (int)set->kinds | 1, l->rims.cut, &base, &all);
    maps = &all;
  }
  if (s == YLM_OK) s = rows_upload(l->gpu, &maps->value, p->dtype, &m->value, e);
  if (s == YLM_OK) s = rows_upload(l->gpu, &maps->gradient, p->dtype, &m->gradient, e);
  if (s == YLM_OK) s = rows_upload(l->gpu, &maps->to_u, p->dtype, &m->to_u, e);
  if (s == YLM_OK) s = rows_upload(l->gpu, &maps->hessian, p->dtype, &m->hessian, e);
  ylm_light_maps_free(&base);
  ylm_light_maps_free(&all);
  return s == YLM_ENOMEM ? ylm_no_memory(e) : s;
}

/* Luminance of rgb sums as a matrix. */
static ylm_status mix_create(ylm_gpu *g, uint32_t sums, ylm_dtype t, device_rows *r, ylm_error *e) {
  static const double weight[3] = {YLM_LUMINANCE_R, YLM_LUMINANCE_G, YLM_LUMINANCE_B};
  ylm_light_rows m = {sums, ylm_alloc(sums + 1, 4), ylm_alloc(3 * sums, 4),
                      ylm_alloc(3 * sums, sizeof(double)), ylm_alloc(3 * sums, sizeof(float))};
  bool ok = m.start && m.index && m.coef && m.coef_f;
  for (uint32_t i = 0; ok && i <= sums; i++) m.start[i] = 3 * i;
  for (uint32_t i = 0; ok && i < 3 * sums; i++) {
    m.index[i] = i / 3 + i % 3 * sums;
    m.coef[i] = weight[i % 3];
    m.coef_f[i] = (float)weight[i % 3];
  }
  ylm_status s = ok ? rows_upload(g, &m, t, r, e) : ylm_no_memory(e);
  ylm_free(m.start);
  ylm_free(m.index);
  ylm_free(m.coef);
  ylm_free(m.coef_f);
  return s;
}

/* -- passes ------------------------------------------------------------------------- */

/* The number of sums of one order m. */
static uint32_t width_of(int lmax, uint32_t kinds, int m) {
  int n = 0;
  for (int k = m; k <= lmax + 2; k++) n += ylm_light_sums_at(lmax, (int)kinds, k);
  return (uint32_t)(m ? 2 * n : n);
}

uint32_t ylm__sum_count_of(int lmax, uint32_t kinds) {
  uint32_t n = 0;
  for (int m = 0; m <= lmax + 2; m++) n += width_of(lmax, kinds, m);
  return n;
}

/*
** Cuts the orders into passes that fit into registers.
** Beside the sums of `kinds`, a pass has `times` those of `parted`, which lie at first->parts.
*/
static void cut(int lmax, uint32_t kinds, uint32_t parted, uint32_t times, struct sum_pass first,
                sum_set *set) {
  struct sum_pass *last = NULL;
  for (int m = 0; m <= lmax + 2; m++) {
    uint32_t n = width_of(lmax, kinds, m) + times * width_of(lmax, parted, m);
    if (!n) break;
    set->sums += n;
    if (last && last->sums + n <= SUM_BUDGET) {
      last->m_last = (uint32_t)m;
      last->sums += n;
    } else {
      last = &set->pass[set->passes++];
      *last = first;
      last->m_first = last->m_last = (uint32_t)m;
      last->sums = n;
    }
  }
}

/* The passes of a set over spheres. */
static ylm_status cut_base(const ylm_gpu_lights *l, sum_plan *p, sum_set *set, ylm_error *e) {
  const int lmax = p->lmax;
  struct sum_pass pass = {0};
  if (!ylm__sum_base(l)) return YLM_OK;
  if (ylm__loops(l)) {
    ylm__loops_cut(l, lmax, set);
    return YLM_OK;
  }
  if (ylm__sum_any(lmax)) return ylm__sum_any_cut(l, p, set, e);
  if (!l->cosines.kind || set->kinds < 2) {
    cut(lmax, set->kinds, 0, 0, pass, set);
    return YLM_OK;
  }
  uint32_t parted = set->kinds & 4 ? 3 : 1;
  pass.parts = ylm__sum_count_of(lmax, set->kinds);
  pass.part = ylm__sum_count_of(lmax, parted);
  cut(lmax, set->kinds, parted, 3, pass, set);
  if (!(set->kinds & 4)) return YLM_OK;
  pass.parts += 3 * pass.part;
  pass.part = ylm__sum_count_of(lmax, 1);
  pass.second = true;
  cut(lmax, 0, 1, 6, pass, set);
  return YLM_OK;
}

static ylm_status cut_set(const ylm_gpu_lights *l, sum_plan *p, sum_set *set, ylm_error *e) {
  ylm_status s = cut_base(l, p, set, e);
  return s == YLM_OK ? ylm__rims_cut(l, p, set, e) : s;
}

/* The product rule, and flat lights, sum all that lower derivatives need too. */
static uint32_t expand(const ylm_gpu_lights *l, int kinds) {
  if (!ylm__loops(l) && !l->cosines.kind) return (uint32_t)kinds;
  return kinds & 4 ? 7 : kinds & 2 ? 3 : kinds & 1;
}

/* -- plans ---------------------------------------------------------------------------- */

static void plan_free(sum_plan *p) {
  for (int i = 0; i < MAX_PASSES; i++) {
    ylm_gpu_buffer_free(p->lum.pass[i].item);
    ylm_gpu_buffer_free(p->rgb.pass[i].item);
  }
  ylm_gpu_buffer_free(p->constants);
  ylm_gpu_buffer_free(p->betas);
  maps_free(&p->from_lum);
  maps_free(&p->from_rgb);
  maps_free(&p->from_mixed);
  rows_free(&p->mix);
  ylm_free(p);
}

void ylm__sum_plans_free(sum_plan *p) {
  while (p) {
    sum_plan *next = p->next;
    plan_free(p);
    p = next;
  }
}

static ylm_status fill(const ylm_gpu_lights *l, sum_plan *p, ylm_error *e) {
  p->rgb = (sum_set){.channels = p->need_rgb ? 3 : 0, .kinds = expand(l, p->need_rgb)};
  p->mixed = p->need_lum & (int)p->rgb.kinds;
  int own = p->need_lum & ~p->mixed;
  p->lum = (sum_set){.channel_first = 3, .channels = own ? 1 : 0, .kinds = expand(l, own)};
  ylm_status s = cut_set(l, p, &p->rgb, e);
  if (s == YLM_OK) s = cut_set(l, p, &p->lum, e);
  if (s == YLM_OK) s = maps_create(l, p, own, &p->lum, &p->from_lum, e);
  if (s == YLM_OK) s = maps_create(l, p, p->need_rgb, &p->rgb, &p->from_rgb, e);
  if (s == YLM_OK) s = maps_create(l, p, p->mixed, &p->rgb, &p->from_mixed, e);
  if (s == YLM_OK && p->mixed) s = mix_create(l->gpu, p->rgb.sums, p->dtype, &p->mix, e);
  return s;
}

ylm_status ylm__sum_plan_get(ylm_gpu_lights *l, const ylm_field_query *q, const sum_plan **out,
                             ylm_error *e) {
  sum_plan want = {.lmax = q->lmax, .dtype = q->dtype};
  int n = 0;
  ylm_light_kinds(q, &want.need_lum, &want.need_rgb);
  for (sum_plan **link = &l->plans; *link; link = &(*link)->next) {
    sum_plan *p = *link;
    if (p->lmax == want.lmax && p->dtype == want.dtype && p->need_lum == want.need_lum &&
        p->need_rgb == want.need_rgb) {
      *link = p->next; /* to the front */
      p->next = l->plans;
      *out = l->plans = p;
      return YLM_OK;
    }
    if (++n == PLANS_KEPT) {
      ylm__sum_plans_free(p->next);
      p->next = NULL;
    }
  }
  sum_plan *p = ylm_alloc(1, sizeof *p);
  if (!p) return ylm_no_memory(e);
  *p = want;
  ylm_status s = fill(l, p, e);
  if (s != YLM_OK) {
    plan_free(p);
    return s;
  }
  p->next = l->plans;
  *out = l->plans = p;
  return YLM_OK;
}
