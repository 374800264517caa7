/* crc.c - CRC-64/XZ, sixteen bytes at a time. */
#include "ylm_base.h"

#include <pthread.h>

#define SLICES 16
#define POLYNOMIAL 0xC96C5795D7870F42u /* of ECMA-182, reflected */

/* table[k][b]: what byte b does to the remainder once k more bytes have followed it. */
static uint64_t table[SLICES][256];

static void fill_table(void) {
  for (uint64_t i = 0; i < 256; i++) {
    uint64_t c = i;
    for (int bit = 0; bit < 8; bit++) c = c & 1 ? c >> 1 ^ POLYNOMIAL : c >> 1;
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

uint64_t ylm_crc64(uint64_t crc, const void *data, size_t size) {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  const unsigned char *p = data;
  pthread_once(&once, fill_table);
  crc = ~crc;
  for (; size >= SLICES; size -= SLICES, p += SLICES) {
    uint64_t low = crc ^ eight(p), high = eight(p + 8), sum = 0;
    for (int k = 0; k < 8; k++)
      sum ^= table[15 - k][low >> 8 * k & 255] ^ table[7 - k][high >> 8 * k & 255];
    crc = sum;
  }
  for (; size; size--) crc = crc >> 8 ^ table[0][(crc ^ *p++) & 255];
  return ~crc;
}
