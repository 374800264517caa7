/* octree.c - the octree after an update of its points. */
#include "update.h"

#include <string.h>

/* True if the new octree is the old one: then what continuity added stays. */
static bool same_octree(const update *u) {
  const ylm_grid *g = u->g;
  const uint8_t flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_CROSSED;
  if (g->points != u->old.points || g->cells != g->contents.octree_cells) return false;
  for (size_t p = 0; p < u->old.evaluated; p++)
    if (!u->b.used[p]) return false;
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *a = &u->old.cell[i], *b = &g->cell[i];
    if (a->level != b->level || (a->flags & flags) != (b->flags & flags) ||
        memcmp(a->origin, b->origin, sizeof a->origin) != 0 ||
        (!(b->flags & YLM_GRID_LEAF) && a->child != b->child))
      return false;
  }
  return true;
}

/* Cells that the next update may use: their pages are there. */
static void spare_cells(update *u, ylm_grid_cell *cell, size_t room) {
  ylm_free(u->d->spare);
  u->d->spare = cell;
  u->d->spare_room = room;
}

/* The old cells again, with the new errors; points that continuity made follow those they are
   made of. */
static ylm_status keep_octree(update *u) {
  ylm_grid *g = u->g;
  ylm_grid_cell *made = g->cell;
  size_t octree = g->cells, room = g->cell_room;
  g->cell = u->old.cell;
  g->cells = u->old.cells;
  g->cell_room = u->old.cell_room;
  u->old.cell = NULL;
  g->evaluated = u->old.evaluated;
  for (size_t p = 0; p < g->evaluated; p++)
    if (g->flags[p] & YLM_GRID_POINT_INVALID) u->changed[p] = 1;
  ylm_status s = ylm__grid_fill_invalid(g);
  if (s == YLM_OK) s = ylm__grid_interpolate_points(g, u->changed, u->source.threads, NULL);
  for (size_t i = 0; i < octree && s == YLM_OK; i++) {
    g->cell[i].error = made[i].error;
    g->cell[i].residual = made[i].residual;
  }
  spare_cells(u, made, room);
  ylm__grid_count(g);
  return s;
}

/* True if it is not worth while to look what of the continuity may stay. */
static bool many_came_or_went(const update *u) {
  size_t n = u->g->points - u->old.points;
  for (size_t p = 0; p < u->old.evaluated; p++) n += !u->b.used[p];
  return n > u->old.evaluated / 4;
}

/* When memory runs out where nothing can be taken back: what that would have needed is given back,
   and the octree is made continuous from the beginning. */
static ylm_status repair_again(update *u) {
  ylm_grid *g = u->g;
  grid_dynamic *d = u->d;
  ylm__update_forget_rows(u);
  ylm_regrow_free(d->log, d->log_bytes);
  d->log = NULL;
  d->log_bytes = 0;
  g->cells = g->contents.octree_cells;
  g->points = g->evaluated;
  for (size_t i = 0; i < g->cells; i++) {
    ylm_grid_cell *c = &g->cell[i];
    c->detail = 0;
    if (c->flags & YLM_GRID_LEAF) c->child = 0;
  }
  return ylm__finish(&u->b);
}

/* When that fails too: the root voxel alone, which needs no memory. The grid is then spent. */
static void collapse(ylm_grid *g) {
  ylm_grid_cell *c = &g->cell[0];
  g->cells = g->contents.octree_cells = 1;
  g->points = g->evaluated;
  c->child = c->source = 0;
  c->detail = 0;
  c->flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_BAKED;
  for (int a = 0; a < 3; a++) g->top[a] = 1;
  g->top_shift = g->contents.form.depth;
  g->table[0] = 0;
  ylm__grid_count(g);
  g->spent = true;
}

/* New cells from the root; points that exist are found by the hash. */
static ylm_status refine(update *u) {
  ylm_grid *g = u->g;
  baker *b = &u->b;
  b->used_room = g->point_room;
  b->used = ylm_alloc_zero(b->used_room, 1);
  if (!b->used) return YLM_ENOMEM;
  b->before = u->old.cell = g->cell;
  b->changed = u->changed;
  b->unsettled = u->boxes;
  b->unsettleds = 2 * u->changes;
  g->cell = u->d->spare;
  g->cells = 0;
  g->cell_room = u->d->spare_room;
  u->d->spare = NULL;
  u->d->spare_room = 0;
  g->evaluated = g->points; /* new ones come behind interpolated ones, which go later */
  for (size_t p = 0; p < u->old.evaluated; p++) g->flags[p] |= YLM_GRID_POINT_TESTED;
  ylm_status s = ylm__grid_reserve_cells(g, u->old.cells);
  if (s == YLM_OK) s = ylm__cells_root(b);
  if (s != YLM_OK) return s;
  return g->contents.form.tolerance > 0
             ? ylm__update_tolerance(b, u->changed, u->old.points, &u->panel)
             : ylm__refine(b, b->wave.n);
}

ylm_status ylm__update_octree(update *u) {
  ylm_status s = refine(u);
  if (s != YLM_OK) return s;
  if (same_octree(u)) return keep_octree(u);
  u->whole |= many_came_or_went(u);
  s = ylm__update_repair(u, u->whole);
  if (s == YLM_ENOMEM && u->over) s = repair_again(u);
  if (s != YLM_OK && u->over) collapse(u->g);
  if (!u->over) return s;
  spare_cells(u, u->old.cell, u->old.cell_room);
  u->old.cell = NULL;
  return s;
}

ylm_status ylm__update_uniform(update *u) {
  ylm_grid *g = u->g;
  ylm_status s = ylm__grid_fill_invalid(g);
  for (size_t i = 0; s == YLM_OK && i < g->cells; i++)
    g->cell[i].error = ylm__metric_of(&u->b, &g->cell[i], g->contents.form.metric);
  ylm__grid_count(g);
  return s;
}
