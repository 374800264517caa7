/* cells.c - lists of cells; cells under way: the root, children, the next level. */
#include "baker.h"
#include "ylm_list.h"

#include <math.h>
#include <string.h>

ylm_status ylm__cell_list_push(cell_list *l, uint32_t cell) {
  if (!ylm_list_reserve(&l->cell, l->n, l->n + 1, &l->room, sizeof *l->cell)) return YLM_ENOMEM;
  l->cell[l->n++] = cell;
  return YLM_OK;
}

ylm_status ylm__cells_root(baker *b) {
  ylm_grid *g = b->g;
  ylm_status s = ylm__grid_reserve_cells(g, 1);
  if (s != YLM_OK) return s;
  ylm_grid_cell root = {.error = NAN,
                        .residual = NAN,
                        .level = (uint8_t)g->contents.root_level,
                        .flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_CROSSED};
  memcpy(root.origin, g->contents.root, sizeof root.origin);
  for (int k = 0; k < 8; k++) root.corner[k] = YLM_GRID_NONE;
  g->cell[g->cells++] = root;
  return ylm__cell_list_push(&b->wave, 0);
}

ylm_status ylm__cells_split(baker *b, uint32_t cell) {
  ylm_grid *g = b->g;
  uint32_t first;
  ylm_status s = ylm__grid_split(g, cell, &first);
  if (s == YLM_OK) s = ylm__cell_list_push(&b->parent, cell);
  if (s != YLM_OK) return s;
  const ylm_grid_cell *old = cells_before(b, &g->cell[cell]);
  if (old && old->flags & YLM_GRID_LEAF) old = NULL; /* it had none, or for continuity only */
  g->cell[cell].flags &= (uint8_t)~YLM_GRID_LEAF;
  uint8_t occupied =
      ylm__occupancy_children(&b->learnt.occupied, g->cell[cell].level, g->cell[cell].origin);
  for (uint32_t k = first; k < first + 8; k++) {
    ylm_grid_cell *c = &g->cell[k];
    c->flags = YLM_GRID_LEAF;
    if (b->before) c->source = old ? old->child + (k - first) : YLM_GRID_NONE;
    if (!(occupied >> (k - first) & 1)) continue;
    c->flags |= YLM_GRID_OCCUPIED | (g->cell[cell].flags & YLM_GRID_CROSSED);
    s = ylm__cell_list_push(&b->next, k);
    if (s != YLM_OK) return s;
  }
  return YLM_OK;
}

void ylm__cells_advance(baker *b) {
  cell_list spent = b->wave;
  b->wave = b->next;
  b->next = spent;
  b->next.n = 0;
}
