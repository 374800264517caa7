/* ask.real.c - fields asked at points of a block, and their answers as rows. */
#include "block.h"

#include <string.h>

ylm_status SHADOW(ask)(block *b, const ylm_field *f, int lmax, size_t channels, size_t n,
                       const real *points, const double *origin, real *into, answer *a) {
  const shadow_query *w = b->w;
  size_t wide = n * channels * ylm_sh_count(lmax);
  bool gradient = w->rows > 1;
  a->value = into ? into : room(b, ROOM_VALUE, wide);
  a->gradient = gradient ? room(b, ROOM_GRADIENT, 3 * wide) : NULL;
  if (!a->value || (gradient && !a->gradient)) return YLM_ENOMEM;
  memset(a->inside, 0, n);
  if (w->metric) memset(a->lambda, 0, n * sizeof *a->lambda);
  ylm_field_query q = {.lmax = lmax,
                       .channels = (int)channels,
                       .want = YLM_WANT_VALUE | (gradient ? YLM_WANT_GRADIENT : 0) |
                               (w->metric ? YLM_WANT_METRIC : 0),
                       .metric_channels = channels == 3 ? w->q->metric_channels : 1,
                       .dtype = DTYPE,
                       .threads = 1,
                       .origin = origin};
  ylm_field_result r = {.value = a->value,
                        .gradient = a->gradient,
                        .lambda = w->metric ? a->lambda : NULL,
                        .inside = a->inside};
  ylm_status s = ylm_field_evaluate(f, &q, n, points, &r, b->e);
  atomic_fetch_add(&b->w->pairs, r.pairs);
  return s;
}

void SHADOW(unfold)(const shadow_query *w, const answer *a, size_t i, size_t own, real *to) {
  if (own < w->count) memset(to, 0, w->rows * w->count * sizeof *to);
  memcpy(to, a->value + i * own, own * sizeof *to);
  const real *g = a->gradient + (w->rows > 1 ? 3 * i * own : 0);
  for (size_t k = 0; w->rows > 1 && k < own; k++)
    for (size_t d = 0; d < 3; d++) to[(d + 1) * w->count + k] = g[3 * k + d];
}
