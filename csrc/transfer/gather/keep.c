/* keep.c - points that are remembered: their cells, by the bits of their position. */
#include "gather.h"

/* All that was seen from a point. */
typedef struct kept {
  float at[3], buried;
  uint32_t cells, splits;
  gather_cell *cell; /* [cells], then `split` [splits] in the same block */
  uint32_t *split;
} kept;

struct gather_memory {
  kept **slot; /* [room], a power of two; NULL: empty */
  size_t room, n, bytes;
  atomic_flag busy;
};

static void lock(struct gather_memory *m) {
  while (atomic_flag_test_and_set_explicit(&m->busy, memory_order_acquire)) {
  }
}
static void unlock(struct gather_memory *m) {
  atomic_flag_clear_explicit(&m->busy, memory_order_release);
}

static uint64_t hash(const float at[3]) {
  uint32_t bits[3];
  memcpy(bits, at, 12);
  uint64_t h = 0x9E3779B97F4A7C15u;
  for (int a = 0; a < 3; a++) {
    h = (h ^ bits[a]) * 0xBF58476D1CE4E5B9u;
    h ^= h >> 29;
  }
  return h;
}

/* Where a point is, or the empty place where it would be. */
static kept **find(kept **slot, size_t room, const float at[3]) {
  size_t i = hash(at) & (room - 1);
  while (slot[i] && memcmp(slot[i]->at, at, 12)) i = (i + 1) & (room - 1);
  return &slot[i];
}

ylm_status ylm__gather_memory_create(struct gather_memory **m) {
  *m = ylm_alloc_zero(1, sizeof **m);
  if (!*m) return YLM_ENOMEM;
  atomic_flag_clear(&(*m)->busy);
  (*m)->room = 64;
  (*m)->slot = ylm_alloc_zero((*m)->room, sizeof *(*m)->slot);
  return (*m)->slot ? YLM_OK : YLM_ENOMEM;
}

static void free_kept(kept *k) {
  if (!k) return;
  ylm_free(k->cell);
  ylm_free(k);
}

void ylm__gather_memory_free(struct gather_memory *m) {
  if (!m) return;
  for (size_t i = 0; m->slot && i < m->room; i++) free_kept(m->slot[i]);
  ylm_free(m->slot);
  ylm_free(m);
}

size_t ylm__gather_memory_bytes(struct gather_memory *m) {
  lock(m);
  size_t bytes = m->bytes;
  unlock(m);
  return bytes;
}

/* Twice as many places where half of them are taken. */
static ylm_status grow(struct gather_memory *m) {
  if (2 * (m->n + 1) <= m->room) return YLM_OK;
  kept **slot = ylm_alloc_zero(2 * m->room, sizeof *slot);
  if (!slot) return YLM_ENOMEM;
  for (size_t i = 0; i < m->room; i++)
    if (m->slot[i]) *find(slot, 2 * m->room, m->slot[i]->at) = m->slot[i];
  ylm_free(m->slot);
  m->slot = slot;
  m->room *= 2;
  return YLM_OK;
}

bool ylm__gather_recall(struct gather_memory *m, gather_sight *v) {
  lock(m);
  const kept *k = *find(m->slot, m->room, v->at);
  unlock(m);
  if (!k) return false;
  v->cells = k->cells;
  v->splits = k->splits;
  v->buried = k->buried;
  memcpy(v->cell, k->cell, k->cells * sizeof *k->cell);
  ylm_copy(v->split, k->split, k->splits * sizeof *k->split);
  for (size_t i = 0; i < v->splits; i++)
    ylm__gather_place_children(v, v->split[i], ylm__gather_children(&v->cell[v->split[i]]));
  return true;
}

ylm_status ylm__gather_keep(struct gather_memory *m, const gather_sight *v) {
  size_t bytes = v->cells * sizeof *v->cell + v->splits * sizeof *v->split;
  kept *k = ylm_alloc(1, sizeof *k);
  gather_cell *cell = ylm_alloc(bytes, 1);
  if (!k || !cell) {
    ylm_free(k);
    ylm_free(cell);
    return YLM_ENOMEM;
  }
  *k = (kept){.buried = v->buried, .cells = (uint32_t)v->cells, .splits = (uint32_t)v->splits};
  memcpy(k->at, v->at, 12);
  k->cell = cell;
  k->split = (uint32_t *)(cell + v->cells);
  memcpy(k->cell, v->cell, v->cells * sizeof *v->cell);
  ylm_copy(k->split, v->split, v->splits * sizeof *v->split);
  lock(m);
  ylm_status s = grow(m);
  kept **to = s == YLM_OK ? find(m->slot, m->room, k->at) : NULL;
  bool isnew = to && !*to;
  if (isnew) {
    *to = k;
    m->n++;
    m->bytes += bytes + sizeof *k;
  }
  unlock(m);
  if (!isnew) free_kept(k);
  return s;
}
