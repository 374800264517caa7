/* cell_list.c - lists of cells. */
#include "baker.h"
#include "ylm_list.h"

ylm_status ylm__cell_list_push(cell_list *l, uint32_t cell) {
  if (!ylm_list_reserve(&l->cell, l->n, l->n + 1, &l->room, sizeof *l->cell)) return YLM_ENOMEM;
  l->cell[l->n++] = cell;
  return YLM_OK;
}
