/* write.real.c - results of a block. */
#include "block.h"

#include <math.h>
#include <string.h>

/* Channel c of `channels` of a number of the light. */
static double channel(const shadow_query *w, const real *x, int channels, int c) {
  size_t step = w->rows * w->count;
  if (w->channels == 1) return (double)x[0];
  if (channels == 3) return (double)x[(size_t)c * step];
  return YLM_LUMINANCE_R * (double)x[0] + YLM_LUMINANCE_G * (double)x[step] +
         YLM_LUMINANCE_B * (double)x[2 * step];
}

/* Values of channel c, as they stand or as a luminance, and derivatives. */
static void write_channel(const shadow_query *w, const real *x, int c, real *value,
                          real *gradient) {
  size_t n = w->count, step = w->rows * n;
  bool stands = w->channels == 1 || w->q->channels == 3;
  const real *from = w->channels == 1 ? x : x + (size_t)c * step;
  if (value && stands) memcpy(value, from, n * sizeof *value);
  for (size_t k = 0; value && !stands && k < n; k++)
    value[k] = (real)channel(w, x + k, w->q->channels, c);
  for (size_t k = 0; gradient && k < n; k++)
    for (size_t d = 0; d < 3; d++)
      gradient[3 * k + d] =
          stands ? from[(d + 1) * n + k] : (real)channel(w, x + (d + 1) * n + k, w->q->channels, c);
}

void SHADOW(write)(const block *b) {
  const shadow_query *w = b->w;
  const ylm_field_query *q = w->q;
  size_t channels = (size_t)q->channels;
  real *value = q->want & YLM_WANT_VALUE ? w->r->value : NULL,
       *gradient = q->want & YLM_WANT_GRADIENT ? w->r->gradient : NULL;
  for (size_t i = 0; i < b->m; i++) {
    real *x = out_row(b, i);
    size_t at = place_of(b, i);
    double square = 0;
    if (b->inside[i]) memset(x, 0, w->channels * w->rows * w->count * sizeof *x);
    for (size_t c = 0; b->out && c < channels; c++) {
      size_t to = (at * channels + c) * w->count;
      write_channel(w, x, (int)c, value ? value + to : NULL, gradient ? gradient + 3 * to : NULL);
    }
    if (w->r->inside) w->r->inside[at] = b->inside[i] | b->any[i];
    if (!w->metric) continue;
    for (int c = 0; c < q->metric_channels; c++)
      for (size_t k = 0; k < w->count; k++) {
        double y = channel(w, x + k, q->metric_channels, c);
        square += y * y;
      }
    if (w->r->norm) ((real *)w->r->norm)[at] = (real)sqrt(square);
    if (w->r->lambda) ((real *)w->r->lambda)[at] = b->inside[i] ? 0 : (real)b->lambda[i];
  }
}
