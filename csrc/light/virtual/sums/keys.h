/* keys.h - a table of keys, numbered in the order in which they come. Private to the folder. */
#ifndef YLM_LIGHT_VIRTUAL_KEYS_H
#define YLM_LIGHT_VIRTUAL_KEYS_H

#include <string.h>

#include "ylm_base.h"

enum { YLM__KEY = 6 };

/* A place on a lattice, and what else tells two apart. */
typedef struct ylm__key {
  int32_t of[YLM__KEY];
} ylm__key;

typedef struct ylm__keys {
  size_t n, room, slots; /* slots: a power of two */
  ylm__key *key;         /* [room] */
  uint32_t *slot;        /* [slots] a key's number + 1, or 0 */
} ylm__keys;

static inline uint64_t ylm__key_hash(const ylm__key *k) {
  uint64_t x = 0;
  for (int i = 0; i < YLM__KEY; i++) {
    x = (x ^ (uint32_t)k->of[i]) * 0x9e3779b97f4a7c15u;
    x ^= x >> 29;
  }
  return x ^ x >> 32;
}

static inline void ylm__keys_free(ylm__keys *t) {
  ylm_free(t->key);
  ylm_free(t->slot);
  *t = (ylm__keys){0};
}

/* Where a key is, or is to be. */
static inline size_t ylm__keys_slot(const ylm__keys *t, const ylm__key *k) {
  size_t at = (size_t)ylm__key_hash(k) & (t->slots - 1);
  while (t->slot[at] && memcmp(&t->key[t->slot[at] - 1], k, sizeof *k) != 0)
    at = (at + 1) & (t->slots - 1);
  return at;
}

/* Its number; UINT32_MAX: it is not there. */
static inline uint32_t ylm__keys_find(const ylm__keys *t, const ylm__key *k) {
  return t->slots ? t->slot[ylm__keys_slot(t, k)] - 1 : UINT32_MAX;
}

/* Room for as many as there are again. */
static inline ylm_status ylm__keys_grow(ylm__keys *t) {
  size_t room = t->room ? 2 * t->room : 1024;
  ylm__key *key = ylm_alloc(room, sizeof *key);
  uint32_t *slot = ylm_alloc_zero(2 * room, sizeof *slot);
  if (!key || !slot || room > UINT32_MAX / 2) {
    ylm_free(key);
    ylm_free(slot);
    return YLM_ENOMEM;
  }
  ylm_copy(key, t->key, t->n * sizeof *key);
  ylm_free(t->key);
  ylm_free(t->slot);
  t->key = key, t->slot = slot, t->room = room, t->slots = 2 * room;
  for (size_t i = 0; i < t->n; i++) t->slot[ylm__keys_slot(t, &key[i])] = (uint32_t)i + 1;
  return YLM_OK;
}

/* Its number, a new one where it is not there. YLM_ENOMEM. */
static inline ylm_status ylm__keys_put(ylm__keys *t, const ylm__key *k, uint32_t *number) {
  if (t->n == t->room) {
    ylm_status s = ylm__keys_grow(t);
    if (s != YLM_OK) return s;
  }
  size_t at = ylm__keys_slot(t, k);
  if (!t->slot[at]) {
    t->key[t->n++] = *k;
    t->slot[at] = (uint32_t)t->n;
  }
  *number = t->slot[at] - 1;
  return YLM_OK;
}

#endif
