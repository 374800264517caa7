/* undo.c - an update that fails or is cancelled is taken back. */
#include "update.h"

#include <string.h>

/* Keeps everything but rows of data. */
ylm_status ylm__update_remember(update *u) {
  const ylm_grid *g = u->g;
  const grid_dynamic *d = u->d;
  undo *o = &u->old;
  o->points = g->points;
  o->evaluated = g->evaluated;
  o->cells = g->cells;
  o->cell_room = g->cell_room;
  o->tight = d->tight;
  o->flags = ylm_alloc_copy(g->flags, g->points, 1);
  o->lambda = ylm_alloc_copy(g->lambda, g->points, sizeof *o->lambda);
  o->norm = ylm_alloc_copy(g->norm, g->points, sizeof *o->norm);
  o->size = ylm_alloc_copy(d->size, g->evaluated, sizeof *o->size);
  o->drift = ylm_alloc_copy(d->drift, g->evaluated, sizeof *o->drift);
  o->sign = ylm_alloc_copy(d->sign, g->evaluated, sizeof *o->sign);
  o->forced = d->forced;
  o->forced.entry = ylm_alloc_copy(d->forced.entry, d->forced.size, sizeof *o->forced.entry);
  o->mover = ylm_alloc_copy(d->mover, d->movers, sizeof *o->mover);
  if (!o->flags || !o->lambda || !o->norm || !o->size || !o->drift || !o->sign || !o->mover ||
      !o->forced.entry)
    return YLM_ENOMEM;
  for (size_t m = 0; m < d->movers; m++) o->mover[m].seen = NULL;
  o->movers = d->movers;
  for (size_t m = 0; m < d->movers; m++) {
    o->mover[m].seen = ylm_alloc_copy(d->mover[m].seen, g->evaluated, 1);
    if (!o->mover[m].seen) return YLM_ENOMEM;
  }
  return YLM_OK;
}

void ylm__update_log_row(update *u, size_t log, uint32_t point) {
  undo *o = &u->old;
  size_t row = 4 * u->g->stride, hessians = u->d->hessians;
  memcpy(o->data + log * row, u->g->data + point * row, row * sizeof *o->data);
  if (hessians)
    memcpy(o->hessian + log * hessians, u->d->hessian + point * hessians,
           hessians * sizeof *o->hessian);
  o->logged[log] = point;
}

/* Room for n rows in the grid's log, which stays between updates: fresh pages would cost more than
   what is written to them. */
static ylm_status reserve_log(update *u, size_t n) {
  undo *o = &u->old;
  grid_dynamic *d = u->d;
  size_t row = 4 * u->g->stride, bytes = n * (row + d->hessians) * sizeof(float);
  if (bytes > d->log_bytes) {
    void *log = ylm_regrow(d->log, d->log_bytes, bytes + bytes / 4);
    if (!log) return YLM_ENOMEM;
    d->log = log;
    d->log_bytes = bytes + bytes / 4;
  }
  o->data = d->log;
  o->hessian = o->data + n * row;
  o->logged = ylm_alloc(n, sizeof *o->logged);
  return o->logged ? YLM_OK : YLM_ENOMEM;
}

static ylm_status log_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  update *u = context;
  for (size_t i = begin; i < end; i++) ylm__update_log_row(u, i, u->old.logged[i]);
  return YLM_OK;
}

ylm_status ylm__update_log_rows(update *u) {
  const ylm_grid *g = u->g;
  undo *o = &u->old;
  size_t invalid = 0;
  for (size_t p = 0; p < g->evaluated; p++)
    invalid += g->flags[p] & YLM_GRID_POINT_INVALID && !u->changed[p];
  ylm_status s = reserve_log(u, u->exacts + invalid + u->shifts);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < u->exacts; i++) o->logged[o->logs++] = u->exact[i];
  for (uint32_t p = 0; p < g->evaluated; p++)
    if (g->flags[p] & YLM_GRID_POINT_INVALID && !u->changed[p]) o->logged[o->logs++] = p;
  size_t now = o->logs;
  for (size_t i = 0; i < u->shifts; i++) o->logged[o->logs++] = YLM_GRID_NONE;
  return ylm_parallel(now, UNDO_GRAIN, u->source.threads, log_range, u, NULL, NULL);
}

void ylm__update_restore(update *u) {
  ylm_grid *g = u->g;
  grid_dynamic *d = u->d;
  undo *o = &u->old;
  size_t row = 4 * g->stride, hessians = d->hessians;
  d->tight = o->tight;
  lattice_hash forced = d->forced;
  d->forced = o->forced;
  o->forced = forced;
  for (size_t p = o->points; p < g->points; p++)
    ylm__lattice_hash_remove(&g->hash, lattice_key(g->lattice + 3 * p));
  g->points = o->points;
  g->evaluated = o->evaluated;
  if (o->cell) {
    ylm_free(g->cell);
    g->cell = o->cell;
    g->cells = o->cells;
    g->cell_room = o->cell_room;
    o->cell = NULL;
  }
  memcpy(g->flags, o->flags, g->points);
  memcpy(g->lambda, o->lambda, g->points * sizeof *g->lambda);
  memcpy(g->norm, o->norm, g->points * sizeof *g->norm);
  memcpy(d->size, o->size, g->evaluated * sizeof *d->size);
  memcpy(d->drift, o->drift, g->evaluated * sizeof *d->drift);
  memcpy(d->sign, o->sign, g->evaluated * sizeof *d->sign);
  for (size_t i = 0; i < o->logs; i++) {
    size_t p = o->logged[i];
    if (p == YLM_GRID_NONE) continue;
    memcpy(g->data + p * row, o->data + i * row, row * sizeof *g->data);
    if (hessians)
      memcpy(d->hessian + p * hessians, o->hessian + i * hessians, hessians * sizeof *d->hessian);
  }
  for (size_t m = 0; m < d->movers; m++) {
    uint8_t *seen = d->mover[m].seen;
    if (m >= o->movers) {
      ylm_free(seen);
      continue;
    }
    memcpy(seen, o->mover[m].seen, g->evaluated);
    mover was = o->mover[m];
    was.seen = seen;
    d->mover[m] = was;
  }
  d->movers = o->movers;
  ylm__grid_sync(g);
}

void ylm__update_forget_rows(update *u) {
  undo *o = &u->old;
  for (size_t m = 0; o->mover && m < o->movers; m++) ylm_free(o->mover[m].seen);
  ylm_free(o->mover);
  ylm_free(o->flags);
  ylm_free(o->lambda);
  ylm_free(o->norm);
  ylm_free(o->size);
  ylm_free(o->drift);
  ylm_free(o->sign);
  ylm_free(o->logged);
  ylm__lattice_hash_free(&o->forced);
  u->old = (undo){.points = o->points,
                  .evaluated = o->evaluated,
                  .cells = o->cells,
                  .cell_room = o->cell_room,
                  .cell = o->cell};
}

void ylm__update_forget(update *u) {
  ylm__update_forget_rows(u);
  ylm_free(u->old.cell);
  ylm_light_list_free(&u->now);
  ylm_free(u->origin);
  ylm_free(u->change);
  ylm_free(u->exact);
  ylm_free(u->shift);
  ylm_free(u->changed);
  ylm_free(u->boxes);
  ylm__panel_forget_light(&u->panel);
  ylm__baker_free(&u->b);
}
