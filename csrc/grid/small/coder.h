/*
** coder.h - bits with adaptive probabilities, as a stream of bytes.
**
** One walk over the data serves both directions: a call encodes its last argument, or ignores it and returns what was
** decoded. Arithmetic is of whole numbers, so streams are the same on every machine. A stream that ends early is read on as
** zeros, and `short_by` counts them.
** Source   range coding: Martin 1979; probabilities are means of a quick and a slow estimate
*/
#ifndef YLM_GRID_SMALL_CODER_H
#define YLM_GRID_SMALL_CODER_H

#include "ylm_base.h"

#define CODER_EVEN 0x8000u
#define CODER_QUICK 4
#define CODER_SLOW 7
#define CODER_LEAST 256u     /* of 65,536: what never came; no bit costs less than a 180th of one */
#define CODER_TOP (1u << 24) /* a range below it takes another byte */

/* The chance of a 0, twice, of 65,536. Zeroed memory is no estimate: coder_chances. */
typedef struct bit_chance {
  uint16_t quick, slow;
} bit_chance;

typedef struct bit_coder {
  bool decoding, failed; /* failed: memory ran out */
  unsigned char *out;    /* [n] of `room`, the encoder's (ylm_free) */
  size_t n, room;
  uint64_t low;
  uint32_t range, code;
  size_t held; /* bytes 0xff behind `last` that a carry would change; 0: there is no last */
  uint8_t last;
  const unsigned char *in; /* [size] */
  size_t size, at, short_by;
} bit_coder;

void ylm__coder_encode(bit_coder *c);
void ylm__coder_decode(bit_coder *c, const unsigned char *in, size_t size);
/* Writes what is left. YLM_ENOMEM where memory ran out on the way. */
ylm_status ylm__coder_end(bit_coder *c);
/* n estimates become even. */
void ylm__coder_even(bit_chance *p, size_t n);

/* A bit, by an estimate; by the mean of two. */
int ylm__coder_bit(bit_coder *c, bit_chance *p, int bit);
int ylm__coder_bit_of(bit_coder *c, bit_chance *p, bit_chance *q, int bit);
/* n <= 32 bits, all alike. */
uint32_t ylm__coder_raw(bit_coder *c, int n, uint32_t bits);
/* A number below 2^n, highest bit first; estimates [2^n]. */
uint32_t ylm__coder_symbol(bit_coder *c, bit_chance *p, int n, uint32_t symbol);
/* ylm__coder_symbol by the mean of two sets of estimates. */
uint32_t ylm__coder_symbol_of(bit_coder *c, bit_chance *p, bit_chance *q, int n, uint32_t symbol);
/* Any number below 2^31: the number of its bits, then these; estimates [64]. */
uint32_t ylm__coder_number(bit_coder *c, bit_chance *p, uint32_t number);
/* A number of either sign, above -2^30 and below 2^30. */
int32_t ylm__coder_signed(bit_coder *c, bit_chance *p, int32_t number);

#endif
