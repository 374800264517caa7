/* point.c - what a dynamic grid keeps of each point. */
#include "follow.h"

#include <math.h>
#include <string.h>

#include "ylm_image.h"
#include "ylm_list.h"

ylm_status ylm__dynamic_reserve(ylm_grid *g) {
  grid_dynamic *d = g->dynamic;
  if (g->points <= d->room) return YLM_OK;
  size_t was = d->room, room = g->points + g->points / 4, row = d->hessians * sizeof(float);
  if (room > SIZE_MAX / (row + 8)) return YLM_ENOMEM;
  if (row && !ylm_list_resize(&d->hessian, was, room, row)) return YLM_ENOMEM;
  if (!ylm_list_resize(&d->sign, was, room, sizeof *d->sign)) return YLM_ENOMEM;
  if (!ylm_list_resize(&d->size, was, room, sizeof *d->size) ||
      !ylm_list_resize(&d->drift, was, room, sizeof *d->drift))
    return YLM_ENOMEM;
  for (size_t m = 0; m < d->movers; m++)
    if (!ylm_list_resize(&d->mover[m].seen, was, room, 1)) return YLM_ENOMEM;
  d->room = room;
  return YLM_OK;
}

/* Writes a block's Hessians, of one channel of the metric or a mixture of three. */
static void put_hessian(ylm_grid *g, uint32_t p, const field_block *k, size_t i) {
  static const float luminance[3] = {(float)YLM_LUMINANCE_R, (float)YLM_LUMINANCE_G,
                                     (float)YLM_LUMINANCE_B};
  grid_dynamic *d = g->dynamic;
  if (!d->hessians) return;
  size_t count = (size_t)g->contents.count, channels = (size_t)g->contents.form.metric_channels;
  const float *from = k->hessian + i * 6 * (size_t)g->contents.form.channels * count;
  float *to = d->hessian + p * d->hessians;
  bool mix = g->contents.form.channels == 3 && channels == 1;
  for (size_t c = 0; c < channels; c++)
    for (size_t j = 0; j < count; j++, from += 6)
      for (size_t a = 0; a < 6; a++) {
        float x = from[a];
        if (mix)
          x = luminance[0] * x + luminance[1] * from[6 * count + a] +
              luminance[2] * from[12 * count + a];
        to[(6 * c + a) * count + j] = x;
      }
}

static double norm_of(const float *row, size_t n) {
  double s[4] = {0};
  size_t i = 0;
  for (; i + 4 <= n; i += 4)
    for (size_t k = 0; k < 4; k++) s[k] += (double)row[i + k] * (double)row[i + k];
  for (; i < n; i++) s[0] += (double)row[i] * (double)row[i];
  return sqrt((s[0] + s[1]) + (s[2] + s[3]));
}

static void all_current(grid_dynamic *d, uint32_t p) {
  for (size_t m = 0; m < d->movers; m++) d->mover[m].seen[p] = (uint8_t)d->mover[m].current;
}

void ylm__dynamic_store(ylm_grid *g, uint32_t p, const field_block *k, size_t i) {
  grid_dynamic *d = g->dynamic;
  put_hessian(g, p, k, i);
  d->size[p] = (float)norm_of(ylm__grid_row(g, p, 0), g->width);
  d->drift[p] = 0;
  ylm__dynamic_sign(g, p);
  all_current(d, p);
}

/* Numbers that come in groups of n as n rows. */
static void part(const float *from, size_t n, size_t count, float *restrict to) {
  for (size_t i = 0; i < count; i++)
    for (size_t a = 0; a < n; a++) to[a * count + i] = from[n * i + a];
}

static void add_scaled(float *restrict to, float scale, const float *restrict x, size_t n) {
  for (size_t i = 0; i < n; i++) to[i] += scale * x[i];
}

/* Weights of a light's unit field in the `channels` of a grid. */
static void channel_weights(const double colour[3], int channels, float out[3]) {
  for (int c = 0; c < 3; c++) out[c] = (float)colour[c];
  if (channels == 1) out[0] = (float)ylm_luminance(colour);
}

void ylm__dynamic_add(ylm_grid *g, uint32_t p, const point_change *x, float *room) {
  size_t count = (size_t)g->contents.count, channels = (size_t)g->contents.form.channels;
  double exact[3], length = 0;
  float weight[3], *value = room, *slope = room + count, *second = room + 4 * count;
  float *to = g->data + (size_t)p * 4 * g->stride;
  grid_dynamic *d = g->dynamic;
  ylm_grid_position(g, g->lattice + 3 * (size_t)p, exact);
  memcpy(value, x->value, count * sizeof *value);
  part(x->gradient, 3, count, slope);
  /* asked at a position rounded to float */
  for (size_t a = 0; a < 3; a++)
    add_scaled(value, (float)(exact[a] - g->origin[a] - (double)x->position[a]), slope + a * count,
               count);
  channel_weights(x->colour, g->contents.form.channels, weight);
  for (size_t c = 0; c < channels; c++) {
    length += (double)weight[c] * (double)weight[c];
    for (size_t r = 0; r < 4; r++)
      add_scaled(to + r * g->stride + c * count, weight[c], room + r * count, count);
  }
  double change = sqrt(length) * norm_of(value, count);
  d->drift[p] += (float)(ROUNDING * ((double)d->size[p] + change));
  d->size[p] += (float)change; /* a bound, until it is measured */
  if (!d->hessians) return;
  part(x->hessian, 6, count, second);
  channel_weights(x->colour, g->contents.form.metric_channels, weight);
  for (size_t c = 0; c < d->hessians / (6 * count); c++)
    add_scaled(d->hessian + p * d->hessians + 6 * count * c, weight[c], second, 6 * count);
}

/* The norm of luminance of a row of three channels. */
static double luminance_norm(const float *restrict row, size_t count) {
  double s[2] = {0};
  for (size_t i = 0; i < count; i++) {
    double x = ylm_luminance((const double[]){row[i], row[count + i], row[2 * count + i]});
    s[i & 1] += x * x;
  }
  return sqrt(s[0] + s[1]);
}

void ylm__dynamic_measure(ylm_grid *g, uint32_t p, ylm_light_lambda2_fn *lambda2) {
  grid_dynamic *d = g->dynamic;
  const float *row = ylm__grid_row(g, p, 0);
  size_t count = (size_t)g->contents.count, all = 6 * count;
  double lambda = 0;
  d->size[p] = (float)norm_of(row, g->width);
  ylm__dynamic_sign(g, p);
  if (!d->hessians) return;
  for (size_t i = 0; i < d->hessians; i += all)
    lambda += (double)lambda2(count, d->hessian + p * d->hessians + i);
  bool mix = g->contents.form.channels == 3 && g->contents.form.metric_channels == 1;
  g->lambda[p] = (float)sqrt(lambda);
  g->norm[p] = mix ? (float)luminance_norm(row, count) : d->size[p];
}

void ylm__dynamic_move(ylm_grid *g, uint32_t from, uint32_t to) {
  grid_dynamic *d = g->dynamic;
  memcpy(g->lattice + 3 * (size_t)to, g->lattice + 3 * (size_t)from, 3 * sizeof *g->lattice);
  memcpy(g->data + (size_t)to * 4 * g->stride, g->data + (size_t)from * 4 * g->stride,
         4 * g->stride * sizeof *g->data);
  g->lambda[to] = g->lambda[from];
  g->norm[to] = g->norm[from];
  g->flags[to] = g->flags[from];
  if (d->hessians)
    memcpy(d->hessian + to * d->hessians, d->hessian + from * d->hessians,
           d->hessians * sizeof *d->hessian);
  d->size[to] = d->size[from];
  d->drift[to] = d->drift[from];
  d->sign[to] = d->sign[from];
  for (size_t m = 0; m < d->movers; m++) d->mover[m].seen[to] = d->mover[m].seen[from];
}
