/* denoise.isa.c - light of points around one, a vector of taps at a time, once per instruction set. denoise_plain.c has the
   plain form and the formulas. */
#include "ylm_simd.h"

#include "../fold.h"
#include "denoise.h"

denoise_gather_fn YLM_KERNEL(ylm_k_denoise_gather);
denoise_gather_fn YLM_KERNEL(ylm_k_denoise_fit);
denoise_vary_fn YLM_KERNEL(ylm_k_denoise_vary);

YLM_INLINE ylm_vf positive(ylm_vf x) { return (ylm_vf)((ylm_vi)x & (ylm_vi)(x > 0)); }

YLM_INLINE float sum_of(ylm_vf v) {
  v4 s = fold(v);
  return (s[0] + s[2]) + (s[1] + s[3]);
}

/* 0, 1, 2, ... */
YLM_INLINE ylm_vf steps(void) {
  ylm_vf v;
  for (int i = 0; i < YLM_VF; i++) v[i] = (float)i;
  return v;
}

/* Weights of taps from number i on, by surfaces and by the squared distance d2 in the picture. */
YLM_INLINE ylm_vf near(const denoise_grid *g, const denoise_centre *c, size_t i, ylm_vf d2) {
  ylm_vf up = {0}, down = {0}, cosine = {0}, away = {0};
  for (int a = 0; a < 3; a++) {
    ylm_vf x = ylm_vf_load(g->number[TAP_X + a] + i) - c->x[a];
    ylm_vf n = ylm_vf_load(g->number[TAP_NORMAL + a] + i);
    up += x * c->normal[a];
    down += x * n;
    away += x * x;
    cosine += n * c->normal[a];
  }
  ylm_vf u = up * up, d = down * down, off = ylm_vf_select((ylm_vi)(u > d), u, d);
  ylm_vf flat = positive(1 - off * (c->plane * c->plane));
  ylm_vf turned = positive((cosine - DENOISE_COSINE) * (1 / (1 - DENOISE_COSINE)));
  ylm_vf seen = d2 * c->falloff, far = away * c->around;
  ylm_vf inside = positive(1 - ylm_vf_select((ylm_vi)(seen > far), seen, far));
  ylm_vf w = flat * turned * inside * ylm_vf_load(g->number[TAP_SHARE] + i);
  return (ylm_vf)((ylm_vi)w & (ylm_vi)(ylm_vf_load(g->number[TAP_CLASS] + i) == c->class));
}

/* Cells to the right of a row's middle that are in the disk. */
YLM_INLINE int width_of(const denoise_centre *c, int v) {
  float y = (float)v - c->off[1], rest = 1 / c->falloff - y * y;
  return rest > 0 ? (int)(sqrtf(rest) + fabsf(c->off[0])) : -1;
}

YLM_INLINE size_t tap_at(const denoise_grid *g, const denoise_centre *c, int u, int v) {
  return (size_t)((ptrdiff_t)c->at + v * (ptrdiff_t)g->stride + u);
}

/* Sums of a half, lane by lane. */
typedef struct half_sums {
  ylm_vf weight, square, value[3], u, v, uu, uv, vv, value_u[3], value_v[3];
} half_sums;

/* Adds taps from number i on, u and v of the centre, to a half. */
YLM_INLINE void add(const denoise_grid *g, const bool linear, size_t i, int half, ylm_vf w,
                    ylm_vf u, float v, half_sums *s) {
  s->weight += w;
  s->square += w * w;
  if (linear) {
    s->u += w * u, s->v += w * v;
    s->uu += w * u * u, s->uv += w * u * v, s->vv += w * (v * v);
  }
  for (int k = 0; k < 3; k++) {
    ylm_vf x = w * ylm_vf_load(g->number[TAP_VALUE + 3 * half + k] + i);
    s->value[k] += x;
    if (linear) s->value_u[k] += x * u, s->value_v[k] += x * v;
  }
}

YLM_INLINE void store(const bool linear, int h, const half_sums *s, denoise_sums *out) {
  out->weight[h] = sum_of(s->weight);
  out->square[h] = sum_of(s->square);
  for (int k = 0; k < 3; k++) out->value[h][k] = sum_of(s->value[k]);
  if (!linear) return;
  out->u[h] = sum_of(s->u), out->v[h] = sum_of(s->v);
  out->uu[h] = sum_of(s->uu), out->uv[h] = sum_of(s->uv), out->vv[h] = sum_of(s->vv);
  for (int k = 0; k < 3; k++) {
    out->value_u[h][k] = sum_of(s->value_u[k]);
    out->value_v[h][k] = sum_of(s->value_v[k]);
  }
}

YLM_INLINE void sums(const denoise_grid *g, const denoise_centre *c, const bool linear,
                     denoise_sums *out) {
  half_sums s[2] = {0};
  for (int v = -c->rows; v <= c->rows; v++) {
    int wide = width_of(c, v);
    float y = (float)v - c->off[1];
    for (int u = -wide; u <= wide; u += YLM_VF) {
      ylm_vf x = steps() + ((float)u - c->off[0]);
      size_t i = tap_at(g, c, u, v);
      ylm_vf w = near(g, c, i, x * x + y * y);
      ylm_vf scale = 1 / (DENOISE_RANGE * (ylm_vf_load(g->number[TAP_SPREAD] + i) + c->spread));
      for (int h = 0; h < 2; h++) {
        ylm_vf d = ylm_vf_load(g->number[TAP_GUIDE + !h] + i) - c->guide[!h];
        ylm_vf like = positive(1 - d * d * scale);
        add(g, linear, i, h, w * like * like, x, y, &s[h]);
      }
    }
  }
  for (int h = 0; h < 2; h++) store(linear, h, &s[h], out);
}

void YLM_KERNEL(ylm_k_denoise_gather)(const denoise_grid *g, const denoise_centre *c,
                                      denoise_sums *out) {
  sums(g, c, false, out);
}

void YLM_KERNEL(ylm_k_denoise_fit)(const denoise_grid *g, const denoise_centre *c,
                                   denoise_sums *out) {
  sums(g, c, true, out);
}

void YLM_KERNEL(ylm_k_denoise_vary)(const denoise_grid *g, const denoise_centre *c, float out[3]) {
  ylm_vf weight = {0}, square = {0}, mean = {0};
  for (int v = -c->rows; v <= c->rows; v++) {
    int wide = width_of(c, v);
    float y = (float)v - c->off[1];
    for (int u = -wide; u <= wide; u += YLM_VF) {
      ylm_vf x = steps() + ((float)u - c->off[0]);
      size_t i = tap_at(g, c, u, v);
      ylm_vf w = near(g, c, i, x * x + y * y);
      weight += w;
      square += w * ylm_vf_load(g->number[TAP_APART] + i);
      mean += w * ylm_vf_load(g->number[TAP_ALL] + i);
    }
  }
  out[0] = sum_of(weight);
  out[1] = sum_of(square);
  out[2] = sum_of(mean);
}
