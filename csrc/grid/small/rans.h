/*
** rans.h - whole numbers by static tables of frequencies.
**
** Numbers up to RANS_MOST in size are symbols; larger ones are a symbol for their number of bits, and raw bits. Four states
** take turns. Arithmetic is of whole numbers.
** Source   asymmetric numeral systems: Duda 2014
*/
#ifndef YLM_GRID_SMALL_RANS_H
#define YLM_GRID_SMALL_RANS_H

#include <string.h>

#include "coder.h"

#define RANS_TABLES 64 /* table 0: all numbers are 0, and nothing is coded */
#define RANS_SYMBOLS 32
#define RANS_MOST 10
#define RANS_LONG 10 /* the last symbol's: its size has RANS_LONG_BITS bits */
#define RANS_LONG_BITS 25
#define RANS_BITS 11 /* of frequencies */
#define RANS_SUM (1u << RANS_BITS)
#define RANS_STATES 4

/* -- symbols ------------------------------------------------------------------------------------ */

/* The symbol of a number; bits that follow it raw, their number through *more. */
static inline uint32_t rans_symbol(int32_t q, int *more, uint32_t *bits) {
  *more = 0;
  if (q >= -RANS_MOST && q <= RANS_MOST) return (uint32_t)(q + RANS_MOST);
  uint32_t size = (uint32_t)(q < 0 ? -(int64_t)q : q) - RANS_MOST; /* at least 1 */
  int k = 31 - __builtin_clz(size);
  if (k > RANS_LONG) k = RANS_LONG;
  *more = k < RANS_LONG ? k + 1 : RANS_LONG_BITS;
  *bits = (size - (1u << k)) << 1 | (q < 0);
  return (uint32_t)(2 * RANS_MOST + 1 + k);
}
#define RANS_LARGEST ((1 << (RANS_LONG_BITS - 1)) - 1)

/* -- encoding ------------------------------------------------------------------------------------ */

/* A symbol with its table, in the order of coding; one for each number that is not of table 0. */
typedef struct rans_item {
  uint8_t table, symbol;
} rans_item;

typedef struct rans_writer {
  rans_item *item;
  size_t n, room;
  unsigned char *raw; /* bits, lowest first */
  size_t raw_room;
  uint64_t raw_bits;
  bool failed;
} rans_writer;
void ylm__rans_put(rans_writer *w, uint8_t table, int32_t q);
/* Frequencies of the sum RANS_SUM; what occurs has at least 1. */
void ylm__rans_count(const uint64_t count[RANS_SYMBOLS], uint16_t frequency[RANS_SYMBOLS]);
/* The stream of all items (ylm_free). */
ylm_status ylm__rans_end(const rans_writer *w, uint16_t (*frequency)[RANS_SYMBOLS],
                         unsigned char **data, size_t *size);
void ylm__rans_free(rans_writer *w);

/* -- decoding ------------------------------------------------------------------------------------ */

typedef struct rans_reader {
  uint32_t (*slot)[RANS_SUM]; /* [RANS_TABLES] symbol, frequency, place within it */
  uint32_t state[RANS_STATES];
  const unsigned char *in, *raw;
  size_t size, at, raw_size;
  uint64_t raw_at; /* in bits */
  bool bad;        /* the stream ended early */
} rans_reader;
/* Bytes behind a stream that must be there, where so many numbers are taken between two looks at rans_is_short. */
#define RANS_BEHIND(numbers) (2 * (size_t)(numbers) + 2)
/* Tables [RANS_TABLES]; false: a sum is not RANS_SUM (but for 0, of a table that nothing may be taken by). */
bool ylm__rans_tables(rans_reader *r, uint16_t (*frequency)[RANS_SYMBOLS]);
void ylm__rans_begin(rans_reader *r, const unsigned char *in, size_t size, const unsigned char *raw,
                     size_t raw_size);
/* Whether all was read, to the bit. */
bool ylm__rans_is_done(const rans_reader *r);

static inline bool rans_is_short(const rans_reader *r) { return r->at > r->size || r->bad; }

static inline uint32_t rans_raw(rans_reader *r, int n) {
  uint32_t out = 0;
  for (int i = 0; i < n; i++, r->raw_at++) {
    if (r->raw_at >= 8 * (uint64_t)r->raw_size) {
      r->bad = true;
      return 0;
    }
    out |= (uint32_t)(r->raw[r->raw_at / 8] >> r->raw_at % 8 & 1) << i;
  }
  return out;
}

/* The number of a symbol beyond RANS_MOST. */
static inline int32_t rans_long(rans_reader *r, uint32_t symbol) {
  int k = (int)symbol - 2 * RANS_MOST - 1;
  uint32_t bits = rans_raw(r, k < RANS_LONG ? k + 1 : RANS_LONG_BITS);
  int32_t size = (int32_t)((1u << k) + (bits >> 1) + RANS_MOST);
  return bits & 1 ? -size : size;
}

/* One symbol. The states take turns: the next is the first. The stream may be read up to two bytes for each number beyond its
   end: rans_is_short says so afterwards. */
static inline uint32_t rans_take(rans_reader *r, const uint32_t *slots) {
  uint32_t x = r->state[0], slot = slots[x & (RANS_SUM - 1)], symbol = slot & 31,
           frequency = slot >> 5 & 0xfff;
  uint16_t word;
  memcpy(&word, r->in + r->at, sizeof word); /* files are little-endian, as the machine is */
  x = frequency * (x >> RANS_BITS) + (slot >> 17);
  size_t more = x < 1u << 16;
  x = more ? x << 16 | word : x;
  r->at += 2 * more;
  for (int i = 1; i < RANS_STATES; i++) r->state[i - 1] = r->state[i];
  r->state[RANS_STATES - 1] = x;
  return symbol;
}

#endif
