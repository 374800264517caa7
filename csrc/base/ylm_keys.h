/*
** ylm_keys.h - a table of keys of one size, numbered in the order in which they come.
**
** A hash table with open addressing. What belongs to a key stands in an array of its owner's, at the
** key's number. Numbers depend on the order of keys alone, so results that follow them do too.
** `size`, the bytes of a key, is a multiple of 4 and the same in all calls for a table; keys are
** alike where all their bytes are, those between their fields included.
**
**   ylm_keys places = {0};
**   uint32_t number;
**   ylm_status s = ylm_keys_put(&places, at, sizeof at, &number);
**   ...
**   ylm_keys_free(&places);
*/
#ifndef YLM_KEYS_H
#define YLM_KEYS_H

#include "ylm_base.h"
#include "ylm_list.h"

typedef struct ylm_keys {
  size_t n, room, slots; /* slots: a power of two */
  void *key;             /* [room][size] */
  uint32_t *slot;        /* [slots] a key's number + 1, or 0 */
} ylm_keys;

static inline uint64_t ylm_keys_hash(const void *key, size_t size) {
  uint64_t x = 0;
  for (size_t i = 0; i < size; i += 4) {
    uint32_t word;
    memcpy(&word, (const char *)key + i, 4);
    x = (x ^ word) * 0x9e3779b97f4a7c15u;
    x ^= x >> 29;
  }
  return x ^ x >> 32;
}

static inline void ylm_keys_free(ylm_keys *t) {
  ylm_free(t->key);
  ylm_free(t->slot);
  *t = (ylm_keys){0};
}

/* Forgets all keys, and keeps their room. */
static inline void ylm_keys_clear(ylm_keys *t) {
  ylm_zero(t->slot, t->slots * sizeof *t->slot);
  t->n = 0;
}

/* The key of a number. */
static inline const void *ylm_keys_at(const ylm_keys *t, size_t number, size_t size) {
  return (const char *)t->key + number * size;
}

/* The slot where a key is, or is to be. */
static inline size_t ylm_keys_slot(const ylm_keys *t, const void *key, size_t size) {
  size_t at = (size_t)ylm_keys_hash(key, size) & (t->slots - 1);
  while (t->slot[at] && memcmp(ylm_keys_at(t, t->slot[at] - 1, size), key, size) != 0)
    at = (at + 1) & (t->slots - 1);
  return at;
}

/* A key's number; UINT32_MAX: it is not there. */
static inline uint32_t ylm_keys_find(const ylm_keys *t, const void *key, size_t size) {
  return t->slots ? t->slot[ylm_keys_slot(t, key, size)] - 1 : UINT32_MAX;
}

/* Room for n keys. False: memory ran out, or there are 2^31 or more. */
static inline bool ylm_keys_reserve(ylm_keys *t, size_t n, size_t size) {
  size_t slots = t->slots ? t->slots : 64;
  if (n <= t->room) return true;
  if (n > INT32_MAX || !ylm_list_reserve(&t->key, t->n, n, &t->room, size)) return false;
  while (slots < 2 * t->room) slots *= 2;
  if (slots == t->slots) return true;
  uint32_t *slot = ylm_alloc_zero(slots, sizeof *slot);
  if (!slot) {
    t->room = t->slots / 2;
    return false;
  }
  ylm_free(t->slot);
  t->slot = slot, t->slots = slots;
  for (size_t i = 0; i < t->n; i++)
    slot[ylm_keys_slot(t, ylm_keys_at(t, i, size), size)] = (uint32_t)i + 1;
  return true;
}

/* A key's number, a new one where it is not there. YLM_ENOMEM. */
static inline ylm_status ylm_keys_put(ylm_keys *t, const void *key, size_t size, uint32_t *number) {
  if (!ylm_keys_reserve(t, t->n + 1, size)) return YLM_ENOMEM;
  size_t at = ylm_keys_slot(t, key, size);
  if (!t->slot[at]) {
    memcpy((char *)t->key + t->n * size, key, size);
    t->slot[at] = (uint32_t)++t->n;
  }
  *number = t->slot[at] - 1;
  return YLM_OK;
}

#endif
