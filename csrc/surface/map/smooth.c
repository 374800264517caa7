/*
** smooth.c - how much bends weigh, texel by texel: where light is smooth, texels become means of many.
**
** Each of a few weights is fitted to one half of the rays of places, and judged by the other: the noise of the halves is
** independent, so the judge's noise adds the same to all weights. Around each texel the weight that misses least is kept.
*/
#include "map.h"

/* Adds what fits of both halves miss of the other to the texels that are read. */
static void add_misses(const map_bake *b, const float *value, float *miss) {
  for (size_t i = 0; i < b->sites; i++) {
    const map_site *s = &b->site[i];
    double sum = 0, w = (double)s->weight;
    if (!map_counts(s)) continue;
    for (int c = 0; c < 3; c++)
      for (int half = 0; half < 2; half++) {
        double d = map_value(b, value, half, s, c) - (double)(half ? s->light.a : s->light.b)[c];
        sum += d * d * w;
      }
    for (int k = 0; k < 4; k++) miss[s->tap.texel[k]] += (float)sum * s->tap.weight[k];
  }
}

/* Sums over the texels of its chart around each, along one axis. */
static void sum_around(const map_bake *b, bool down, const float *from, float *to) {
  for (size_t i = 0; i < b->texels; i++) {
    long at = (long)(down ? i / b->width : i % b->width);
    long last = (long)(down ? b->height : b->width) - 1, step = down ? (long)b->width : 1;
    long low = at < MAP_AROUND ? -at : -MAP_AROUND;
    long high = last - at < MAP_AROUND ? last - at : MAP_AROUND;
    to[i] = 0;
    for (long k = low; k <= high; k++) {
      size_t other = (size_t)((long)i + k * step);
      if (b->chart[other] == b->chart[i]) to[i] += from[other];
    }
  }
}

void ylm__map_sum_around(const map_bake *b, float *x, float *room) {
  sum_around(b, false, x, room);
  sum_around(b, true, room, x);
}

ylm_status ylm__map_smooth(map_bake *b) {
  size_t n = b->texels;
  float *room = ylm_alloc(4 * n, sizeof *room);
  float *miss = room, *sum = room + n, *least = room + 2 * n, *best = room + 3 * n;
  ylm_status s = room ? YLM_OK : YLM_ENOMEM;
  for (int k = 0; s == YLM_OK && k < MAP_WEIGHTS; k++) {
    for (size_t i = 0; i < n; i++) b->bend[i] = (float)map_weight[k], miss[i] = 0;
    s = ylm_report(b->form->light.progress, (uint64_t)k, MAP_WEIGHTS, "texels");
    if (s == YLM_OK) s = ylm__map_fit(b, b->value);
    if (s != YLM_OK) break;
    add_misses(b, b->value, miss);
    ylm__map_sum_around(b, miss, sum);
    for (size_t i = 0; i < n; i++)
      if (k == 0 || miss[i] < least[i]) least[i] = miss[i], best[i] = (float)(map_weight[k] / 2);
  }
  if (s == YLM_OK) memcpy(b->bend, best, n * sizeof *best);
  ylm_free(room);
  return s;
}
