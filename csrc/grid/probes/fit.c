/* fit.c - numbers of probes with the least squared error at places of surfaces. */
#include "fit.h"
#include "ylm_list.h"

#include <string.h>

#define MOST_POINTS 64 /* that a place has a share of */

void ylm__probes_leave(probes_rows *r) {
  ylm_free(r->first);
  ylm_free(r->point);
  ylm_free(r->share);
  ylm_free(r->basis);
  ylm_free(r->hold);
}

/* The points of a place, and their shares. */
typedef struct row_list {
  uint32_t point[MOST_POINTS];
  float share[MOST_POINTS];
  size_t n;
} row_list;

/* Adds a share of a point, or of those that it is between. Points that find no room are left out: no leaf is that deep. */
static void add_share(const ylm_grid_probes *p, uint32_t point, float share, row_list *list) {
  if (share == 0) return;
  if (p->tie && p->tie[point][0] != YLM_GRID_NONE) {
    for (int k = 0; k < 4; k++) add_share(p, p->tie[point][k], share / 4, list);
    return;
  }
  size_t i = 0;
  while (i < list->n && list->point[i] != point) i++;
  if (i == MOST_POINTS) return;
  if (i == list->n) {
    list->point[list->n] = point;
    list->share[list->n++] = 0;
  }
  list->share[i] += share;
}

static row_list row_of(const ylm_grid_probes *p, const ylm_grid_probes_places *at,
                       const probes_place *found, size_t i) {
  row_list list = {.n = 0};
  float share[8];
  probes_place place = found ? found[i] : ylm__probes_find(p, at->point[i], at->normal[i]);
  ylm__probes_shares(&place, share);
  for (int k = 0; place.brick != YLM_GRID_NONE && k < 8; k++)
    add_share(p, p->corner[place.brick][k], share[k], &list);
  return list;
}

ylm_status ylm__probes_rows(const ylm_grid_probes *p, const ylm_grid_probes_places *at,
                            const probes_place *found, probes_rows *r) {
  size_t n = at->n, count = (size_t)p->count, room = 0, more = 0;
  r->first = ylm_alloc_zero(n + 1, sizeof *r->first);
  r->basis = ylm_alloc(n + 1, count * sizeof *r->basis);
  r->hold = ylm_alloc(p->points + 1, sizeof *r->hold);
  bool ok = r->first && r->basis && r->hold;
  for (size_t i = 0; ok && i < n; i++) {
    float basis[9];
    row_list list = row_of(p, at, found, i);
    size_t begin = r->first[i], end = r->first[i + 1] = begin + list.n;
    ok = ylm_list_reserve(&r->point, begin, end, &room, sizeof *r->point) &&
         ylm_list_reserve(&r->share, begin, end, &more, sizeof *r->share);
    if (!ok) break;
    memcpy(r->point + begin, list.point, list.n * sizeof *list.point);
    memcpy(r->share + begin, list.share, list.n * sizeof *list.share);
    ylm__probes_basis(at->normal[i], basis);
    memcpy(r->basis + i * count, basis, count * sizeof *basis);
  }
  if (!ok) {
    ylm__probes_leave(r);
    return YLM_ENOMEM;
  }
  for (size_t i = 0; i < p->points; i++)
    r->hold[i] = (float)(p->ghost && p->ghost[i] ? at->hold_ghosts : at->hold);
  return YLM_OK;
}

ylm_status ylm_grid_probes_fit(ylm_grid_probes *p, const ylm_grid_probes_places *at) {
  probes_rows r = {NULL};
  if (!at->n || !p->points) return YLM_OK;
  ylm_status s = ylm__probes_tie(p);
  if (s == YLM_OK) s = ylm__probes_rows(p, at, NULL, &r);
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
                    .first = r.first,
                    .around = r.point,
                    .share = r.share,
                    .quick = at->quick,
                    .threads = at->threads};
  s = ylm_grid_fit_probes(&f);
  ylm__probes_leave(&r);
  ylm__probes_follow_ties(p);
  return s;
}
