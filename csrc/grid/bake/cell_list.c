/* cell_list.c - lists of cells. */
#include "baker.h"

ylm_status ylm__cell_list_push(cell_list *l, uint32_t cell) {
  if (l->n == l->room) {
    size_t room = l->room ? l->room * 2 : 64;
    uint32_t *more = ylm_realloc(l->cell, l->n * sizeof *more, room, sizeof *more);
    if (!more) return YLM_ENOMEM;
    l->cell = more;
    l->room = room;
  }
  l->cell[l->n++] = cell;
  return YLM_OK;
}
