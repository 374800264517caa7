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

/* Link j of a place, of two bytes or of four. */
YLM_INLINE size_t at(bool two, const void *link, int j) {
  return two ? ((const uint16_t *)link)[j] : ((const uint32_t *)link)[j];
}

YLM_INLINE const void *next_place(bool two, const void *link, int links) {
  return (const char *)link + (size_t)links * (two ? sizeof(uint16_t) : sizeof(uint32_t));
}

/* Rows of four numbers: four sums, so that additions do not wait for one another. */
YLM_INLINE v4 sum_of_four(bool two, int links, const void *link, const float *in) {
  v4 s[4] = {{0}};
  for (int j = 0; j < links; j += 4)
    for (int k = 0; k < 4; k++) s[k] += load4(in + 4 * at(two, link, j + k));
  return (s[0] + s[1]) + (s[2] + s[3]);
}

YLM_INLINE void fours(bool two, size_t n, int links, const void *link, const float *in,
                      const float *start, float *out) {
  float each = 1 / (float)links;
  for (size_t i = 0; i < n; i++, link = next_place(two, link, links)) {
    v4 s = sum_of_four(two, links, link, in) * each;
    store4(out + 4 * i, start ? s + load4(start + 4 * i) : s);
  }
}

/* Columns first .. first + N YLM_VF - 1 of the mean. */
YLM_INLINE void columns(const int N, bool two, int links, const void *link, size_t row,
                        size_t first, bool ahead, const float *in, const float *start, float *out) {
  ylm_vf s[8];
  for (int k = 0; k < N; k++) s[k] = (ylm_vf){0};
  for (int j = 0; j < links; j++) {
    const float *from = in + at(two, link, j) * row;
    if (ahead && j + SUM_AHEAD < links) {
      const float *next = in + at(two, link, j + SUM_AHEAD) * row;
      for (size_t k = 0; k < row; k += LINE) __builtin_prefetch(next + k, 0, 3);
    }
    for (int k = 0; k < N; k++) s[k] += ylm_vf_load(from + first + (size_t)k * YLM_VF);
  }
  for (int k = 0; k < N; k++) {
    ylm_vf x = s[k] * (1 / (float)links);
    if (start) x += ylm_vf_load(start + first + (size_t)k * YLM_VF);
    ylm_vf_store(out + first + (size_t)k * YLM_VF, x);
  }
}

/* The last columns, fewer than a vector holds, four by four. */
YLM_INLINE void last_columns(bool two, int links, const void *link, size_t row, size_t first,
                             const float *in, const float *start, float *out) {
  for (; first < row; first += 4) {
    v4 s = {0};
    for (int j = 0; j < links; j++) s += load4(in + at(two, link, j) * row + first);
    s *= 1 / (float)links;
    if (start) s += load4(start + first);
    store4(out + first, s);
  }
}

/* Rows of any width. */
YLM_INLINE void rows(bool two, size_t n, int links, const void *link, size_t row, const float *in,
                     const float *start, float *out) {
  for (size_t i = 0; i < n; i++, link = next_place(two, link, links), out += row) {
    size_t k = 0;
    for (; k + 8 * YLM_VF <= row; k += 8 * YLM_VF)
      columns(8, two, links, link, row, k, k == 0, in, start, out);
    for (; k + 4 * YLM_VF <= row; k += 4 * YLM_VF)
      columns(4, two, links, link, row, k, k == 0, in, start, out);
    for (; k + YLM_VF <= row; k += YLM_VF)
      columns(1, two, links, link, row, k, k == 0, in, start, out);
    last_columns(two, links, link, row, k, in, start, out);
    if (start) start += row;
  }
}

void YLM_KERNEL(ylm_k_transfer_sum)(size_t n, int links, ylm_links link, int width, const float *in,
                                    const float *start, float *out) {
  size_t row = (size_t)width;
  if (width == 4 && link.two)
    fours(true, n, links, link.two, in, start, out);
  else if (width == 4)
    fours(false, n, links, link.four, in, start, out);
  else if (link.two)
    rows(true, n, links, link.two, row, in, start, out);
  else
    rows(false, n, links, link.four, row, in, start, out);
}
