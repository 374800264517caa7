/* kernel.real.isa.c - all lights at the points of a query. */
#include "kernel.h"

#include <string.h>

static void add_all(const ylm__virtual_plan *p, work *k, const vreal xyz[3]) {
  const size_t n = p->lights->n, stride = p->lights->stride;
  memset(k->sum, 0, p->sums * sizeof *k->sum);
  memset(k->lost, 0, p->sums * sizeof *k->lost);
  for (size_t first = 0; first < n; first += YLM__VIRTUAL_BLOCK) {
    size_t end = n - first < YLM__VIRTUAL_BLOCK ? n : first + YLM__VIRTUAL_BLOCK;
    memset(k->part, 0, p->sums * sizeof *k->part);
    for (size_t i = first; i < end; i++) add_light(p, k, ROWS_OF(p) + i * stride, xyz, 0);
    VIRTUAL(flush)(p, k);
    for (size_t s = 0; s < p->sums; s++) add_part(k->part[s], &k->sum[s], &k->lost[s]);
  }
}

ylm__virtual_range YLM_REAL_KERNEL(ylm__virtual_range);

ylm_status YLM_REAL_KERNEL(ylm__virtual_range)(const ylm__virtual_plan *p, size_t begin, size_t end,
                                               const void *points, ylm_field_result *r) {
  work k;
  vreal *room = ylm_alloc_zero(VIRTUAL(room_of)(p), sizeof *room);
  if (!room) return YLM_ENOMEM;
  VIRTUAL(work_place)(&k, p, room);
  for (size_t point = begin; point < end; point += LANES) {
    int lanes = end - point < LANES ? (int)(end - point) : LANES;
    vreal xyz[3] = {vreal_set(0), vreal_set(0), vreal_set(0)};
    for (int i = 0; i < LANES; i++)
      for (size_t a = 0; a < 3; a++)
        xyz[a][i] =
            (real)ylm_get(p->q->dtype, points, 3 * (point + (size_t)(i < lanes ? i : 0)) + a);
    add_all(p, &k, xyz);
    VIRTUAL(mix)(p, &k);
    VIRTUAL(results)(p, &k, point, lanes, r);
    if (p->q->want & YLM_WANT_METRIC) VIRTUAL(metric)(p, &k, point, lanes, r);
    for (int i = 0; r->inside && i < lanes; i++) r->inside[point + (size_t)i] = 0;
  }
  ylm_free(room);
  return YLM_OK;
}
