/*
** repair.c - points and cells after an update that changed the octree.
**
** Unneeded points go, and new ones take their places. Cells and points that continuity has added
** stay where they are. In leaves that are new, or that a point which came or went touches,
** continuity is made anew. All memory that is needed is reserved first, so that nothing can fail
** before indices are good again.
*/
#include "update.h"

#include <string.h>

typedef struct repair {
  update *u;
  ylm_grid *g;
  const ylm_grid_cell *was; /* the cells before */
  size_t old_evaluated, old_points, points;
  size_t live, kept;     /* evaluated and interpolated points that remain */
  uint8_t *affected;     /* [cells of the new octree] leaves whose continuity is made anew */
  uint32_t *now;         /* [cells before] where added cells and their leaves are now */
  uint32_t *place;       /* [points] where they go */
  ylm_grid_birth *birth; /* of the interpolated points that remain */
  uint64_t *born_sign;   /* theirs */
  uint32_t *displaced;   /* interpolated points that remain, but not where they are */
  char *saved;           /* their data */
  size_t displacements;
} repair;

/* -- what is affected ----------------------------------------------------------------------- */

/* The octree's leaves around a point that came or went. */
static void affect_around(repair *r, const uint32_t at[3]) {
  const ylm_grid *g = r->g;
  uint32_t beside[3];
  for (int side = 0; side < 8; side++) {
    if (!ylm__grid_side(g, at, side, beside)) continue;
    uint32_t cell = 0;
    while (g->cell[cell].child) {
      int shift = g->contents.form.depth - g->cell[cell].level - 1;
      cell = g->cell[cell].child + octant_of(beside[0], beside[1], beside[2], (uint32_t)shift);
    }
    r->affected[cell] = 1;
  }
}

static void find_affected(repair *r) {
  const ylm_grid *g = r->g;
  for (size_t p = 0; p < r->points; p++) {
    bool interpolated = p >= r->old_evaluated && p < r->old_points;
    if (!interpolated && (p >= r->old_points || !r->u->b.used[p]))
      affect_around(r, g->lattice + 3 * p);
  }
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i], *old = cells_before(&r->u->b, c);
    if (c->flags & YLM_GRID_LEAF && (!old || !(old->flags & YLM_GRID_LEAF))) r->affected[i] = 1;
  }
}

/* -- cells ---------------------------------------------------------------------------------- */

/* Copies what continuity has added to a leaf; corners are numbered as before. */
static void keep_added(repair *r, uint32_t cell, uint32_t from) {
  ylm_grid *g = r->g;
  uint32_t child = r->was[from].child, first = (uint32_t)g->cells;
  r->now[from] = cell;
  if (!child) return;
  g->cell[cell].child = first;
  g->cells += 8;
  for (uint32_t k = 0; k < 8; k++) {
    g->cell[first + k] = r->was[child + k];
    g->cell[first + k].child = 0;
    keep_added(r, first + k, child + k);
  }
}

/* Leaves that are not affected are what they were. */
static void keep_leaves(repair *r, size_t octree) {
  ylm_grid *g = r->g;
  for (uint32_t i = 0; i < octree; i++) {
    ylm_grid_cell *c = &g->cell[i];
    if (!(c->flags & YLM_GRID_LEAF) || r->affected[i]) continue;
    const ylm_grid_cell *old = &r->was[c->source];
    memcpy(c->corner, old->corner, sizeof c->corner);
    c->detail = old->detail;
    keep_added(r, i, c->source);
  }
}

/* -- points --------------------------------------------------------------------------------- */

/* Which interpolated points are used, and how many points remain. */
static void count_points(repair *r) {
  uint8_t *used = r->u->b.used;
  r->live = r->kept = 0;
  for (size_t p = 0; p < r->points; p++) {
    bool interpolated = p >= r->old_evaluated && p < r->old_points;
    r->place[p] = (uint32_t)p;
    if (interpolated) used[p] = r->now[r->g->birth[p - r->old_evaluated].cell] != YLM_GRID_NONE;
    *(interpolated ? &r->kept : &r->live) += used[p];
  }
}

/* Forgets evaluated points that are not used. */
static void drop_points(repair *r) {
  ylm_grid *g = r->g;
  update *u = r->u;
  for (size_t p = 0; p < r->old_evaluated; p++) {
    if (u->b.used[p]) continue;
    u->stats.removed++;
    ylm__lattice_hash_remove(&g->hash, lattice_key(g->lattice + 3 * p));
  }
  u->stats.added = r->live + u->stats.removed - r->old_evaluated;
}

/* The points that an interpolated point is made of. */
static size_t point_bytes(const ylm_grid *g) {
  return 4 * g->stride * sizeof(float) + 3 * sizeof(uint32_t) + 2 * sizeof(float);
}
static void save_point(const ylm_grid *g, size_t p, char *to) {
  size_t row = 4 * g->stride * sizeof(float);
  memcpy(to, g->data + p * 4 * g->stride, row);
  memcpy(to + row, g->lattice + 3 * p, 12);
  memcpy(to + row + 12, &g->lambda[p], 4);
  memcpy(to + row + 16, &g->norm[p], 4);
}
static void load_point(ylm_grid *g, size_t p, const char *from) {
  size_t row = 4 * g->stride * sizeof(float);
  memcpy(g->data + p * 4 * g->stride, from, row);
  memcpy(g->lattice + 3 * p, from + row, 12);
  memcpy(&g->lambda[p], from + row + 12, 4);
  memcpy(&g->norm[p], from + row + 16, 4);
  g->flags[p] = YLM_GRID_POINT_INTERPOLATED;
}

/* Interpolated points have to stand behind the evaluated ones, without gaps: those that do not are
   taken out of the way. Their number is at most that of points that came or went. */
static ylm_status take_out(repair *r) {
  const ylm_grid *g = r->g;
  size_t end = r->live + r->kept, bytes = point_bytes(g), n = 0;
  for (size_t p = r->old_evaluated; p < r->old_points; p++)
    n += r->u->b.used[p] && (p < r->live || p >= end);
  r->displaced = ylm_alloc(n, sizeof *r->displaced);
  r->saved = ylm_alloc(n, bytes);
  if (!r->displaced || !r->saved) return YLM_ENOMEM;
  for (size_t p = r->old_evaluated; p < r->old_points; p++) {
    if (!r->u->b.used[p] || (p >= r->live && p < end)) continue;
    save_point(g, p, r->saved + r->displacements * bytes);
    r->displaced[r->displacements++] = (uint32_t)p;
  }
  return YLM_OK;
}

/* Evaluated points take the first places: those that come last fill the gaps. */
static void place_evaluated(repair *r) {
  ylm_grid *g = r->g;
  const uint8_t *used = r->u->b.used;
  size_t from = r->points;
  for (size_t to = 0; to < r->live; to++) {
    bool interpolated = to >= r->old_evaluated && to < r->old_points;
    if (!interpolated && used[to]) continue;
    do from--;
    while (!used[from] || (from >= r->old_evaluated && from < r->old_points));
    r->place[from] = (uint32_t)to;
    ylm__dynamic_move(g, (uint32_t)from, (uint32_t)to);
    *ylm__lattice_hash_at(&g->hash, lattice_key(g->lattice + 3 * to)) = (uint32_t)to;
  }
}

/* Points that were taken out fill the gaps behind them. */
static void place_interpolated(repair *r) {
  ylm_grid *g = r->g;
  const grid_dynamic *d = r->u->d;
  size_t next = 0, bytes = point_bytes(g);
  for (size_t to = r->live; to < r->live + r->kept; to++) {
    bool stays = to >= r->old_evaluated && to < r->old_points && r->u->b.used[to];
    size_t from = stays ? to : r->displaced[next];
    if (!stays) load_point(g, to, r->saved + next++ * bytes);
    r->place[from] = (uint32_t)to;
    ylm_grid_birth born = g->birth[from - r->old_evaluated];
    r->birth[to - r->live] = (ylm_grid_birth){r->now[born.cell], born.place};
    if (r->born_sign) r->born_sign[to - r->live] = d->born_sign[from - r->old_evaluated];
  }
  ylm_copy(g->birth, r->birth, r->kept * sizeof *g->birth);
  if (r->born_sign) ylm_copy(d->born_sign, r->born_sign, r->kept * sizeof *d->born_sign);
}

static void renumber_corners(repair *r) {
  ylm_grid *g = r->g;
  for (size_t i = 0; i < g->cells; i++)
    for (int k = 0; k < 8; k++) {
      uint32_t *p = &g->cell[i].corner[k];
      if (*p != YLM_GRID_NONE) *p = r->place[*p];
    }
}

/* -- all together --------------------------------------------------------------------------- */

static ylm_status reserve(repair *r, size_t octree_before) {
  ylm_grid *g = r->g;
  size_t cells = r->u->old.cells, born = r->old_points - r->old_evaluated;
  r->affected = ylm_alloc_zero(g->cells, 1);
  r->now = ylm_alloc(cells, sizeof *r->now);
  r->place = ylm_alloc(r->points, sizeof *r->place);
  r->birth = ylm_alloc(born, sizeof *r->birth);
  if (r->u->d->is_signed) r->born_sign = ylm_alloc(born, sizeof *r->born_sign);
  if (!r->affected || !r->now || !r->place || !r->birth) return YLM_ENOMEM;
  for (size_t i = 0; i < cells; i++) r->now[i] = YLM_GRID_NONE;
  return ylm__grid_reserve_cells(g, cells - octree_before);
}

/* Marks the points whose data changed, by their new numbers, for points that are interpolated
   between them. */
static ylm_status renumber_changed(repair *r) {
  const ylm_grid *g = r->g;
  uint8_t *changed = ylm_alloc_zero(g->points, 1);
  if (!changed) return YLM_ENOMEM;
  for (size_t p = 0; p < r->points; p++) {
    bool interpolated = p >= r->old_evaluated && p < r->old_points;
    if (!r->u->b.used[p] || interpolated) continue;
    changed[r->place[p]] = p >= r->old_points || r->u->changed[p];
  }
  for (size_t p = 0; p < g->evaluated; p++)
    if (g->flags[p] & YLM_GRID_POINT_INVALID) changed[p] = 1;
  memset(changed + r->live + r->kept, 1, g->points - r->live - r->kept);
  ylm_free(r->u->changed);
  r->u->changed = changed;
  return YLM_OK;
}

/* Continuity where it is affected; data of interpolated points that need new ones. */
static ylm_status continue_affected(repair *r, size_t octree) {
  ylm_grid *g = r->g;
  ylm__corners_find_shared(&r->u->b, r->affected);
  ylm__grid_find_baked(g);
  ylm_status s = ylm__grid_fill_invalid(g);
  for (uint32_t i = 0; i < octree && s == YLM_OK && g->contents.form.continuous; i++)
    if (r->affected[i]) s = ylm__grid_continue_leaf(g, i);
  if (s == YLM_OK) s = renumber_changed(r);
  if (s == YLM_OK) s = ylm__grid_interpolate_points(g, r->u->changed, r->u->source.threads, NULL);
  return s == YLM_OK ? ylm__grid_finish(g) : s;
}

static void free_repair(repair *r) {
  ylm_free(r->affected);
  ylm_free(r->now);
  ylm_free(r->place);
  ylm_free(r->birth);
  ylm_free(r->born_sign);
  ylm_free(r->displaced);
  ylm_free(r->saved);
}

/* Numbers points and cells as they will be. Fails only where nothing has been changed yet. */
static ylm_status renumber(repair *r, bool everywhere) {
  ylm_grid *g = r->g;
  size_t octree = g->cells;
  ylm_status s = reserve(r, g->contents.octree_cells);
  if (s != YLM_OK) return s;
  if (!everywhere) {
    find_affected(r);
    keep_leaves(r, octree);
  }
  count_points(r);
  s = take_out(r);
  if (s != YLM_OK) return s;
  r->u->over = true;
  drop_points(r);
  place_evaluated(r);
  place_interpolated(r);
  renumber_corners(r);
  g->evaluated = r->live;
  g->points = r->live + r->kept;
  g->contents.octree_cells = octree;
  return YLM_OK;
}

ylm_status ylm__update_repair(update *u, bool everywhere) {
  repair r = {.u = u,
              .g = u->g,
              .was = u->old.cell,
              .old_evaluated = u->old.evaluated,
              .old_points = u->old.points,
              .points = u->g->points};
  size_t octree = u->g->cells;
  ylm_status s = renumber(&r, everywhere);
  if (s == YLM_OK) s = everywhere ? ylm__finish(&u->b) : continue_affected(&r, octree);
  free_repair(&r);
  return s;
}
