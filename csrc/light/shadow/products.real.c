/* products.real.c - light times what casters let through, at the nodes of a rule: a tile of lanes at a time. */
#include "block.h"

#include <math.h>
#include <string.h>

#ifdef YLM_REAL_IS_FLOAT
#define SUMS(w, n, out, a, b, c, d) (w)->sums(n, out, a, b, c, d)
#else
#define SUMS(w, n, out, a, b, c, d)                                                                \
  for (size_t i_ = 0; i_ < (n); i_++) (out)[i_] = (a)[i_] * (b)[i_] + (c)[i_] * (d)[i_]
#endif

/* Adds what a caster hides, of its visibility v, to the row of a layer. */
static void add_hidden(const shadow_query *w, const shadow_part *x, const real *restrict v,
                       real *restrict to) {
  size_t n = w->count;
  real weight = (real)x->weight, first = v[0] - (real)LIGHT_ONE;
  to[0] += weight * first;
  for (size_t i = 1; i < n; i++) to[i] += weight * v[i];
  for (size_t d = 1; d < w->rows; d++) {
    const real *restrict g = v + d * n;
    real *restrict out = to + d * n, slope = (real)x->slope[d - 1];
    out[0] += weight * g[0] + slope * first;
    if (slope == 0)
      for (size_t i = 1; i < n; i++) out[i] += weight * g[i];
    else
      for (size_t i = 1; i < n; i++) out[i] += weight * g[i] + slope * v[i];
  }
}

/* The row of a layer in a lane: what it points to, or is put together at `to`. */
static const real *layer_row(const tile *t, size_t lane, int layer, real *to) {
  const block *b = t->b;
  const shadow_query *w = b->w;
  const shadow_term *term = t->term[lane];
  size_t row = w->rows * w->count, found = 0;
  const shadow_before *only = NULL;
  if (b->layered)
    return (size_t)layer < term->layers ? b->layers + (term->row + (size_t)layer) * row : NULL;
  for (size_t k = 0; k < term->n; k++)
    if (b->before[term->first + k].layer == layer) only = &b->before[term->first + k], found++;
  if (!found) return NULL;
  if (found == 1 && b->part[only->part].weight == 1)
    return b->hidden + b->seen[only->seen].row * row;
  memset(to, 0, row * sizeof *to);
  to[0] = (real)LIGHT_ONE;
  for (size_t k = 0; k < term->n; k++) {
    const shadow_before *x = &b->before[term->first + k];
    if (x->layer == layer)
      add_hidden(w, &b->part[x->part], b->hidden + b->seen[x->seen].row * row, to);
  }
  return to;
}

void SHADOW(to_nodes)(const tile *t, const real *const *row, size_t d, bool multiply, real *to) {
  const void *at[16];
  for (size_t i = 0; i < t->lanes; i++)
    at[i] = row[i] ? row[i] + d * t->b->w->count : d ? t->zero : t->unit;
  ylm_sh_nodes_synthesise(t->b->w->nodes, DTYPE, at, multiply, to, t->scratch);
}

/* f and its derivatives, cut off at lmax. */
static void cut_off(const tile *t, real *f) {
  const void *in[16];
  void *out[16];
  for (size_t i = 0; i < t->lanes; i++) in[i] = out[i] = t->result + i * t->b->w->count;
  ylm_sh_nodes_analyse(t->b->w->nodes, DTYPE, f, NULL, out, t->scratch);
  ylm_sh_nodes_synthesise(t->b->w->nodes, DTYPE, in, false, f, t->scratch);
}

static void multiply_layer(const tile *t, int layer) {
  const shadow_query *w = t->b->w;
  const real *row[16];
  bool cut = w->s->form.product == YLM_SHADOW_PRODUCT_recursive && layer > 0;
  for (size_t i = 0; i < t->lanes; i++)
    row[i] = layer_row(t, i, layer, t->row + i * w->rows * w->count);
  if (w->rows == 1 || layer == 0)
    SHADOW(to_nodes)(t, row, 0, layer > 0, t->f);
  else
    SHADOW(to_nodes)(t, row, 0, false, t->one);
  for (size_t d = 1; d < w->rows; d++) {
    real *g = t->g[d - 1];
    if (layer == 0) {
      SHADOW(to_nodes)(t, row, d, false, g);
      continue;
    }
    SHADOW(to_nodes)(t, row, d, false, t->two);
    SUMS(w, t->values, g, g, t->one, t->f, t->two);
    if (cut) cut_off(t, g);
  }
  for (size_t i = 0; w->rows > 1 && layer > 0 && i < t->values; i++) t->f[i] *= t->one[i];
  if (cut) cut_off(t, t->f);
}

/* Derivative d of the light in channel c at the point of a lane. */
static real *result_of(const tile *t, size_t lane, size_t c, size_t d) {
  const shadow_query *w = t->b->w;
  return out_row(t->b, t->term[lane]->point) + (c * w->rows + d) * w->count;
}

/* Coefficients of `f`, times `by` at each node unless it is NULL, of channel c and derivative d, are added to the results of the
   lanes' points; written where these have nothing else. */
static void add_result(const tile *t, const real *f, const real *by, size_t c, size_t d) {
  block *b = t->b;
  const shadow_query *w = b->w;
  void *out[16];
  for (size_t i = 0; i < t->lanes; i++)
    out[i] = w->s->local || i >= t->n ? t->result + i * w->count : result_of(t, i, c, d);
  ylm_sh_nodes_analyse(w->nodes, DTYPE, f, by, out, t->scratch);
  for (size_t i = 0; w->s->local && i < t->n; i++) {
    const shadow_term *term = t->term[i];
    real *to = result_of(t, i, c, d);
    const real *from = t->result + i * w->count,
               *light = light_row(b, term->light, c) + d * w->count;
    for (size_t k = 0; k < w->count; k++) to[k] += term->again ? from[k] - light[k] : from[k];
  }
}

/* Adds to lambda of the lanes' points: the largest light at nodes times lambda of visibilities. light NULL: even light. */
static void add_metric(const tile *t, const real *light, size_t c, double (*most)[3]) {
  block *b = t->b;
  for (size_t lane = 0; lane < t->n; lane++) {
    most[lane][c] = light ? SHADOW(largest)(light, t->values, t->lanes, lane) : b->w->even_most[c];
    if (c + 1 < b->w->channels) continue;
    const shadow_term *term = t->term[lane];
    double blur = 0, *m = most[lane];
    for (size_t k = 0; k < term->n; k++) {
      const shadow_before *x1 = &b->before[term->first + k];
      blur += x1->layer < 0 ? 0 : b->part[x1->part].weight * b->blur[x1->seen];
    }
    double peak = b->w->channels == 1             ? m[0]
                  : b->w->q->metric_channels == 3 ? sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2])
                                                  : ylm__emission(m, 1, 0);
    b->lambda[term->point] += peak * blur;
  }
}

/* The lanes' light in channel c times what they let through, to the results. */
static void add_light(const tile *t, size_t c, double (*most)[3]) {
  const shadow_query *w = t->b->w;
  const real *row[16];
  for (size_t i = 0; i < t->lanes; i++) row[i] = light_row(t->b, t->term[i]->light, c);
  SHADOW(to_nodes)(t, row, 0, false, t->one);
  if (w->metric) add_metric(t, t->one, c, most);
  for (size_t d = 1; d < w->rows; d++) {
    SHADOW(to_nodes)(t, row, d, false, t->two);
    SUMS(w, t->values, t->two, t->g[d - 1], t->one, t->f, t->two);
    add_result(t, t->two, NULL, c, d);
  }
  for (size_t i = 0; i < t->values; i++) t->one[i] *= t->f[i];
  add_result(t, t->one, NULL, c, 0);
}

/* As add_light, where the light of all lanes is even. */
static void add_even_light(const tile *t, size_t c, double (*most)[3]) {
  const shadow_query *w = t->b->w;
  const real *light = even_nodes(w, c);
  if (w->metric) add_metric(t, NULL, c, most);
  for (size_t d = 0; d < w->rows; d++) add_result(t, d ? t->g[d - 1] : t->f, light, c, d);
}

static ylm_status run_tile(tile *t) {
  const shadow_query *w = t->b->w;
  size_t layers = 0;
  bool even = true;
  double most[16][3];
  for (size_t i = 0; i < t->n; i++)
    layers = t->term[i]->layers > layers ? t->term[i]->layers : layers;
  for (size_t i = t->n; i < t->lanes; i++) t->term[i] = t->term[t->n - 1];
  if (w->exponential) {
    ylm_status s = SHADOW(exponentials)(t);
    if (s != YLM_OK) return s;
  } else if (!layers) {
    for (size_t i = 0; i < t->values; i++) t->f[i] = 1;
    for (size_t d = 0; d + 1 < w->rows; d++) memset(t->g[d], 0, t->values * sizeof(real));
  }
  for (size_t k = 0; k < layers; k++) multiply_layer(t, (int)k);
  if (!w->exponential) SHADOW(multiply_spheres)(t);
  for (size_t i = 0; i < t->lanes; i++) even = even && t->term[i]->light == SHADOW_EVEN;
  for (size_t c = 0; c < w->channels; c++) (even ? add_even_light : add_light)(t, c, most);
  return YLM_OK;
}

/* The coefficient of 1 of which values at nodes are exactly 1, so that lanes without a layer do not change. */
static real unit_row(void) {
  const real each = (real)(1 / LIGHT_ONE), one = (real)LIGHT_ONE, step = one * REAL_EPSILON / 2;
  for (int i = -2; i <= 2; i++) {
    real x = one + (real)i * step;
    if (x * each == 1) return x;
  }
  return one;
}

ylm_status SHADOW(multiply)(block *b) {
  const shadow_query *w = b->w;
  size_t lanes = ylm_sh_nodes_lanes(w->nodes, DTYPE), nodes = ylm_sh_nodes_count(w->nodes),
         most = 0;
  if (!b->terms) return YLM_OK;
  tile t = {.b = b, .lanes = lanes, .values = lanes * nodes};
  size_t rows = w->rows * w->count, values = sixteens(t.values),
         scratch = ylm_sh_nodes_scratch(w->nodes, DTYPE);
  size_t gradients = w->rows > 1 ? 3 : 0;
  size_t profiles = w->s->spheres ? (1 + lanes) * w->rows * w->rings->padded : 0;
  t.f = room(b, ROOM_TILE,
             (3 + gradients) * values + lanes * (rows + w->count) + 2 * w->count + profiles + 64);
  t.scratch = room(b, ROOM_SCRATCH, (scratch + sizeof(real) - 1) / sizeof(real));
  if (!t.f || !t.scratch) return YLM_ENOMEM;
  t.one = t.f + values;
  t.two = t.one + values;
  for (size_t d = 0; d < gradients; d++) t.g[d] = t.two + (d + 1) * values;
  t.row = t.two + (gradients + 1) * values;
  t.result = t.row + lanes * rows;
  t.unit = t.result + lanes * w->count;
  t.zero = t.unit + w->count;
  t.profile = t.zero + w->count;
  memset(t.unit, 0, 2 * w->count * sizeof *t.unit);
  t.unit[0] = unit_row();
  for (size_t i = 0; i < b->terms; i++) most = b->term[i].layers > most ? b->term[i].layers : most;
  ylm_status s = YLM_OK;
  for (size_t left = most + 1; left-- > 0;)
    for (size_t i = 0; i < b->terms && s == YLM_OK; i++) {
      if (b->term[i].layers != left) continue;
      t.term[t.n++] = &b->term[i];
      if (t.n == lanes) s = run_tile(&t), t.n = 0;
    }
  if (t.n && s == YLM_OK) s = run_tile(&t);
  return s;
}

double SHADOW(largest)(const real *light, size_t values, size_t lanes, size_t lane) {
  real x = 0;
  for (size_t i = lane; i < values; i += lanes) {
    real y = light[i] < 0 ? -light[i] : light[i];
    x = y > x ? y : x;
  }
  return (double)x;
}
