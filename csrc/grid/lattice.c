/* lattice.c - the hash that finds points by lattice coordinates. */
#include "grid.h"

/* The place of a key, or the free place where it would stand. */
static size_t place(const lattice_hash *h, uint64_t key) {
  size_t i = (size_t)ylm_mix64(key) & (h->size - 1);
  while (h->entry[i].value != YLM_GRID_NONE && h->entry[i].key != key) i = (i + 1) & (h->size - 1);
  return i;
}

ylm_status ylm__lattice_hash_reserve(lattice_hash *h, size_t entries) {
  size_t size = h->size ? h->size : 256;
  while (size < entries * 2 + 16) size *= 2;
  if (size == h->size) return YLM_OK;
  lattice_hash grown = {ylm_alloc(size, sizeof *grown.entry), size, h->used};
  if (!grown.entry) return YLM_ENOMEM;
  for (size_t i = 0; i < size; i++) grown.entry[i].value = YLM_GRID_NONE;
  for (size_t i = 0; i < h->size; i++)
    if (h->entry[i].value != YLM_GRID_NONE)
      grown.entry[place(&grown, h->entry[i].key)] = h->entry[i];
  ylm__lattice_hash_free(h);
  *h = grown;
  return YLM_OK;
}

uint32_t *ylm__lattice_hash_at(lattice_hash *h, uint64_t key) {
  size_t i = place(h, key);
  if (h->entry[i].value == YLM_GRID_NONE) h->used++;
  h->entry[i].key = key;
  return &h->entry[i].value;
}

uint32_t ylm__lattice_hash_find(const lattice_hash *h, uint64_t key) {
  return h->size ? h->entry[place(h, key)].value : YLM_GRID_NONE;
}

void ylm__lattice_hash_prefetch(const lattice_hash *h, uint64_t key) {
  if (h->size) __builtin_prefetch(&h->entry[(size_t)ylm_mix64(key) & (h->size - 1)]);
}

/* Backward-shift deletion: entries behind the gap move into it unless they are where they
   belong. */
void ylm__lattice_hash_remove(lattice_hash *h, uint64_t key) {
  if (!h->size) return;
  size_t mask = h->size - 1, gap = place(h, key);
  if (h->entry[gap].value == YLM_GRID_NONE) return;
  for (size_t i = (gap + 1) & mask; h->entry[i].value != YLM_GRID_NONE; i = (i + 1) & mask) {
    size_t home = (size_t)ylm_mix64(h->entry[i].key) & mask;
    if (((i - home) & mask) < ((i - gap) & mask)) continue;
    h->entry[gap] = h->entry[i];
    gap = i;
  }
  h->entry[gap].value = YLM_GRID_NONE;
  h->used--;
}

void ylm__lattice_hash_free(lattice_hash *h) {
  ylm_free(h->entry);
  *h = (lattice_hash){0};
}
