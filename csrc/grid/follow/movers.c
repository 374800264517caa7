/* movers.c - lights that have changed, and the states that points have them in. */
#include "update.h"
#include "ylm_list.h"

#include <string.h>

/* How many points have a mover in each state. */
static void count_states(const mover *m, size_t points, size_t n[STATES]) {
  memset(n, 0, STATES * sizeof *n);
  for (size_t p = 0; p < points; p++) n[m->seen[p]]++;
}

/* Makes `now` the present state: one that is remembered, or a free one. One remains free: if it is
   the last, the state that the fewest points have has to go. */
static void enter_state(update *u, mover *m, const ylm_light *now) {
  size_t n[STATES], least = SIZE_MAX;
  int found = -1, empty = -1, left = 0;
  count_states(m, u->g->evaluated, n);
  for (int k = 0; k < STATES; k++) {
    m->taken[k] = k == m->current || n[k] > 0;
    if (m->taken[k] && ylm_light_compare(&m->state[k], now) == 0) found = k;
    if (!m->taken[k] && empty < 0) empty = k;
  }
  m->current = found >= 0 ? found : empty;
  m->state[m->current] = *now;
  m->taken[m->current] = true;
  for (int k = 0; k < STATES; k++)
    m->slides[k] = m->taken[k] && ylm_light_slides(&m->state[k], now);
  m->moved = u->stats.updates;
  m->evict = -1;
  for (int k = 0; k < STATES; k++) {
    left += !m->taken[k];
    if (k != m->current && m->taken[k] && n[k] < least) {
      least = n[k];
      m->evict = k;
    }
  }
  if (left > 1) m->evict = -1;
}

/* A mover whose points all have it in state 0. */
static ylm_status new_mover(grid_dynamic *d, const ylm_light *was) {
  if (!ylm_list_resize(&d->mover, d->movers, d->movers + 1, sizeof *d->mover)) return YLM_ENOMEM;
  mover *m = &d->mover[d->movers];
  *m = (mover){.evict = -1};
  m->state[0] = *was;
  m->taken[0] = true;
  m->seen = ylm_alloc_zero(d->room, 1);
  if (!m->seen) return YLM_ENOMEM;
  d->movers++;
  return YLM_OK;
}

static ylm_light dark(const ylm_light *l) {
  ylm_light out = *l;
  memset(out.radiance, 0, sizeof out.radiance);
  return out;
}

/* Enters the new light set: lights that changed become movers. Arrays are changed only after
   everything that can fail. `of` is the new mover_of. */
ylm_status ylm__update_enter_changes(update *u, int32_t *of) {
  grid_dynamic *d = u->d;
  u->boxes = ylm_alloc(2 * u->changes, 6 * sizeof *u->boxes);
  if (!u->boxes) return YLM_ENOMEM;
  for (size_t j = 0; j < u->now.n; j++) of[j] = u->origin[j] < 0 ? -1 : d->mover_of[u->origin[j]];
  for (size_t i = 0; i < u->changes; i++) {
    const light_change *c = &u->change[i];
    const ylm_light *after = c->after < 0 ? NULL : &u->now.light[c->after];
    const ylm_light was = c->before < 0 ? dark(after) : d->light[c->before];
    int32_t m = c->before < 0 ? -1 : d->mover_of[c->before];
    if (m < 0) {
      ylm_status s = new_mover(d, &was);
      if (s != YLM_OK) return s;
      m = (int32_t)d->movers - 1;
    }
    ylm_light now = after ? *after : dark(&was);
    enter_state(u, &d->mover[m], &now);
    ylm_light_box(&was, u->boxes + 12 * i);
    ylm_light_box(&now, u->boxes + 12 * i + 6);
    if (after) of[c->after] = m;
  }
  if (d->movers > MANY_MOVERS) {
    size_t oldest = 0;
    for (size_t m = 1; m < d->movers; m++)
      if (d->mover[m].moved < d->mover[oldest].moved) oldest = m;
    d->mover[oldest].evict = EVICT_ALL;
  }
  return YLM_OK;
}

/* Forgets movers that all points have in their present state. */
void ylm__update_retire(grid_dynamic *d, size_t points) {
  for (size_t m = d->movers; m-- > 0;) {
    size_t n[STATES];
    count_states(&d->mover[m], points, n);
    if (n[d->mover[m].current] != points) continue;
    size_t last = --d->movers;
    ylm_free(d->mover[m].seen);
    if (m != last) d->mover[m] = d->mover[last];
    for (size_t i = 0; i < d->lights; i++) {
      if (d->mover_of[i] == (int32_t)m)
        d->mover_of[i] = -1;
      else if (d->mover_of[i] == (int32_t)last)
        d->mover_of[i] = (int32_t)m;
    }
  }
}
