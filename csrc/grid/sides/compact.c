/* compact.c - a grid with sides without what refinement has left behind. */
#include "sides.h"

#include <string.h>

/* Marks the points of leaves: 1, ghosts 2. */
static void mark_points(const ylm_grid *g, uint8_t *mark) {
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (!(c->flags & YLM_GRID_LEAF) || c->flags & YLM_GRID_SIDED) continue;
    for (int k = 0; k < 8; k++) mark[c->corner[k]] = 1;
  }
  for (size_t i = 0; i < g->sides.n; i++) {
    const ylm_grid_side *s = &g->sides.side[i];
    if (!(g->cell[s->cell].flags & YLM_GRID_LEAF)) continue;
    for (uint32_t p = s->first; p < s->first + s->parts; p++)
      for (int k = 0; k < 8; k++) {
        uint32_t point = g->sides.node[p][k];
        mark[point] = g->flags[point] & YLM_GRID_POINT_GHOST ? 2 : 1;
      }
  }
}

ylm_status ylm__sides_count(const ylm_grid *g, size_t *points) {
  uint8_t *mark = ylm_alloc_zero(g->points, 1);
  *points = 0;
  if (!mark) return YLM_ENOMEM;
  mark_points(g, mark);
  for (size_t p = 0; p < g->points; p++) *points += mark[p] != 0;
  ylm_free(mark);
  return YLM_OK;
}

/* Moves what is known of a point. `to` is free, or its own. */
static void move_point(ylm_grid *g, const ylm_grid *from, size_t point, size_t to) {
  size_t row = ylm__grid_record(g);
  memcpy(g->data + to * row, from->data + point * row, row * sizeof *g->data);
  memcpy(g->lattice + 3 * to, from->lattice + 3 * point, 3 * sizeof *g->lattice);
  memcpy(g->sides.asked[to], from->sides.asked[point], sizeof *g->sides.asked);
  g->lambda[to] = from->lambda[point];
  g->norm[to] = from->norm[point];
  g->flags[to] = from->flags[point];
  if (g->validity) g->validity[to] = from->validity[point];
}

/* Arrays of their own for n points. */
static ylm_status take_room(ylm_grid *g, size_t n) {
  g->data = NULL;
  g->lattice = NULL;
  g->lambda = g->norm = NULL;
  g->flags = NULL;
  g->sides.asked = NULL;
  g->data_bytes = g->points = g->point_room = 0;
  bool told = g->validity;
  g->validity = told ? ylm_alloc(1, sizeof *g->validity) : NULL;
  if (told && !g->validity) return YLM_ENOMEM;
  return ylm__grid_reserve_points(g, n ? n : 1);
}

/* Points get their new numbers; the hash has those that are no ghosts. */
static ylm_status renumber(ylm_grid *g, const uint32_t *number) {
  for (size_t i = 0; i < g->cells; i++) {
    ylm_grid_cell *c = &g->cell[i];
    for (int k = 0; k < 8; k++)
      if (c->corner[k] != YLM_GRID_NONE) c->corner[k] = number[c->corner[k]];
    bool whole = ylm__grid_is_complete(c);
    for (int k = 0; !whole && k < 8; k++) c->corner[k] = YLM_GRID_NONE;
  }
  for (size_t p = 0; p < g->sides.parts; p++)
    for (int k = 0; k < 8; k++) g->sides.node[p][k] = number[g->sides.node[p][k]];
  ylm__lattice_hash_free(&g->hash);
  return ylm__sides_hash(g);
}

/* The sides of leaves, in the order of their cells, and their parts. */
static ylm_status sort_sides(side_baker *k) {
  ylm_grid *g = k->b->g;
  grid_sides *s = &g->sides, old = *s;
  size_t n = 0, parts = 0;
  for (size_t i = 0; i < g->cells; i++)
    if (g->cell[i].flags & YLM_GRID_SIDED) n++, parts += old.side[k->row[i]].parts;
  s->side = ylm_alloc(n ? n : 1, sizeof *s->side);
  s->node = ylm_alloc(parts ? parts : 1, sizeof *s->node);
  s->n = s->parts = 0;
  s->room = n ? n : 1;
  s->part_room = parts ? parts : 1;
  bool ok = s->side && s->node;
  for (size_t i = 0; ok && i < g->cells; i++) {
    if (!(g->cell[i].flags & YLM_GRID_SIDED)) continue;
    ylm_grid_side *side = &s->side[s->n];
    *side = old.side[k->row[i]];
    ylm_copy(s->node + s->parts, old.node + side->first, side->parts * sizeof *s->node);
    side->first = (uint32_t)s->parts;
    s->parts += side->parts;
    k->row[i] = (uint32_t)s->n++;
  }
  ylm_free(old.side);
  ylm_free(old.node);
  return ok ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm__sides_compact(side_baker *k) {
  ylm_grid *g = k->b->g, old;
  size_t n = g->points, kept = 0;
  ylm_status s = sort_sides(k);
  uint8_t *mark = ylm_alloc_zero(n, 1);
  uint32_t *number = ylm_alloc(n, sizeof *number);
  if (s == YLM_OK && !(mark && number)) s = YLM_ENOMEM;
  if (s == YLM_OK) {
    mark_points(g, mark);
    for (size_t p = 0; p < n; p++) kept += mark[p] != 0;
    old = *g;
    s = take_room(g, kept);
    if (s != YLM_OK) {
      ylm__grid_free_points(g);
      *g = old;
    }
  }
  if (s == YLM_OK) {
    for (size_t p = 0; p < n; p++) number[p] = YLM_GRID_NONE;
    for (uint8_t which = 1; which <= 2; which++)
      for (size_t p = 0; p < n; p++)
        if (mark[p] == which) {
          move_point(g, &old, p, g->points);
          number[p] = (uint32_t)g->points++;
        }
    g->evaluated = g->points;
    ylm__grid_free_points(&old);
    s = renumber(g, number);
  }
  ylm_free(mark);
  ylm_free(number);
  return s;
}
