/* fit.c - numbers of probes with the least squared error at places of surfaces. */
#include "fit.h"

#include <string.h>

void ylm__probes_leave(probes_rows *r) {
  ylm_free(r->around);
  ylm_free(r->share);
  ylm_free(r->basis);
  ylm_free(r->hold);
}

ylm_status ylm__probes_rows(const ylm_grid_probes *p, const ylm_grid_probes_places *at,
                            probes_rows *r) {
  size_t n = at->n, count = (size_t)p->count;
  r->around = ylm_alloc_zero(n, sizeof *r->around);
  r->share = ylm_alloc(n, sizeof *r->share);
  r->basis = ylm_alloc(n, count * sizeof *r->basis);
  r->hold = ylm_alloc(p->points, sizeof *r->hold);
  if (!r->around || !r->share || !r->basis || !r->hold) {
    ylm__probes_leave(r);
    return YLM_ENOMEM;
  }
  for (size_t i = 0; i < n; i++) {
    float basis[9];
    probes_place place = ylm__probes_find(p, at->point[i], at->normal[i]);
    ylm__probes_shares(&place, r->share[i]);
    if (place.brick != YLM_GRID_NONE)
      memcpy(r->around[i], p->corner[place.brick], sizeof r->around[i]);
    ylm__probes_basis(at->normal[i], basis);
    memcpy(r->basis + i * count, basis, count * sizeof *basis);
  }
  for (size_t i = 0; i < p->points; i++)
    r->hold[i] = (float)(p->ghost && p->ghost[i] ? at->hold_ghosts : at->hold);
  return YLM_OK;
}

ylm_status ylm_grid_probes_fit(ylm_grid_probes *p, const ylm_grid_probes_places *at) {
  probes_rows r = {NULL};
  if (!at->n || !p->points) return YLM_OK;
  ylm_status s = ylm__probes_rows(p, at, &r);
  if (s != YLM_OK) return s;
  ylm_grid_fit f = {.numbers = p->count,
                    .channels = 3,
                    .places = at->n,
                    .basis = r.basis,
                    .wanted = at->wanted[0],
                    .weight = at->weight,
                    .hold = r.hold,
                    .norm = ylm__probes_norm,
                    .probe = p->value,
                    .probes = p->points,
                    .around = (const uint32_t(*)[8])r.around,
                    .share = (const float(*)[8])r.share,
                    .quick = at->quick,
                    .threads = at->threads};
  s = ylm_grid_fit_probes(&f);
  ylm__probes_leave(&r);
  return s;
}
