/*
** pack.c - a grid in bricks as one grid in memory.
**
** Its octree is that of the top with the bricks' in place of their cells; each evaluated point is there once. Continuity is made
** anew, which gives what the bricks have: it depends on evaluated points alone.
*/
#include <string.h>

#include "set.h"
#include "ylm_list.h"

/* A grid in the making. */
typedef struct packing {
  baker b;
  uint32_t *point; /* by evaluated point of the brick at hand */
} packing;

/* The evaluated points of a brick join the grid, unless they are there. */
static ylm_status add_points(packing *t, const ylm_grid *from) {
  ylm_grid *g = t->b.g;
  size_t row = 4 * g->stride;
  ylm_free(t->point);
  t->point = ylm_alloc(from->evaluated, sizeof *t->point);
  ylm_status s = t->point ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < from->evaluated && s == YLM_OK; i++) {
    size_t before = g->points;
    s = ylm__corners_point(&t->b, from->lattice + 3 * i, 0, &t->point[i]);
    if (s != YLM_OK || g->points == before) continue;
    if (g->validity && from->validity) {
      if (!ylm_list_resize(&g->validity, before, g->points, sizeof *g->validity)) return YLM_ENOMEM;
      g->validity[before] = from->validity[i];
    }
    g->flags[before] = from->flags[i];
    g->lambda[before] = from->lambda[i];
    g->norm[before] = from->norm[i];
    memcpy(g->data + before * row, from->data + i * row, row * sizeof *g->data);
  }
  g->evaluated = g->points;
  return s;
}

/* Cells of a brick's octree, from `first` on, join the grid. */
static ylm_status add_cells(packing *t, const ylm_grid *from, size_t first) {
  ylm_grid *g = t->b.g;
  size_t octree = from->contents.octree_cells, base = g->cells - first;
  ylm_status s = ylm__grid_reserve_cells(g, octree - first);
  for (size_t i = first; i < octree && s == YLM_OK; i++) {
    ylm_grid_cell c = from->cell[i];
    c.child = c.child && c.child < octree ? (uint32_t)(base + c.child) : 0;
    c.flags &= (uint8_t)~YLM_GRID_BRICK;
    c.detail = 0;
    c.source = 0;
    for (int k = 0; k < 8; k++)
      c.corner[k] = c.corner[k] < from->evaluated ? t->point[c.corner[k]] : YLM_GRID_NONE;
    g->cell[g->cells++] = c;
  }
  return s;
}

/* A brick takes the place of its cell. */
static ylm_status add_brick(packing *t, const ylm_grid *from, uint32_t cell) {
  const ylm_grid_cell *root = &from->cell[0];
  ylm_grid *g = t->b.g;
  ylm_status s = add_points(t, from);
  if (s != YLM_OK || !root->child || root->child >= from->contents.octree_cells) return s;
  size_t first = g->cells;
  s = add_cells(t, from, 1);
  if (s != YLM_OK) return s;
  g->cell[cell].child = (uint32_t)(first + root->child - 1);
  g->cell[cell].flags &= (uint8_t)~YLM_GRID_LEAF;
  return s;
}

static ylm_status add_all(packing *t, ylm_grid_set *set, const ylm_progress *progress,
                          ylm_error *e) {
  const ylm_grid *top = set->top;
  ylm_status s = add_points(t, top);
  if (s == YLM_OK) s = add_cells(t, top, 0);
  for (size_t i = 0, done = 0; i < top->contents.octree_cells && s == YLM_OK; i++) {
    const ylm_grid *from;
    if (set->number[i] == set->bricks) continue;
    s = ylm__set_get(set, set->number[i], t->b.source->threads, &from, e);
    if (s != YLM_OK) return s;
    s = add_brick(t, from, (uint32_t)i);
    if (s == YLM_OK) s = ylm__set_report(set, progress, ++done, set->bricks, "packing");
  }
  return s;
}

/* Facts of the bake, by the index. */
void ylm__pack_stats(ylm_grid *g, const ylm_grid *top) {
  const ylm_grid_stats *from = &top->stats;
  g->stats.pairs = from->pairs;
  g->stats.outside = from->outside;
  g->stats.rounds = from->rounds;
  g->stats.verified = from->verified;
  g->stats.error = from->error;
  g->stats.largest_error = from->largest_error;
  g->stats.met = from->met;
  g->stats.limited = from->limited;
  ylm__grid_file_forget_times(&g->stats);
}

static ylm_status finish(ylm_grid *g, int threads) {
  ylm_status s = YLM_OK;
  g->contents.octree_cells = g->cells;
  ylm__grid_find_baked(g);
  if (g->contents.form.continuous) s = ylm__grid_make_continuous(g, threads, NULL);
  if (s == YLM_OK) s = ylm__grid_finish(g);
  if (s == YLM_OK) ylm__grid_trim(g);
  return s;
}

ylm_status ylm_grid_set_pack(ylm_grid_set *set, int threads, const ylm_progress *progress,
                             ylm_grid **out, ylm_error *e) {
  ylm_grid_source source = {.threads = threads};
  packing t = {.point = NULL};
  *out = NULL;
  ylm__baker_begin(&t.b, ylm__grid_new(&set->top->contents.form), &source, e);
  ylm_grid *g = t.b.g;
  if (g && set->top->validity) g->validity = ylm_alloc(1, sizeof *g->validity);
  ylm_error why = {0};
  pthread_mutex_lock(&set->lock);
  ylm_status s = g && (g->validity || !set->top->validity) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = add_all(&t, set, progress, &why);
  pthread_mutex_unlock(&set->lock);
  if (s == YLM_OK) s = finish(g, threads);
  ylm_free(t.point);
  ylm__baker_free(&t.b);
  if (s == YLM_OK) {
    ylm__pack_stats(g, set->top);
    *out = g;
    return s;
  }
  ylm_grid_free(g);
  if (why.status == s) return ylm_fail(e, s, "%s", why.text);
  return ylm__grid_no_room(s, &source, e);
}
