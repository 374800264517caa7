/* order.c - the order in which a query's points are taken: neighbours together, so that a block meets few cells of a caster's grid. */
#include "shadow.h"

#include <math.h>
#include <string.h>

enum { BITS = 10, DIGITS = 1 << BITS };

/* A cube around the points: its low corner, and DIGITS over its edge. */
static double cube_around(ylm_dtype t, size_t n, const void *points, double low[3]) {
  double high[3], edge = 0;
  for (size_t a = 0; a < 3; a++) low[a] = high[a] = ylm_get(t, points, a);
  for (size_t i = 1; i < n; i++)
    for (size_t a = 0; a < 3; a++) {
      double x = ylm_get(t, points, 3 * i + a);
      low[a] = x < low[a] ? x : low[a];
      high[a] = x > high[a] ? x : high[a];
    }
  for (size_t a = 0; a < 3; a++) edge = fmax(edge, high[a] - low[a]);
  return edge > 0 ? DIGITS / edge : 0;
}

/* Sorts by the upper half, stable; the numbers are in `from` again or in `to`, which is returned. */
static uint64_t *sort(size_t n, uint64_t *from, uint64_t *to) {
  for (int shift = 32; shift < 32 + 3 * BITS; shift += BITS) {
    size_t count[DIGITS + 1] = {0};
    for (size_t i = 0; i < n; i++) count[(from[i] >> shift & (DIGITS - 1)) + 1]++;
    for (size_t k = 0; k < DIGITS; k++) count[k + 1] += count[k];
    for (size_t i = 0; i < n; i++) to[count[from[i] >> shift & (DIGITS - 1)]++] = from[i];
    uint64_t *swap = from;
    from = to;
    to = swap;
  }
  return from;
}

bool ylm__shadow_order(ylm_dtype t, size_t n, const void *points, uint32_t **order, void **moved) {
  size_t size = 3 * ylm_dtype_size(t);
  double low[3], scale = cube_around(t, n, points, low);
  uint64_t *keys = ylm_alloc(2 * n, sizeof *keys), *sorted = NULL;
  *order = ylm_alloc(n, sizeof **order);
  *moved = ylm_alloc(n, size);
  bool ok = keys && *order && *moved;
  for (size_t i = 0; i < n && ok; i++) {
    uint32_t cell[3];
    for (size_t a = 0; a < 3; a++) {
      double x = scale * (ylm_get(t, points, 3 * i + a) - low[a]);
      cell[a] = x < DIGITS - 1 ? (uint32_t)x : DIGITS - 1;
    }
    keys[i] = ylm_morton(cell[0], cell[1], cell[2]) << 32 | i;
  }
  if (ok) sorted = sort(n, keys, keys + n);
  for (size_t i = 0; i < n && ok; i++) {
    uint32_t from = (*order)[i] = (uint32_t)sorted[i];
    memcpy((char *)*moved + i * size, (const char *)points + from * size, size);
  }
  ylm_free(keys);
  return ok;
}
