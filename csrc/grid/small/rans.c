/* rans.c - whole numbers by static tables of frequencies. */
#include "rans.h"

#include <string.h>

#include "ylm_list.h"

#define LEAST_STATE (1u << 16)

static void put_raw(rans_writer *w, int n, uint32_t bits) {
  size_t bytes = (size_t)((w->raw_bits + (uint64_t)n + 7) / 8);
  if (!ylm_list_reserve(&w->raw, (size_t)((w->raw_bits + 7) / 8), bytes, &w->raw_room, 1)) {
    w->failed = true;
    return;
  }
  for (int i = 0; i < n; i++, w->raw_bits++) {
    size_t at = (size_t)(w->raw_bits / 8);
    if (w->raw_bits % 8 == 0) w->raw[at] = 0;
    w->raw[at] |= (unsigned char)((bits >> i & 1) << w->raw_bits % 8);
  }
}

void ylm__rans_put(rans_writer *w, uint8_t table, int32_t q) {
  int more;
  uint32_t bits = 0;
  if (!ylm_list_reserve(&w->item, w->n, w->n + 1, &w->room, sizeof *w->item)) {
    w->failed = true;
    return;
  }
  w->item[w->n++] = (rans_item){table, (uint8_t)rans_symbol(q, &more, &bits)};
  if (more) put_raw(w, more, bits);
}

void ylm__rans_free(rans_writer *w) {
  ylm_free(w->item);
  ylm_free(w->raw);
  *w = (rans_writer){0};
}

void ylm__rans_count(const uint64_t count[RANS_SYMBOLS], uint16_t frequency[RANS_SYMBOLS]) {
  uint64_t sum = 0;
  uint32_t given = 0;
  int most = 0;
  for (int i = 0; i < RANS_SYMBOLS; i++) sum += count[i];
  for (int i = 0; i < RANS_SYMBOLS; i++) {
    uint64_t share = sum ? count[i] * RANS_SUM / sum : 0;
    if (count[i] && !share) share = 1;
    frequency[i] = (uint16_t)share;
    given += frequency[i];
    if (count[i] > count[most]) most = i;
  }
  if (!sum) return;
  /* The rest that rounding has left is the most frequent one's; where that has too little, others give one each. */
  int32_t rest = (int32_t)RANS_SUM - (int32_t)given;
  if ((int32_t)frequency[most] + rest >= 1) {
    frequency[most] = (uint16_t)((int32_t)frequency[most] + rest);
    return;
  }
  for (int i = 0; rest < 0; i = (i + 1) % RANS_SYMBOLS)
    if (frequency[i] > 1) frequency[i]--, rest++;
}

ylm_status ylm__rans_end(const rans_writer *w, uint16_t (*frequency)[RANS_SYMBOLS],
                         unsigned char **data, size_t *size) {
  uint32_t start[RANS_TABLES][RANS_SYMBOLS], state[RANS_STATES];
  size_t room = 2 * w->n + 4 * RANS_STATES, at = room;
  unsigned char *out = ylm_alloc(room, 1);
  *data = NULL;
  if (!out || w->failed) {
    ylm_free(out);
    return YLM_ENOMEM;
  }
  for (int t = 0; t < RANS_TABLES; t++)
    for (uint32_t i = 0, sum = 0; i < RANS_SYMBOLS; sum += frequency[t][i++]) start[t][i] = sum;
  for (int i = 0; i < RANS_STATES; i++) state[i] = LEAST_STATE;
  for (size_t i = w->n; i-- > 0;) { /* the reader takes last what is put first */
    const rans_item *item = &w->item[i];
    uint32_t f = frequency[item->table][item->symbol], *x = &state[i % RANS_STATES];
    if ((uint64_t)*x >= (uint64_t)f << (32 - RANS_BITS)) {
      out[--at] = (unsigned char)(*x >> 8);
      out[--at] = (unsigned char)*x;
      *x >>= 16;
    }
    *x = (*x / f << RANS_BITS) + *x % f + start[item->table][item->symbol];
  }
  for (int i = RANS_STATES - 1; i >= 0; i--)
    for (int k = 3; k >= 0; k--) out[--at] = (unsigned char)(state[i] >> 8 * k);
  *size = room - at;
  memmove(out, out + at, *size);
  *data = out;
  return YLM_OK;
}

bool ylm__rans_tables(rans_reader *r, uint16_t (*frequency)[RANS_SYMBOLS]) {
  for (int t = 0; t < RANS_TABLES; t++) {
    uint32_t sum = 0;
    for (int i = 0; i < RANS_SYMBOLS; i++) {
      if (frequency[t][i] > RANS_SUM - sum) return false;
      for (uint32_t k = 0; k < frequency[t][i]; k++)
        r->slot[t][sum + k] = (uint32_t)i | (uint32_t)frequency[t][i] << 5 | k << 17;
      sum += frequency[t][i];
    }
    if (sum != RANS_SUM && sum) return false;
  }
  return true;
}

void ylm__rans_begin(rans_reader *r, const unsigned char *in, size_t size, const unsigned char *raw,
                     size_t raw_size) {
  r->in = in;
  r->size = size;
  r->raw = raw;
  r->raw_size = raw_size;
  r->raw_at = 0;
  r->bad = size < 4 * RANS_STATES;
  for (size_t i = 0; !r->bad && i < RANS_STATES; i++) {
    r->state[i] = 0;
    for (size_t k = 0; k < 4; k++) r->state[i] |= (uint32_t)in[4 * i + k] << 8 * k;
  }
  r->at = 4 * RANS_STATES;
}

bool ylm__rans_is_done(const rans_reader *r) {
  bool done = !r->bad && r->at == r->size && (r->raw_at + 7) / 8 == r->raw_size;
  for (int i = 0; i < RANS_STATES; i++) done &= r->state[i] == LEAST_STATE;
  return done;
}
