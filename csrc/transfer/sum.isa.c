/* sum.isa.c - means of rows over links, once per instruction set. sum.c has the plain form. */
#include "calibration.h"
#include "ylm_simd.h"

#include "transfer.h"

ylm_transfer_sum_fn YLM_KERNEL(ylm_k_transfer_sum);

/* Rows that are asked for ahead of their turn, and numbers in a line of the cache. */
#define LINE 16

typedef float v4 __attribute__((vector_size(16)));

YLM_INLINE v4 load4(const float *p) {
  v4 v;
  memcpy(&v, p, sizeof v);
  return v;
}

YLM_INLINE void store4(float *p, v4 v) { memcpy(p, &v, sizeof v); }

/* Rows of four numbers: four sums, so that additions do not wait for one another. */
YLM_INLINE v4 sum_of_four(int links, const uint32_t *link, const float *in) {
  v4 s[4] = {{0}};
  for (int j = 0; j < links; j += 4)
    for (int k = 0; k < 4; k++) s[k] += load4(in + 4 * (size_t)link[j + k]);
  return (s[0] + s[1]) + (s[2] + s[3]);
}

static void fours(size_t n, int links, const uint32_t *link, const float *in, const float *start,
                  float *out) {
  float each = 1 / (float)links;
  for (size_t i = 0; i < n; i++, link += links) {
    v4 s = sum_of_four(links, link, in) * each;
    store4(out + 4 * i, start ? s + load4(start + 4 * i) : s);
  }
}

/* Columns first .. first + N YLM_VF - 1 of the mean. */
#define COLUMNS(N)                                                                                 \
  YLM_INLINE void columns_##N(int links, const uint32_t *link, size_t row, size_t first,           \
                              bool ahead, const float *in, const float *start, float *out) {       \
    ylm_vf s[N] = {{0}};                                                                           \
    for (int j = 0; j < links; j++) {                                                              \
      const float *from = in + link[j] * row;                                                      \
      if (ahead && j + SUM_AHEAD < links) {                                                        \
        const float *next = in + link[j + SUM_AHEAD] * row;                                        \
        for (size_t k = 0; k < row; k += LINE) __builtin_prefetch(next + k, 0, 3);                 \
      }                                                                                            \
      for (int k = 0; k < N; k++) s[k] += ylm_vf_load(from + first + (size_t)k * YLM_VF);          \
    }                                                                                              \
    for (int k = 0; k < N; k++) {                                                                  \
      ylm_vf x = s[k] * (1 / (float)links);                                                        \
      if (start) x += ylm_vf_load(start + first + (size_t)k * YLM_VF);                             \
      ylm_vf_store(out + first + (size_t)k * YLM_VF, x);                                           \
    }                                                                                              \
  }
COLUMNS(8)
COLUMNS(4)
COLUMNS(1)

/* The last columns, fewer than a vector holds, four by four. */
YLM_INLINE void last_columns(int links, const uint32_t *link, size_t row, size_t first,
                             const float *in, const float *start, float *out) {
  for (; first < row; first += 4) {
    v4 s = {0};
    for (int j = 0; j < links; j++) s += load4(in + link[j] * row + first);
    s *= 1 / (float)links;
    if (start) s += load4(start + first);
    store4(out + first, s);
  }
}

void YLM_KERNEL(ylm_k_transfer_sum)(size_t n, int links, const uint32_t *link, int width,
                                    const float *in, const float *start, float *out) {
  size_t row = (size_t)width;
  if (width == 4) {
    fours(n, links, link, in, start, out);
    return;
  }
  for (size_t i = 0; i < n; i++, link += links, out += row) {
    size_t k = 0;
    for (; k + 8 * YLM_VF <= row; k += 8 * YLM_VF)
      columns_8(links, link, row, k, k == 0, in, start, out);
    for (; k + 4 * YLM_VF <= row; k += 4 * YLM_VF)
      columns_4(links, link, row, k, k == 0, in, start, out);
    for (; k + YLM_VF <= row; k += YLM_VF) columns_1(links, link, row, k, k == 0, in, start, out);
    last_columns(links, link, row, k, in, start, out);
    if (start) start += row;
  }
}
