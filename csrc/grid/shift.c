/* shift.c - bringing the points that need it up to date. */
#include "update.h"

#include <string.h>

/* Which points are to be evaluated anew, and which get the difference. */
ylm_status update_choose_points(update *u) {
  ylm_grid *g = u->g;
  uint8_t *what = ylm_alloc(g->evaluated, 1);
  u->exact = ylm_alloc(g->evaluated, sizeof *u->exact);
  u->shift = ylm_alloc(g->evaluated, sizeof *u->shift);
  u->changed = ylm_alloc_zero(g->points, 1);
  ylm_status s = what && u->exact && u->shift && u->changed ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__grid_find_stale(g, u->tolerance, u->source.threads, what);
  for (uint32_t p = 0; s == YLM_OK && p < g->evaluated; p++) {
    if (what[p] == STALE_EXACT) u->exact[u->exacts++] = p;
    if (what[p] == STALE_SHIFT) u->shift[u->shifts++] = p;
    u->stats.skipped += what[p] == STALE_SKIPPED;
    u->changed[p] = what[p] == STALE_EXACT || what[p] == STALE_SHIFT;
  }
  ylm_free(what);
  return s;
}

typedef struct shift_job {
  ylm_grid *g;
  const field_block *block;
  const uint32_t *list;
} shift_job;

static ylm_status add_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const shift_job *j = context;
  for (size_t i = begin; i < end; i++) ylm__dynamic_add(j->g, j->list[i], j->block, i);
  return YLM_OK;
}

static ylm_status measure_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const shift_job *j = context;
  for (size_t i = begin; i < end; i++) ylm__dynamic_measure(j->g, j->list[i]);
  return YLM_OK;
}

/* Adds the light b and subtracts a at n points. */
static ylm_status shift_points(update *u, const lamp *a, const lamp *b, size_t n,
                               const uint32_t *list) {
  double at[6], radius[2], radiance[6];
  const lamp *both[2] = {a, b};
  ylm_lights *pair;
  for (size_t k = 0; k < 2; k++)
    for (size_t i = 0; i < 3; i++) {
      at[3 * k + i] = both[k]->at[i];
      radiance[3 * k + i] = k ? both[k]->radiance[i] : -both[k]->radiance[i];
      radius[k] = both[k]->radius;
    }
  ylm_status s = ylm_lights_create(2, at, radius, radiance, &pair, u->b.e);
  if (s == YLM_OK) s = baker_reserve_block(&u->b, &u->b.block, n);
  field_block *k = &u->b.block;
  for (size_t i = 0; s == YLM_OK && i < n; i += k->room) {
    size_t now = n - i < k->room ? n - i : k->room;
    for (size_t p = 0; p < now; p++) ylm__grid_asked(u->g, list[i + p], k->position + 3 * p);
    s = baker_ask_few(&u->b, ylm_lights_field(pair), now, k);
    shift_job j = {u->g, k, list + i};
    if (s == YLM_OK) s = ylm_parallel(now, 64, u->source.threads, add_range, &j, NULL, NULL);
  }
  ylm_lights_free(pair);
  return s;
}

/* Every mover, one state after the other: its points that are listed in u->shift. */
ylm_status update_shift_all(update *u) {
  grid_dynamic *d = u->d;
  uint32_t *list = ylm_alloc(u->shifts, sizeof *list);
  ylm_status s = list ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < d->movers; i++) {
    mover *m = &d->mover[i];
    size_t first[STATES + 1] = {0}, next[STATES];
    for (size_t k = 0; k < u->shifts; k++) first[m->seen[u->shift[k]] + 1]++;
    for (int k = 0; k < STATES; k++) first[k + 1] += first[k], next[k] = first[k];
    for (size_t k = 0; k < u->shifts; k++) list[next[m->seen[u->shift[k]]]++] = u->shift[k];
    for (int k = 0; s == YLM_OK && k < STATES; k++) {
      size_t n = first[k + 1] - first[k];
      if (k == m->current || n == 0) continue;
      s = shift_points(u, &m->state[k], &m->state[m->current], n, list + first[k]);
      for (size_t p = first[k]; p < first[k + 1]; p++) m->seen[list[p]] = (uint8_t)m->current;
    }
  }
  ylm_free(list);
  shift_job j = {u->g, NULL, u->shift};
  if (s == YLM_OK)
    s = ylm_parallel(u->shifts, 64, u->source.threads, measure_range, &j, NULL, NULL);
  return s;
}
