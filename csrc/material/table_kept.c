/* table_kept.c - tables that are kept with their material, one a degree and kind of slice. */
#include "calibration.h"
#include "kind.h"
#include "ylm_material_table.h"

struct material_kept {
  struct material_kept *next;
  int lmax;
  ylm_material_table_slice slice;
  ylm_material_table *table;
};

static const ylm_material_table *find(const struct material_kept *k, int lmax,
                                      ylm_material_table_slice slice) {
  while (k && (k->lmax != lmax || k->slice != slice)) k = k->next;
  return k ? k->table : NULL;
}

ylm_status ylm_material_table_kept_as(const ylm_material *m, ylm_material_table_slice slice,
                                      int lmax, int threads, const ylm_progress *progress,
                                      const ylm_material_table **table, ylm_error *e) {
  /* what is kept is no part of what a material is */
  _Atomic(struct material_kept *) *kept = &((ylm_material *)(uintptr_t)m)->kept;
  struct material_kept *head = atomic_load(kept);
  if ((*table = find(head, lmax, slice))) return YLM_OK;
  ylm_material_table_form form = {.lmax = lmax,
                                  .rows = KEPT_ROWS,
                                  .columns = KEPT_COLUMNS,
                                  .error = KEPT_ERROR,
                                  .slice = slice,
                                  .threads = threads,
                                  .progress = progress};
  struct material_kept *new = ylm_alloc_zero(1, sizeof *new);
  if (!new) return YLM_ENOMEM;
  new->lmax = lmax;
  new->slice = slice;
  ylm_status s = ylm_material_table_create(m, &form, &new->table, e);
  if (s != YLM_OK) {
    ylm_free(new);
    return s;
  }
  do new->next = head; /* one that another thread made in between stays behind it */
  while (!atomic_compare_exchange_weak(kept, &head, new));
  *table = new->table;
  return YLM_OK;
}

ylm_status ylm_material_table_kept(const ylm_material *m, int lmax, int threads,
                                   const ylm_progress *progress, const ylm_material_table **table,
                                   ylm_error *e) {
  return ylm_material_table_kept_as(m, YLM_MATERIAL_TABLE_COSINE, lmax, threads, progress, table,
                                    e);
}

size_t ylm_material_table_kept_bytes(const ylm_material *m) {
  size_t bytes = 0;
  for (const struct material_kept *k = atomic_load(&m->kept); k; k = k->next) {
    ylm_material_table_facts f;
    ylm_material_table_look(k->table, &f);
    bytes += f.bytes;
  }
  return bytes;
}

void ylm__material_free_kept(ylm_material *m) {
  for (struct material_kept *k = atomic_load(&m->kept), *next; k; k = next) {
    next = k->next;
    ylm_material_table_free(k->table);
    ylm_free(k);
  }
}
