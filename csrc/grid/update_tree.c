/* update_tree.c - the octree after an update of its points. */
#include "update.h"

#include <string.h>

/* True if the new octree is the old one: then what continuity added stays. */
static bool same_octree(const update *u) {
  const ylm_grid *g = u->g;
  const uint8_t flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_CROSSED;
  if (g->points != u->old.points || g->cells != g->view.octree_cells) return false;
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

/* The old cells again, with the new errors; points that continuity made follow those they are
   made of. */
static ylm_status keep_octree(update *u) {
  ylm_grid *g = u->g;
  for (size_t i = 0; i < g->cells; i++) {
    u->old.cell[i].error = g->cell[i].error;
    u->old.cell[i].residual = g->cell[i].residual;
  }
  ylm_free(g->cell);
  g->cell = u->old.cell;
  g->cells = u->old.cells;
  g->cell_room = u->old.cell_room;
  u->old.cell = NULL;
  g->evaluated = u->old.evaluated;
  for (size_t p = 0; p < g->evaluated; p++)
    if (g->flags[p] & YLM_GRID_POINT_INVALID) u->changed[p] = 1;
  ylm_status s = ylm__grid_fill_invalid(g);
  if (s == YLM_OK) s = ylm__grid_interpolate_points(g, u->changed, u->source.threads);
  ylm__grid_count(g);
  return s;
}

/* Points that are used take the first places, those that come last fill the gaps. */
static ylm_status drop_points(update *u) {
  ylm_grid *g = u->g;
  size_t live = 0, from = g->points;
  uint32_t *place = ylm_alloc(g->points, sizeof *place);
  if (!place) return YLM_ENOMEM;
  for (size_t p = 0; p < g->points; p++) {
    bool was = p < u->old.evaluated, interpolated = !was && p < u->old.points;
    if (interpolated) u->b.used[p] = 0;
    live += u->b.used[p];
    place[p] = (uint32_t)p;
    if (was && !u->b.used[p]) {
      u->stats.removed++;
      lattice_hash_remove(&g->hash, lattice_key(g->lattice + 3 * p));
    }
  }
  u->stats.added = live + u->stats.removed - u->old.evaluated;
  for (size_t to = 0; to < live; to++) {
    if (u->b.used[to]) continue;
    do from--;
    while (!u->b.used[from]);
    place[from] = (uint32_t)to;
    ylm__dynamic_move(g, (uint32_t)from, (uint32_t)to);
    *lattice_hash_at(&g->hash, lattice_key(g->lattice + 3 * to)) = (uint32_t)to;
  }
  for (size_t i = 0; i < g->cells; i++)
    for (int k = 0; k < 8; k++)
      if (g->cell[i].corner[k] != YLM_GRID_NONE) g->cell[i].corner[k] = place[g->cell[i].corner[k]];
  g->points = g->evaluated = live;
  ylm_free(place);
  return YLM_OK;
}

/* When memory runs out where nothing can be taken back: the root voxel alone, which needs none. */
static void collapse(ylm_grid *g) {
  ylm_grid_cell *c = &g->cell[0];
  g->cells = g->view.octree_cells = 1;
  g->points = g->evaluated;
  c->child = c->source = 0;
  c->detail = 0;
  c->flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_BAKED;
  for (int a = 0; a < 3; a++) g->top[a] = 1;
  g->top_shift = g->view.form.depth;
  g->table[0] = 0;
  ylm__grid_count(g);
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
  g->cell = NULL;
  g->cells = g->cell_room = 0;
  g->evaluated = g->points; /* new ones come behind interpolated ones, which go later */
  for (size_t p = 0; p < u->old.evaluated; p++) g->flags[p] |= YLM_GRID_POINT_TESTED;
  ylm_status s = baker_root(b);
  if (s != YLM_OK) return s;
  return g->view.form.tolerance > 0 ? ylm__grid_update_tolerance(b, u->changed, u->old.points)
                                    : baker_refine_threshold(b);
}

ylm_status update_octree(update *u) {
  ylm_status s = refine(u);
  if (s != YLM_OK) return s;
  if (same_octree(u)) return keep_octree(u);
  s = drop_points(u);
  if (s != YLM_OK) return s;
  ylm_free(u->old.cell);
  u->old.cell = NULL;
  u->over = true;
  s = baker_finish(&u->b);
  if (s != YLM_OK) collapse(u->g);
  return s;
}

ylm_status update_uniform(update *u) {
  ylm_grid *g = u->g;
  ylm_status s = ylm__grid_fill_invalid(g);
  for (size_t i = 0; s == YLM_OK && i < g->cells; i++)
    g->cell[i].error = baker_metric(&u->b, &g->cell[i], g->view.form.metric);
  ylm__grid_count(g);
  return s;
}
