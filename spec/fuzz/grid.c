/*
** grid.c - fuzzes the reader of grid files.
**
** Mutations get a size and a checksum that fit, or else nothing behind the checksum would ever be
** reached; one in sixteen goes through as it is. What is accepted must be safe to sample.
*/
#include <math.h>
#include <string.h>

#include "../../csrc/grid/grid.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);

/* The kernels are not what is fuzzed: all sets are the reference. */
void ylm_k_grid_sample_sse2(const sample_batch *b) { ylm_k_grid_sample_reference(b); }
void ylm_k_grid_sample_avx2(const sample_batch *b) { ylm_k_grid_sample_reference(b); }
void ylm_k_grid_sample_avx512(const sample_batch *b) { ylm_k_grid_sample_reference(b); }
void ylm_k_grid_sample_neon(const sample_batch *b) { ylm_k_grid_sample_reference(b); }

/* Nor are lights: grids from files have none, and what would need them traps. */
ylm_status ylm_lights_create(size_t n, const double *at, const double *radius,
                             const double *radiance, ylm_lights **l, ylm_error *e) {
  (void)n, (void)at, (void)radius, (void)radiance, (void)l, (void)e;
  __builtin_trap();
}
void ylm_lights_free(ylm_lights *l) {
  if (l) __builtin_trap();
}
size_t ylm_lights_count(const ylm_lights *l) {
  (void)l;
  __builtin_trap();
}
void ylm_lights_arrays(const ylm_lights *l, const double **at, const double **radius,
                       const double **radiance) {
  (void)l, (void)at, (void)radius, (void)radiance;
  __builtin_trap();
}
const ylm_field *ylm_lights_field(const ylm_lights *l) {
  (void)l;
  __builtin_trap();
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed) {
  size = LLVMFuzzerMutate(data, size, room);
  if (size < 40 || seed % 16 == 0) return size;
  uint64_t bytes = size, crc;
  uint32_t order;
  memcpy(&order, data + 8, sizeof order);
  bool swap = order == 0x04030201u;
  if (swap) bytes = __builtin_bswap64(bytes);
  memcpy(data + 16, &bytes, sizeof bytes);
  crc = ylm_crc64(0, data, size - 8);
  if (swap) crc = __builtin_bswap64(crc);
  memcpy(data + size - 8, &crc, sizeof crc);
  return size;
}

/* Samples a grid inside, outside, and at its corners. */
static void sample(const ylm_grid *g) {
  const double *b = ylm_grid_look(g)->form.bounds;
  double points[8][3];
  for (int i = 0; i < 8; i++)
    for (int a = 0; a < 3; a++) {
      double t = i < 4 ? 0.37 * (i + 1) - 0.1 * a : i - 5;
      points[i][a] = b[a] + t * (b[a + 3] - b[a]);
      if (!isfinite(points[i][a])) points[i][a] = 0;
    }
  size_t width = (size_t)ylm_grid_look(g)->count * (size_t)ylm_grid_look(g)->form.channels;
  float *value = ylm_alloc(8 * 4 * width, sizeof *value);
  ylm_grid_query q = {.point_dtype = YLM_DOUBLE, .dtype = YLM_FLOAT, .threads = 1};
  if (value) ylm_grid_sample(g, &q, 8, points, value, value + 8 * width, NULL, NULL);
  ylm_free(value);
  for (int i = 0; i < 8; i++) ylm_grid_locate(g, points[i], i & 1, NULL);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  ylm_error e;
  ylm_grid *g;
  if (ylm_grid_decode(data, size, "fuzz", &g, &e) != YLM_OK) {
    if (g) __builtin_trap();
    return 0;
  }
  sample(g);
  unsigned char *again;
  size_t bytes;
  if (ylm_grid_encode(g, false, &again, &bytes, &e) == YLM_OK) {
    if (bytes != size) __builtin_trap();
    ylm_free(again);
  }
  ylm_grid_free(g);
  return 0;
}
