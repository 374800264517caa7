/*
** probes.c - fuzzes the reader of probes for engines (.ylmp).
**
** Mutations get a size and a checksum that fit, or nothing behind these would be reached; one in sixteen goes through as it is.
** Most keep their size. Probes that are accepted are looked up within and outside of their bounds, written, and read again.
*/
#include <math.h>
#include <string.h>

#include "ylm_grid.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);

/* Offsets in the header (docs/engines.md), and its size. */
enum { AT_SUM = 16, AT_SIZE = 24, AT_BITS = 109, HEADER = 116 };

static void seal(uint8_t *data, size_t size) {
  uint64_t x = size;
  memcpy(data + AT_SIZE, &x, sizeof x);
  x = ylm_crc64(0, data + AT_SIZE, size - AT_SIZE);
  memcpy(data + AT_SUM, &x, sizeof x);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed) {
  size_t before = size, head = size > HEADER && seed % 4 ? HEADER : 0;
  size = head + LLVMFuzzerMutate(data + head, size - head, (seed % 8 ? size : room) - head);
  if (seed % 8 && before <= room) {
    memset(data + size, 0, before - size);
    size = before;
  }
  if (size >= HEADER && seed % 16) seal(data, size);
  return size;
}

/* Looks irradiance up at 27 places: it is finite and not negative. */
static void look_up(const ylm_grid_probes *p) {
  ylm_grid_probes_size s = ylm_grid_probes_look(p);
  double point[27][3];
  float normal[27][3], out[27][3];
  for (int i = 0; i < 27; i++) {
    const int at[3] = {i % 3, i / 3 % 3, i / 9};
    for (int a = 0; a < 3; a++) {
      double lo = s.bounds[a], hi = s.bounds[a + 3];
      point[i][a] = lo + (0.7 * at[a] - 0.1) * (hi - lo);
      normal[i][a] = (float)(at[(a + 1) % 3] - 1) / sqrtf(3);
    }
  }
  ylm_grid_probes_irradiance(p, 27, (const double(*)[3])point, (const float(*)[3])normal, out);
  for (int i = 0; i < 27; i++)
    for (int c = 0; c < 3; c++)
      if (!(out[i][c] >= 0 && isfinite(out[i][c]))) __builtin_trap();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  ylm_grid_probes *p, *again;
  if (ylm_grid_probes_decode(data, size, "fuzz", &p, &e) != YLM_OK) {
    if (p) __builtin_trap();
    return 0;
  }
  unsigned char *bytes;
  size_t count;
  ylm_grid_probes_bytes b;
  look_up(p);
  if (ylm_grid_probes_measure(p, data[AT_BITS], &b) != YLM_OK ||
      ylm_grid_probes_encode(p, data[AT_BITS], &bytes, &count, &e) != YLM_OK || count != b.all ||
      ylm_grid_probes_decode(bytes, count, "again", &again, &e) != YLM_OK)
    __builtin_trap();
  look_up(again);
  ylm_grid_probes_free(again);
  ylm_grid_probes_free(p);
  ylm_free(bytes);
  return 0;
}
