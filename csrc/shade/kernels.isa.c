/* kernels.isa.c - the inner loops of shading, once per instruction set. kernels.c has the plain
 * form. */
#include "ylm_simd.h"

#include "fold.h"
#include "view.h"

ylm_shade_dot_fn YLM_KERNEL(ylm_k_shade_dot);
ylm_shade_sums_fn YLM_KERNEL(ylm_k_shade_sums);
ylm_shade_mix_fn YLM_KERNEL(ylm_k_shade_mix);

/* Lanes of the last, overlapping vector that no whole vector before it has covered. */
YLM_INLINE ylm_vi tail_mask(size_t rest) {
  ylm_vi m;
  for (int i = 0; i < YLM_VF; i++) m[i] = i >= YLM_VF - (int)rest ? -1 : 0;
  return m;
}

/* The sums of the lanes of three vectors. */
YLM_INLINE void lane_sums(ylm_vf x, ylm_vf y, ylm_vf z, float out[3]) {
  v4 a = fold(x), b = fold(y), c = fold(z);
  v4 ab = __builtin_shufflevector(a, b, 0, 4, 1, 5) + __builtin_shufflevector(a, b, 2, 6, 3, 7);
  v4 cc = __builtin_shufflevector(c, c, 0, 0, 1, 1) + __builtin_shufflevector(c, c, 2, 2, 3, 3);
  v4 s = __builtin_shufflevector(ab, cc, 0, 1, 4, 5) + __builtin_shufflevector(ab, cc, 2, 3, 6, 7);
  memcpy(out, &s, 3 * sizeof *out);
}

/* Sum of a[k] b[k] for counts below a vector's length, where lanes would be idle. */
YLM_INLINE float short_dot(size_t count, const float *a, const float *b) {
  float s = 0;
  for (size_t k = 0; k < count; k++) s += a[k] * b[k];
  return s;
}

/* Vectors whose lanes add up to the sums of T[k] L[c][k], for `channels` rows of L. */
YLM_INLINE void long_dots(size_t count, const int channels, const float *T, size_t l_row,
                          const float *L, ylm_vi tail, ylm_vf s[3]) {
  size_t k = 0;
  for (int c = 0; c < channels; c++) s[c] = ylm_vf_set(0);
  for (; k + YLM_VF <= count; k += YLM_VF)
    for (int c = 0; c < channels; c++)
      s[c] += ylm_vf_load(T + k) * ylm_vf_load(L + (size_t)c * l_row + k);
  if (k == count) return;
  ylm_vf last = (ylm_vf)((ylm_vi)ylm_vf_load(T + count - YLM_VF) & tail);
  for (int c = 0; c < channels; c++)
    s[c] += last * ylm_vf_load(L + (size_t)c * l_row + count - YLM_VF);
}

void YLM_KERNEL(ylm_k_shade_dot)(size_t count, size_t n, int channels, const uint32_t *index,
                                 size_t t_row, const float *T, size_t l_row, size_t l_point,
                                 const float *L, float *out) {
  ylm_vi tail = tail_mask(count % YLM_VF);
  for (size_t i = 0; i < n; i++, L += l_point) {
    size_t p = index ? index[i] : i;
    const float *t = T + p * t_row;
    float *to = out + 3 * p;
    ylm_vf s[3];
    if (count < YLM_VF)
      for (int c = 0; c < 3; c++)
        to[c] = short_dot(count, t, c < channels ? L + (size_t)c * l_row : L);
    else if (channels == 3) {
      long_dots(count, 3, t, l_row, L, tail, s);
      lane_sums(s[0], s[1], s[2], to);
    } else {
      long_dots(count, 1, t, l_row, L, tail, s);
      lane_sums(s[0], s[0], s[0], to);
    }
  }
}

/* One point of F functions and C channels. */
YLM_INLINE void mix_point(const int F, const int C, size_t count, size_t t_row, const float *T,
                          size_t l_row, const float *L, ylm_vi tail, const float (*mix)[3],
                          float *to) {
  ylm_vf s[3][3], sum[3];
  size_t k = 0;
  for (int c = 0; c < C; c++)
    for (int f = 0; f < F; f++) s[c][f] = ylm_vf_set(0);
  for (; k + YLM_VF <= count; k += YLM_VF)
    for (int c = 0; c < C; c++) {
      ylm_vf l = ylm_vf_load(L + (size_t)c * l_row + k);
      for (int f = 0; f < F; f++) s[c][f] += l * ylm_vf_load(T + (size_t)f * t_row + k);
    }
  if (k < count)
    for (int c = 0; c < C; c++) {
      ylm_vi l = (ylm_vi)ylm_vf_load(L + (size_t)c * l_row + count - YLM_VF) & tail;
      for (int f = 0; f < F; f++)
        s[c][f] += (ylm_vf)l * ylm_vf_load(T + (size_t)f * t_row + count - YLM_VF);
    }
  for (int c = 0; c < 3; c++) {
    const ylm_vf *of = s[C == 3 ? c : 0];
    sum[c] = of[0] * ylm_vf_set(mix[c][0]);
    for (int f = 1; f < F; f++) sum[c] += of[f] * ylm_vf_set(mix[c][f]);
  }
  lane_sums(sum[0], sum[1], sum[2], to);
}

/* One point, of fewer numbers than a vector has. */
YLM_INLINE void mix_short(int F, int C, size_t count, size_t t_row, const float *T, size_t l_row,
                          const float *L, const float (*mix)[3], float *to) {
  for (int c = 0; c < 3; c++) {
    to[c] = 0;
    for (int f = 0; f < F; f++)
      to[c] +=
          mix[c][f] * short_dot(count, T + (size_t)f * t_row, L + (c < C ? (size_t)c : 0) * l_row);
  }
}

void YLM_KERNEL(ylm_k_shade_mix)(size_t count, size_t n, int functions, int channels, size_t t_row,
                                 const float *T, size_t l_row, const float *L,
                                 const float (*mix)[3], float *out) {
  ylm_vi tail = tail_mask(count % YLM_VF);
  for (size_t i = 0; i < n; i++, out += 3) {
    if (count < YLM_VF)
      mix_short(functions, channels, count, t_row, T, l_row, L, mix, out);
    else
      switch (3 * (channels == 3) + functions) {
#define MIX(F, C)                                                                                  \
  case 3 * (C == 3) + F: mix_point(F, C, count, t_row, T, l_row, L, tail, mix, out); break;
        MIX(1, 1)
        MIX(2, 1)
        MIX(3, 1)
        MIX(1, 3)
        MIX(2, 3)
        MIX(3, 3)
#undef MIX
      }
    T += (size_t)functions * t_row;
    L += (size_t)channels * l_row;
  }
}

void YLM_KERNEL(ylm_k_shade_sums)(size_t count, size_t n, const float *Y, const uint8_t *visible,
                                  float *seen, float *all) {
  size_t k = 0;
  for (; k + YLM_VF <= count; k += YLM_VF) {
    ylm_vf s = {0}, a = {0};
    for (size_t i = 0; i < n; i++) {
      ylm_vf y = ylm_vf_load(Y + i * count + k);
      ylm_vi m = (ylm_vi){0} - visible[i];
      a += y;
      s += (ylm_vf)((ylm_vi)y & m);
    }
    ylm_vf_store(seen + k, ylm_vf_load(seen + k) + s);
    ylm_vf_store(all + k, ylm_vf_load(all + k) + a);
  }
  for (; k < count; k++)
    for (size_t i = 0; i < n; i++) {
      all[k] += Y[i * count + k];
      seen[k] += visible[i] ? Y[i * count + k] : 0;
    }
}
