/* outer.isa.c - sums of outer products, once per instruction set. outer.c has the plain form. */
#include "ylm_simd.h"

#include "transfer.h"

ylm_transfer_outer_fn YLM_KERNEL(ylm_k_transfer_outer);

typedef float v4 __attribute__((vector_size(16)));

/* Numbers first .. first + N YLM_VF - 1 of row o. */
#define COLUMNS(N)                                                                                 \
  YLM_INLINE void columns_##N(size_t n, size_t rows, size_t o, size_t width, size_t first,         \
                              const float *left, const float *right, float *m) {                   \
    float *to = m + o * width + first;                                                             \
    ylm_vf s[N];                                                                                   \
    for (int k = 0; k < N; k++) s[k] = ylm_vf_load(to + (size_t)k * YLM_VF);                       \
    for (size_t i = 0; i < n; i++) {                                                               \
      const float *from = right + i * width + first;                                               \
      float a = left[i * rows + o];                                                                \
      for (int k = 0; k < N; k++) s[k] += a * ylm_vf_load(from + (size_t)k * YLM_VF);              \
    }                                                                                              \
    for (int k = 0; k < N; k++) ylm_vf_store(to + (size_t)k * YLM_VF, s[k]);                       \
  }
COLUMNS(8)
COLUMNS(4)
COLUMNS(1)

/* The last four. */
YLM_INLINE void last(size_t n, size_t rows, size_t o, size_t width, size_t first, const float *left,
                     const float *right, float *m) {
  v4 s, x;
  memcpy(&s, m + o * width + first, sizeof s);
  for (size_t i = 0; i < n; i++) {
    memcpy(&x, right + i * width + first, sizeof x);
    s += left[i * rows + o] * x;
  }
  memcpy(m + o * width + first, &s, sizeof s);
}

void YLM_KERNEL(ylm_k_transfer_outer)(size_t n, size_t rows, size_t width, const float *left,
                                      const float *right, float *m) {
  for (size_t o = 0; o < rows; o++) {
    size_t k = 0;
    for (; k + 8 * YLM_VF <= width; k += 8 * YLM_VF)
      columns_8(n, rows, o, width, k, left, right, m);
    for (; k + 4 * YLM_VF <= width; k += 4 * YLM_VF)
      columns_4(n, rows, o, width, k, left, right, m);
    for (; k + YLM_VF <= width; k += YLM_VF) columns_1(n, rows, o, width, k, left, right, m);
    for (; k < width; k += 4) last(n, rows, o, width, k, left, right, m);
  }
}
