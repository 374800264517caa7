/* stale.c - bounds of what points lack, and which points have to be brought up to date. */
#include "follow.h"

#include <math.h>

typedef struct stale_job {
  const ylm_grid *g;
  double tolerance;
  const float *reach, *least; /* [points] */
  uint8_t *what;
} stale_job;

bool ylm__grid_is_worn(const ylm_grid *g, size_t p, double tolerance, double sixteenths) {
  const grid_dynamic *d = g->dynamic;
  return (double)d->drift[p] > sixteenths * fmax(tolerance / 16, 2e-6) * (double)d->size[p];
}

static int judge(const stale_job *j, size_t p, const double at[3]) {
  const ylm_grid *g = j->g;
  const grid_dynamic *d = g->dynamic;
  bool stale = false, forced = false, near = false;
  double sum[3] = {0};
  for (size_t m = 0; m < d->movers; m++) {
    const mover *k = &d->mover[m];
    int seen = k->seen[p];
    if (seen == k->current) continue;
    stale = true;
    forced |= k->evict == seen || k->evict == EVICT_ALL;
    near |= !ylm_light_bounds_add(&d->bounds, &k->state[seen], &k->state[k->current],
                                  k->slides[seen], at, sum);
  }
  if (!stale) return STALE_NOT;
  if (near) return STALE_EXACT;
  if (g->flags[p] & YLM_GRID_POINT_INVALID) return STALE_NOT; /* filled from its neighbours */
  double limit = j->tolerance * (double)j->least[p], edge = (double)j->reach[p];
  bool beyond = 1.58 * sum[0] + 0.43 * edge * sum[1] > limit;
  if (g->contents.form.threshold >= 0 && g->dynamic->hessians)
    beyond |= sum[2] > 5 * j->tolerance * (double)g->lambda[p];
  if (!beyond && !forced) return STALE_SKIPPED;
  return ylm__grid_is_worn(g, p, j->tolerance, 1) ? STALE_EXACT : STALE_SHIFT;
}

static ylm_status judge_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const stale_job *j = context;
  const ylm_grid *g = j->g;
  const grid_dynamic *d = g->dynamic;
  for (size_t p = begin; p < end; p++) {
    double at[3];
    ylm_grid_position(g, g->lattice + 3 * p, at);
    j->what[p] = (uint8_t)judge(j, p, at);
    if (j->what[p] == STALE_NOT && g->flags[p] & YLM_GRID_POINT_INVALID)
      for (size_t m = 0; m < d->movers; m++) d->mover[m].seen[p] = (uint8_t)d->mover[m].current;
  }
  return YLM_OK;
}

/* Longest edge of the occupied leaves that a point is a corner of, and the smallest norm at their
   corners. */
static void find_reach(const ylm_grid *g, float *reach, float *least) {
  double unit = 0;
  for (int a = 0; a < 3; a++) unit = fmax(unit, 1 / g->scale[a]);
  for (size_t p = 0; p < g->evaluated; p++) {
    reach[p] = (float)unit;
    least[p] = g->dynamic->size[p];
  }
  for (size_t i = 0; i < g->contents.octree_cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (!(c->flags & YLM_GRID_LEAF) || !(c->flags & YLM_GRID_OCCUPIED)) continue;
    float edge = (float)(ylm__grid_edge(g, c) * unit), low = INFINITY;
    for (int k = 0; k < 8; k++)
      if (!(g->flags[c->corner[k]] & YLM_GRID_POINT_INVALID))
        low = fminf(low, g->dynamic->size[c->corner[k]]);
    for (int k = 0; k < 8; k++) {
      uint32_t p = c->corner[k];
      reach[p] = fmaxf(reach[p], edge);
      least[p] = fminf(least[p], low);
    }
  }
}

ylm_status ylm__grid_find_stale(ylm_grid *g, double tolerance, int threads, uint8_t *what) {
  float *reach = ylm_alloc(g->evaluated, sizeof *reach);
  float *least = ylm_alloc(g->evaluated, sizeof *least);
  ylm_status s = reach && least ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    find_reach(g, reach, least);
    stale_job j = {g, tolerance, reach, least, what};
    s = ylm_parallel(g->evaluated, STALE_GRAIN, threads, judge_range, &j, NULL, NULL);
  }
  ylm_free(reach);
  ylm_free(least);
  return s;
}
