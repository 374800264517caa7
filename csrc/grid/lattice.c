/* lattice.c - Morton codes, and the hash that finds points by lattice coordinates. */
#include "grid.h"

/* Spreads 21 bits to every third place. */
static uint64_t spread(uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

uint64_t ylm__morton(uint32_t x, uint32_t y, uint32_t z) {
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}

/* A mixer with full avalanche (the finaliser of SplitMix64, Steele et al. 2014). */
static uint64_t mix(uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

/* The place of a key, or the free place where it would stand. */
static size_t place(const lattice_hash *h, uint64_t key) {
  size_t i = (size_t)mix(key) & (h->size - 1);
  while (h->value[i] != YLM_GRID_NONE && h->key[i] != key) i = (i + 1) & (h->size - 1);
  return i;
}

ylm_status lattice_hash_reserve(lattice_hash *h, size_t entries) {
  size_t size = h->size ? h->size : 256;
  while (size < entries * 2 + 16) size *= 2;
  if (size == h->size) return YLM_OK;
  lattice_hash grown = {ylm_alloc(size, sizeof *grown.key), ylm_alloc(size, sizeof *grown.value),
                        size, h->used};
  if (!grown.key || !grown.value) {
    lattice_hash_free(&grown);
    return YLM_ENOMEM;
  }
  for (size_t i = 0; i < size; i++) grown.value[i] = YLM_GRID_NONE;
  for (size_t i = 0; i < h->size; i++) {
    if (h->value[i] == YLM_GRID_NONE) continue;
    size_t k = place(&grown, h->key[i]);
    grown.key[k] = h->key[i];
    grown.value[k] = h->value[i];
  }
  lattice_hash_free(h);
  *h = grown;
  return YLM_OK;
}

uint32_t *lattice_hash_at(lattice_hash *h, uint64_t key) {
  size_t i = place(h, key);
  if (h->value[i] == YLM_GRID_NONE) h->used++;
  h->key[i] = key;
  return &h->value[i];
}

uint32_t lattice_hash_find(const lattice_hash *h, uint64_t key) {
  return h->size ? h->value[place(h, key)] : YLM_GRID_NONE;
}

/* Backward-shift deletion: entries behind the gap move into it unless they are where they belong.
 */
void lattice_hash_remove(lattice_hash *h, uint64_t key) {
  if (!h->size) return;
  size_t mask = h->size - 1, gap = place(h, key);
  if (h->value[gap] == YLM_GRID_NONE) return;
  for (size_t i = (gap + 1) & mask; h->value[i] != YLM_GRID_NONE; i = (i + 1) & mask) {
    size_t home = (size_t)mix(h->key[i]) & mask;
    if (((i - home) & mask) < ((i - gap) & mask)) continue;
    h->key[gap] = h->key[i];
    h->value[gap] = h->value[i];
    gap = i;
  }
  h->value[gap] = YLM_GRID_NONE;
  h->used--;
}

void lattice_hash_free(lattice_hash *h) {
  ylm_free(h->key);
  ylm_free(h->value);
  *h = (lattice_hash){0};
}
