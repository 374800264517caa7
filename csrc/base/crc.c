/*
** crc.c - CRC-64/XZ: by carry-less products of a processor that has them, else sixteen bytes at a time by tables.
**
** Numbers are reflected: bit 63 of a remainder is x^0, so that the first byte of a message has its highest powers. A message of
** 16-byte blocks keeps its remainder where a block A = (a, b) is replaced by a x^(d+64) + b x^d, added to the block d bits
** further on (Gopal et al. 2009). The last block goes through the tables.
*/
#include "ylm_crc.h"

#include <pthread.h>

#if defined(__x86_64__)
#include <immintrin.h>
#define FOLDS 1
#else
#define FOLDS 0
#endif

#define SLICES 16
#define POLYNOMIAL 0xC96C5795D7870F42u /* of ECMA-182, reflected */

/* table[k][b]: what byte b does to the remainder once k more bytes have followed it. */
static uint64_t table[SLICES][256];

/* The product of a remainder and x. */
static uint64_t times_x(uint64_t c) { return c & 1 ? c >> 1 ^ POLYNOMIAL : c >> 1; }

static void fill_table(void) {
  for (uint64_t i = 0; i < 256; i++) {
    uint64_t c = i;
    for (int bit = 0; bit < 8; bit++) c = times_x(c);
    table[0][i] = c;
  }
  for (int k = 1; k < SLICES; k++)
    for (int i = 0; i < 256; i++)
      table[k][i] = table[k - 1][i] >> 8 ^ table[0][table[k - 1][i] & 255];
}

/* Eight bytes as a number, the first the lowest. */
static uint64_t eight(const unsigned char *p) {
  uint64_t x;
  memcpy(&x, p, sizeof x);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
  x = __builtin_bswap64(x);
#endif
  return x;
}

/* The remainder of one that more bytes follow. */
static uint64_t follow(uint64_t crc, const unsigned char *p, size_t size) {
  for (; size >= SLICES; size -= SLICES, p += SLICES) {
    uint64_t low = crc ^ eight(p), high = eight(p + 8), sum = 0;
    for (int k = 0; k < 8; k++)
      sum ^= table[15 - k][low >> 8 * k & 255] ^ table[7 - k][high >> 8 * k & 255];
    crc = sum;
  }
  for (; size; size--) crc = crc >> 8 ^ table[0][(crc ^ *p++) & 255];
  return crc;
}

/* -- by carry-less products -------------------------------------------------------------------- */

#if FOLDS
#define LANES 8
#define STEP (16 * LANES)   /* bytes; as many are folded at least */
#define WIDE 4              /* registers of four blocks */
#define FARTHEST (4 * WIDE) /* blocks that a fold goes over */

/* Factors of a fold over so many blocks: x^(d+63), x^(d-1), since a reflected product is one power too high. */
static uint64_t factor[FARTHEST + 1][2];

static void fill_factors(void) {
  uint64_t c = (uint64_t)1 << 63; /* x^0 */
  for (int power = 1; power < 128 * FARTHEST + 64; power++) {
    c = times_x(c);
    if ((power + 1) % 128 == 0) factor[(power + 1) / 128][1] = c;
    if (power > 128 && (power - 63) % 128 == 0) factor[(power - 63) / 128][0] = c;
  }
}

/* A block, moved over `by` blocks and added to one. */
__attribute__((target("pclmul"))) static inline __m128i fold(__m128i block, int by, __m128i to) {
  __m128i f = _mm_loadu_si128((const __m128i *)(const void *)factor[by]);
  __m128i a = _mm_clmulepi64_si128(block, f, 0x00), b = _mm_clmulepi64_si128(block, f, 0x11);
  return _mm_xor_si128(to, _mm_xor_si128(a, b));
}

/* As follow; at least STEP bytes. */
__attribute__((target("pclmul"))) static uint64_t
follow_folded(uint64_t crc, const unsigned char *p, size_t size) {
  __m128i lane[LANES];
  unsigned char last[16];
  for (int i = 0; i < LANES; i++) lane[i] = _mm_loadu_si128((const __m128i *)(const void *)p + i);
  lane[0] = _mm_xor_si128(lane[0], _mm_cvtsi64_si128((long long)crc));
  for (p += STEP, size -= STEP; size >= STEP; p += STEP, size -= STEP)
    for (int i = 0; i < LANES; i++)
      lane[i] = fold(lane[i], LANES, _mm_loadu_si128((const __m128i *)(const void *)p + i));
  for (int i = 0; i < LANES - 1; i++)
    lane[LANES - 1] = fold(lane[i], LANES - 1 - i, lane[LANES - 1]);
  _mm_storeu_si128((__m128i *)(void *)last, lane[LANES - 1]);
  return follow(follow(0, last, sizeof last), p, size);
}

#define WITH_WIDE __attribute__((target("pclmul,vpclmulqdq,avx512f,avx512dq")))

/* Four blocks, moved over FARTHEST and added to four. */
WITH_WIDE static inline __m512i fold_wide(__m512i blocks, __m512i by, __m512i to) {
  __m512i a = _mm512_clmulepi64_epi128(blocks, by, 0x00),
          b = _mm512_clmulepi64_epi128(blocks, by, 0x11);
  return _mm512_ternarylogic_epi64(a, b, to, 0x96);
}

/* As follow_folded, of 64 * WIDE bytes at least; *bad gets bits where a float is not finite, but for those behind the last
   whole 64 * WIDE bytes. */
WITH_WIDE static uint64_t follow_wide(uint64_t crc, const unsigned char *p, size_t size,
                                      unsigned *bad) {
  enum { QNAN = 0x01, INFINITE = 0x08, NEGATIVE = 0x10, SNAN = 0x80 };
  __m512i lane[WIDE],
      by = _mm512_broadcast_i32x4(_mm_loadu_si128((const __m128i *)(const void *)factor[FARTHEST]));
  __mmask16 seen = 0;
  unsigned char last[64 * WIDE];
  for (int i = 0; i < WIDE; i++) {
    lane[i] = _mm512_loadu_si512(p + 64 * i);
    seen |= _mm512_fpclass_ps_mask(_mm512_castsi512_ps(lane[i]), QNAN | INFINITE | NEGATIVE | SNAN);
  }
  lane[0] = _mm512_xor_si512(lane[0], _mm512_zextsi128_si512(_mm_cvtsi64_si128((long long)crc)));
  for (p += sizeof last, size -= sizeof last; size >= sizeof last;
       p += sizeof last, size -= sizeof last)
    for (int i = 0; i < WIDE; i++) {
      __m512i next = _mm512_loadu_si512(p + 64 * i);
      seen |= _mm512_fpclass_ps_mask(_mm512_castsi512_ps(next), QNAN | INFINITE | NEGATIVE | SNAN);
      lane[i] = fold_wide(lane[i], by, next);
    }
  for (int i = 0; i < WIDE; i++) _mm512_storeu_si512(last + 64 * i, lane[i]);
  *bad |= seen;
  crc = follow_folded(0, last, sizeof last);
  return size >= STEP ? follow_folded(crc, p, size) : follow(crc, p, size);
}

/* The table's sums are asked for with YLM_ISA=sse2 and reference. */
static bool has_products(void) {
  return ylm_isa_current() >= YLM_ISA_avx2 && __builtin_cpu_supports("pclmul");
}

static bool has_wide(void) {
  return ylm_isa_current() >= YLM_ISA_avx512 && __builtin_cpu_supports("vpclmulqdq");
}

static bool by_products, by_wide;
#endif

static void begin(void) {
  fill_table();
#if FOLDS
  fill_factors();
  by_products = has_products();
  by_wide = by_products && has_wide();
#endif
}

static void ready(void) {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  pthread_once(&once, begin);
}

uint64_t ylm_crc64(uint64_t crc, const void *data, size_t size) {
  ready();
#if FOLDS
  unsigned any = 0;
  if (by_wide && size >= 64 * WIDE) return ~follow_wide(~crc, data, size, &any);
  if (by_products && size >= STEP) return ~follow_folded(~crc, data, size);
#endif
  return ~follow(~crc, data, size);
}

uint64_t ylm_crc64_floats(uint64_t crc, const void *data, size_t size, bool *finite) {
  ready();
#if FOLDS
  unsigned bad = 0;
  if (by_wide && size >= 64 * WIDE) {
    size_t whole = size / (64 * WIDE) * (64 * WIDE);
    crc = ~follow_wide(~crc, data, size, &bad);
    *finite &= !bad && ylm_all_finite(YLM_FLOAT, (const char *)data + whole,
                                      (size - whole) / sizeof(float), NULL);
    return crc;
  }
#endif
  *finite &= ylm_all_finite(YLM_FLOAT, data, size / sizeof(float), NULL);
  return ylm_crc64(crc, data, size);
}

/* -- of two parts -------------------------------------------------------------------------------- */

/* The product of two remainders. */
static uint64_t times(uint64_t a, uint64_t b) {
  uint64_t product = 0;
  for (; a; a <<= 1, b = times_x(b)) product ^= b & (0 - (a >> 63)); /* bit 63 is x^0 */
  return product;
}

uint64_t ylm_crc64_join(uint64_t a, uint64_t b, uint64_t size) {
  uint64_t power = (uint64_t)1 << 55; /* x^8, then its squares */
  for (; size; size >>= 1, power = times(power, power))
    if (size & 1) a = times(a, power);
  return a ^ b;
}
