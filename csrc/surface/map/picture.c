/* picture.c - the fitted texels as a picture, in numbers that half floats have. */
#include "map.h"

/* The nearest number that half floats have. */
static float as_half(double x) {
  int exponent;
  if (x < 0) return -as_half(-x);
  if (!(x > 0)) return 0;
  if (x >= 65504) return 65504;
  frexp(x, &exponent);
  double step = ldexp(1, (exponent < -13 ? -13 : exponent) - 11);
  return (float)(round(x / step) * step);
}

/* The texel at x, y by the line of the two beside it along dx, dy, from half to twice the next one; where there is one, or that is
   not above 0, it is that one. */
static double continued(const map_bake *b, const float *picture, const uint32_t *age, uint32_t now,
                        long x, long y, long dx, long dy, size_t c) {
  double a = (double)picture[3 * ((size_t)(y + dy) * b->width + (size_t)(x + dx)) + c];
  long u = x + 2 * dx, v = y + 2 * dy;
  if (u < 0 || v < 0 || u >= (long)b->width || v >= (long)b->height) return a;
  size_t of = (size_t)v * b->width + (size_t)u;
  if (!age[of] || age[of] == now) return a;
  double next = 2 * a - (double)picture[3 * of + c];
  return a > 0 ? fmin(fmax(next, a / 2), 2 * a) : a;
}

/* Texels that no chart has continue the lines of those beside them, ring by ring: their means. */
static ylm_status fill(const map_bake *b, float *picture) {
  size_t n = b->texels, left = 0, next = 0;
  uint32_t *ring = ylm_alloc(n, sizeof *ring), *age = ylm_alloc_zero(n, sizeof *age);
  ylm_status s = ring && age ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    if (b->chart[i] != YLM_UNWRAP_NONE)
      age[i] = 1;
    else
      ring[left++] = (uint32_t)i;
  for (uint32_t now = 2; s == YLM_OK && left; now++, left = next) {
    next = 0;
    for (size_t i = 0; i < left; i++) {
      long x = (long)(ring[i] % b->width), y = (long)(ring[i] / b->width);
      double sum[3] = {0, 0, 0}, count = 0;
      for (int k = 0; k < 9; k++) {
        long u = x + k % 3 - 1, v = y + k / 3 - 1;
        if (u < 0 || v < 0 || u >= (long)b->width || v >= (long)b->height) continue;
        size_t of = (size_t)v * b->width + (size_t)u;
        if (!age[of] || age[of] == now) continue;
        count++;
        for (size_t c = 0; c < 3; c++)
          sum[c] += continued(b, picture, age, now, x, y, k % 3 - 1, k / 3 - 1, c);
      }
      if (count > 0) {
        age[ring[i]] = now;
        for (size_t c = 0; c < 3; c++) picture[3 * (size_t)ring[i] + c] = as_half(sum[c] / count);
      } else
        ring[next++] = ring[i];
    }
  }
  ylm_free(ring);
  ylm_free(age);
  return s;
}

/* Texels [height][width][3] of charts from one fit [3][texels], or the mean of two. */
static void copy(const map_bake *b, int halves, const float *value, float *picture) {
  size_t n = b->texels;
  for (size_t i = 0; i < 3 * n; i++) {
    if (b->chart[i / 3] == YLM_UNWRAP_NONE) continue;
    double x = (double)value[i % 3 * n + i / 3];
    if (halves > 1) x = 0.5 * (x + (double)value[(3 + i % 3) * n + i / 3]);
    picture[i] = as_half(x);
  }
}

/* The flow of the sites along two axes in place of the halves of their light. */
static void take_flow(map_bake *b, int first, int second) {
  for (size_t i = 0; i < b->sites; i++) {
    memcpy(b->site[i].light.a, b->flow[i][first], 12);
    memcpy(b->site[i].light.b, b->flow[i][second], 12);
  }
}

/* Fits the flow along the axes, with bends as they are; the light of the sites is gone then. */
static ylm_status draw_flow(map_bake *b) {
  size_t n = b->texels;
  float *flow = ylm_alloc_zero(9 * n, sizeof *flow);
  ylm_free(b->m->flow);
  b->m->flow = flow;
  ylm_status s = flow ? YLM_OK : YLM_ENOMEM;
  for (int pass = 0; s == YLM_OK && pass < 2; pass++) {
    take_flow(b, 2 * pass, pass ? 2 : 1);
    memset(b->value, 0, 6 * n * sizeof *b->value);
    s = ylm__map_fit(b, b->value);
    if (s != YLM_OK) break;
    copy(b, 1, b->value, flow + (size_t)(6 * pass) * n);
    if (pass == 0) copy(b, 1, b->value + 3 * n, flow + 3 * n);
  }
  for (size_t axis = 0; s == YLM_OK && axis < 3; axis++) s = fill(b, flow + 3 * axis * n);
  return s;
}

ylm_status ylm__map_draw(map_bake *b) {
  float *picture = ylm_alloc_zero(3 * b->texels, sizeof *picture);
  if (!picture) return YLM_ENOMEM;
  copy(b, 2, b->value, picture);
  ylm_free(b->m->picture);
  b->m->picture = picture;
  ylm_status s = fill(b, picture);
  if (s == YLM_OK) s = ylm__map_jumps(b, b->m->stats.jump);
  return s == YLM_OK && b->flow ? draw_flow(b) : s;
}

double ylm_surface_map_rgbm(const ylm_surface_map *m, float *out) {
  size_t n = m->stats.charts.width * m->stats.charts.height;
  double range = 0;
  for (size_t i = 0; i < 3 * n; i++) range = fmax(range, (double)m->picture[i]);
  if (!(range > 0)) range = 1;
  for (size_t i = 0; i < n; i++) {
    const float *E = m->picture + 3 * i;
    double most = sqrt(fmax((double)E[0], fmax((double)E[1], (double)E[2])) / range);
    double alpha = fmax(ceil(255 * most), 1) / 255;
    for (int c = 0; c < 3; c++)
      out[4 * i + (size_t)c] = (float)(round(255 * sqrt((double)E[c] / range) / alpha) / 255);
    out[4 * i + 3] = (float)alpha;
  }
  return range;
}
