/* coder.c - bits with adaptive probabilities, as a stream of bytes. */
#include "coder.h"

#include <string.h>

#include "ylm_list.h"

#define CARRY_BITS 32
#define NUMBER_BITS 5

void ylm__coder_encode(bit_coder *c) { *c = (bit_coder){.range = UINT32_MAX}; }

static uint32_t next_byte(bit_coder *c) {
  if (c->at < c->size) return c->in[c->at++];
  c->short_by++;
  return 0;
}

void ylm__coder_decode(bit_coder *c, const unsigned char *in, size_t size) {
  *c = (bit_coder){.decoding = true, .range = UINT32_MAX, .in = in, .size = size};
  for (int i = 0; i < 4; i++) c->code = c->code << 8 | next_byte(c);
}

static void put_byte(bit_coder *c, uint8_t byte) {
  if (!ylm_list_reserve(&c->out, c->n, c->n + 1, &c->room, 1)) {
    c->failed = true;
    return;
  }
  c->out[c->n++] = byte;
}

/* The highest byte of `low` leaves, as soon as no carry can change it. */
static void shift_low(bit_coder *c) {
  uint8_t carry = (uint8_t)(c->low >> CARRY_BITS), byte = (uint8_t)(c->low >> 24);
  if (carry || byte != 0xff || !c->held) {
    if (c->held) put_byte(c, (uint8_t)(c->last + carry));
    for (; c->held > 1; c->held--) put_byte(c, (uint8_t)(0xff + carry));
    c->held = 0;
    c->last = byte;
  }
  c->held++;
  c->low = (c->low & (CODER_TOP - 1)) << 8;
}

ylm_status ylm__coder_end(bit_coder *c) {
  for (int i = 0; i < 5; i++) shift_low(c);
  return c->failed ? YLM_ENOMEM : YLM_OK;
}

void ylm__coder_even(bit_chance *p, size_t n) {
  for (size_t i = 0; i < n; i++) p[i] = (bit_chance){CODER_EVEN, CODER_EVEN};
}

static void learn(bit_chance *p, int bit) {
  if (bit) {
    p->quick = (uint16_t)(p->quick - (p->quick >> CODER_QUICK));
    p->slow = (uint16_t)(p->slow - (p->slow >> CODER_SLOW));
  } else {
    p->quick = (uint16_t)(p->quick + ((65535u - p->quick) >> CODER_QUICK));
    p->slow = (uint16_t)(p->slow + ((65535u - p->slow) >> CODER_SLOW));
  }
}

/* A bit whose chance of being 0 is `zero` of 65,536. */
static int code_bit(bit_coder *c, uint32_t zero, int bit) {
  if (zero < CODER_LEAST) zero = CODER_LEAST;
  if (zero > 65536u - CODER_LEAST) zero = 65536u - CODER_LEAST;
  uint32_t bound = (c->range >> 16) * zero;
  if (c->decoding) bit = c->code >= bound;
  if (bit) {
    c->range -= bound;
    if (c->decoding)
      c->code -= bound;
    else
      c->low += bound;
  } else
    c->range = bound;
  while (c->range < CODER_TOP) {
    c->range <<= 8;
    if (c->decoding)
      c->code = c->code << 8 | next_byte(c);
    else
      shift_low(c);
  }
  return bit;
}

int ylm__coder_bit(bit_coder *c, bit_chance *p, int bit) {
  bit = code_bit(c, ((uint32_t)p->quick + p->slow) / 2, bit);
  learn(p, bit);
  return bit;
}

int ylm__coder_bit_of(bit_coder *c, bit_chance *p, bit_chance *q, int bit) {
  bit = code_bit(c, ((uint32_t)p->quick + p->slow + q->quick + q->slow) / 4, bit);
  learn(p, bit);
  learn(q, bit);
  return bit;
}

uint32_t ylm__coder_raw(bit_coder *c, int n, uint32_t bits) {
  uint32_t out = 0;
  for (int i = n - 1; i >= 0; i--)
    out = out << 1 | (uint32_t)code_bit(c, CODER_EVEN, bits >> i & 1);
  return out;
}

uint32_t ylm__coder_symbol(bit_coder *c, bit_chance *p, int n, uint32_t symbol) {
  uint32_t node = 1;
  for (int i = n - 1; i >= 0; i--)
    node = node << 1 | (uint32_t)ylm__coder_bit(c, &p[node], symbol >> i & 1);
  return node - (1u << n);
}

uint32_t ylm__coder_symbol_of(bit_coder *c, bit_chance *p, bit_chance *q, int n, uint32_t symbol) {
  uint32_t node = 1;
  for (int i = n - 1; i >= 0; i--)
    node = node << 1 | (uint32_t)ylm__coder_bit_of(c, &p[node], &q[node], symbol >> i & 1);
  return node - (1u << n);
}

/* Numbers are coded one higher: 1 has one bit, and the highest is known. The first of the rest has an estimate of its own. */
uint32_t ylm__coder_number(bit_coder *c, bit_chance *p, uint32_t number) {
  uint32_t more = number + 1;
  int bits = c->decoding ? 0 : 31 - __builtin_clz(more);
  bits = (int)ylm__coder_symbol(c, p, NUMBER_BITS, (uint32_t)bits);
  if (bits > 30) bits = 30; /* of a damaged stream */
  uint32_t out = 1;
  if (bits) out = 2 | (uint32_t)ylm__coder_bit(c, &p[32 + bits], (int)(more >> (bits - 1) & 1));
  for (int i = bits - 2; i >= 0; i--) out = out << 1 | ylm__coder_raw(c, 1, more >> i & 1);
  return out - 1;
}

int32_t ylm__coder_signed(bit_coder *c, bit_chance *p, int32_t number) {
  uint32_t folded = number < 0 ? 2 * (uint32_t)-number - 1 : 2 * (uint32_t)number;
  folded = ylm__coder_number(c, p, folded);
  return folded & 1 ? -(int32_t)(folded / 2) - 1 : (int32_t)(folded / 2);
}
