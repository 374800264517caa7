/*
** mix.isa.c - sums of predictions and turns, for the processor's vectors.
**
** Numbers are lanes: each is summed in the order that the plain form in row.c has. Products and sums are not contracted
** (Makefile), so that all sets have its bits.
*/
#include "small.h"
#include "ylm_simd.h"

#define COLUMNS 5 /* blocks of lanes that are summed at a time */

typedef float lanes __attribute__((vector_size(4 * SMALL_LANES)));

YLM_INLINE void load(lanes *v, const float *p) { memcpy(v, p, sizeof *v); }
YLM_INLINE void store(float *p, const lanes *v) { memcpy(p, v, sizeof *v); }

YLM_INLINE void mix_blocks(const small_mix *m, float scale, float *to, size_t from,
                           const int columns) {
  lanes sum[COLUMNS] = {{0}};
  for (int t = 0; t < m->n; t++)
    for (int c = 0; c < columns; c++) {
      lanes v;
      load(&v, m->row[t] + from + c * SMALL_LANES);
      sum[c] += m->weight[t] * v;
    }
  for (int c = 0; c < columns; c++) {
    lanes v = sum[c] * scale;
    store(to + from + c * SMALL_LANES, &v);
  }
}

static void mix(const small_mix *m, float scale, float *restrict to, size_t n) {
  size_t i = 0;
  for (; i + COLUMNS * SMALL_LANES <= n; i += COLUMNS * SMALL_LANES)
    mix_blocks(m, scale, to, i, COLUMNS);
  for (; i < n; i += SMALL_LANES) mix_blocks(m, scale, to, i, 1);
}

/* Blocks from number i on, of the columns whose numbers are not 0. */
YLM_INLINE void turn_blocks(const float *column, const float *number, const uint8_t *used,
                            size_t uses, float *to, size_t n, size_t i, const int columns) {
  lanes sum[COLUMNS] = {{0}};
  for (size_t u = 0; u < uses; u++)
    for (int c = 0; c < columns; c++) {
      lanes v;
      load(&v, column + used[u] * n + i + (size_t)c * SMALL_LANES);
      sum[c] += number[used[u]] * v;
    }
  for (int c = 0; c < columns; c++) store(to + i + c * SMALL_LANES, &sum[c]);
}

static void turn(const float *column, const float *number, float *restrict to, size_t n) {
  uint8_t used[SMALL_COLUMNS];
  size_t uses = 0, i = 0;
  for (size_t k = 0; k < n; k++) {
    used[uses] = (uint8_t)k;
    uses += number[k] != 0;
  }
  for (; i + 3 * SMALL_LANES <= n; i += 3 * SMALL_LANES)
    turn_blocks(column, number, used, uses, to, n, i, 3);
  for (; i + SMALL_LANES <= n; i += SMALL_LANES)
    turn_blocks(column, number, used, uses, to, n, i, 1);
  for (; i < n; i++) {
    float sum = 0;
    for (size_t u = 0; u < uses; u++) sum += number[used[u]] * column[used[u] * n + i];
    to[i] = sum;
  }
}

static void colour(const float v[9], const float *restrict x, float step, const float *restrict by,
                   float *restrict to, size_t n) {
  for (size_t c = 0; c < 3; c++)
    for (size_t k = 0; k < n; k++) {
      float sum = v[c] * x[k] + v[3 + c] * x[n + k];
      sum += v[6 + c] * x[2 * n + k];
      to[c * n + k] += sum * step * by[k];
    }
}

const small_kernels YLM_KERNEL(ylm_k_small) = {mix, turn, colour};
