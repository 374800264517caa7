/* index.c - finding the sides of cells, and points by their corners. */
#include "sides.h"

void ylm__sides_free(grid_sides *s) {
  ylm_free(s->side);
  ylm_free(s->node);
  ylm_free(s->of);
  ylm_free(s->leaf);
  ylm_free(s->dark);
}

ylm_status ylm__sides_index(ylm_grid *g) {
  grid_sides *s = &g->sides;
  ylm_free(s->of);
  ylm_free(s->leaf);
  s->of = ylm_alloc(g->cells, sizeof *s->of);
  s->leaf = ylm_alloc(s->parts ? s->parts : 1, sizeof *s->leaf);
  if (!s->dark) s->dark = ylm_alloc_zero(g->stride + ROW_PADDING, sizeof *s->dark);
  if (!s->of || !s->leaf || !s->dark) return YLM_ENOMEM;
  for (size_t i = 0; i < g->cells; i++) s->of[i] = YLM_GRID_NONE;
  for (size_t i = 0; i < s->n; i++) {
    const ylm_grid_side *side = &s->side[i];
    if (!(g->cell[side->cell].flags & YLM_GRID_SIDED)) continue; /* it was split */
    s->of[side->cell] = (uint32_t)i;
    for (uint32_t p = 0; p < side->parts; p++) s->leaf[side->first + p] = side->cell;
  }
  return YLM_OK;
}

#define FETCHED 8 /* points ahead, whose places in the hash are brought towards the cache */

ylm_status ylm__sides_hash_to(const ylm_grid *g, lattice_hash *h) {
  ylm_status s = ylm__lattice_hash_reserve(h, g->evaluated);
  for (size_t i = 0; s == YLM_OK && i < g->evaluated; i++) {
    size_t ahead = i + FETCHED < g->evaluated ? i + FETCHED : i;
    ylm__lattice_hash_prefetch(h, lattice_key(g->lattice + 3 * ahead));
    if (!(g->flags[i] & YLM_GRID_POINT_GHOST))
      *ylm__lattice_hash_at(h, lattice_key(g->lattice + 3 * i)) = (uint32_t)i;
  }
  return s;
}

ylm_status ylm__sides_hash(ylm_grid *g) { return ylm__sides_hash_to(g, &g->hash); }
