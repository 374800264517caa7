/* field.c - a grid as a light field: others may bake from it, or shade by it. */
#include "../grid.h"

#include <math.h>
#include <string.h>

/* Lambda at a point: trilinear between the corners. */
static double sample_lambda(const ylm_grid *g, const double p[3]) {
  double at[3], sum = 0;
  ylm__grid_coordinates(g, p, at);
  const ylm_grid_cell *c = &g->cell[g->cell[ylm__grid_leaf(g, at)].source];
  if (c->corner[0] == YLM_GRID_NONE) return 0; /* a leaf of which nothing is free */
  double edge = ylm__grid_edge(g, c);
  for (int k = 0; k < 8; k++) {
    double w = 1;
    for (int a = 0; a < 3; a++) {
      double t = (at[a] - c->origin[a]) / edge;
      t = t < 0 ? 0 : t > 1 ? 1 : t;
      w *= k >> a & 1 ? t : 1 - t;
    }
    sum += w * (double)g->lambda[c->corner[k]];
  }
  return sum;
}

/* Turns a row of the grid's coefficients into one of the query's: fewer degrees, other channels. */
static void convert_row(const ylm_grid *g, const ylm_field_query *q, const float *from, int step,
                        void *to, size_t at) {
  static const double weight[3] = {YLM_LUMINANCE_R, YLM_LUMINANCE_G, YLM_LUMINANCE_B};
  int count = (q->lmax + 1) * (q->lmax + 1), own = g->contents.count,
      channels = g->contents.form.channels;
  for (int c = 0; c < q->channels; c++)
    for (int j = 0; j < count; j++)
      for (int d = 0; d < step; d++) {
        double x = 0;
        for (int k = 0; k < channels; k++) {
          double share = channels == q->channels ? k == c : channels == 1 ? 1 : weight[k];
          if (share > 0) x += share * (double)from[(k * own + j) * step + d];
        }
        size_t i = (at * (size_t)(q->channels * count) + (size_t)(c * count + j)) * (size_t)step +
                   (size_t)d;
        ylm_put(q->dtype, to, i, x);
      }
}

/* Are results of a query what is sampled? */
static bool is_alike(const ylm_grid *g, const ylm_field_query *q) {
  return q->dtype == YLM_FLOAT && q->channels == g->contents.form.channels &&
         q->lmax == g->contents.form.lmax;
}

/* The query's results from sampled rows. */
static void convert(const ylm_grid *g, const ylm_field_query *q, size_t n, const void *points,
                    const float *value, const float *gradient, ylm_field_result *r) {
  size_t w = g->width;
  bool alike = is_alike(g, q);
  for (size_t i = 0; i < n; i++) {
    if (!alike && q->want & YLM_WANT_VALUE) convert_row(g, q, value + i * w, 1, r->value, i);
    if (!alike && q->want & YLM_WANT_GRADIENT)
      convert_row(g, q, gradient + i * w * 3, 3, r->gradient, i);
    if (r->inside) r->inside[i] = 0;
    if (!(q->want & YLM_WANT_METRIC)) continue;
    double sum = 0, p[3];
    for (size_t j = 0; j < w; j++) sum += (double)value[i * w + j] * (double)value[i * w + j];
    for (size_t a = 0; a < 3; a++)
      p[a] = ylm_get(q->dtype, points, 3 * i + a) + (q->origin ? q->origin[a] : 0);
    if (r->norm) ylm_put(q->dtype, r->norm, i, sqrt(sum));
    if (r->lambda) ylm_put(q->dtype, r->lambda, i, sample_lambda(g, p));
  }
}

ylm_status ylm__grid_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                              const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_grid *g = f->self;
  if (q->lmax > g->contents.form.lmax)
    return ylm_fail(e, YLM_ERANGE, "the grid has coefficients up to lmax %d, %d is wanted",
                    g->contents.form.lmax, q->lmax);
  if (q->want & YLM_WANT_HESSIAN) return ylm_fail(e, YLM_EINVAL, "a grid has no Hessians");
  size_t w = g->width, block = n < 16384 ? n : 16384;
  bool alike = is_alike(g, q), slopes = q->want & YLM_WANT_GRADIENT,
       values_stay = alike && r->value, slopes_stay = alike && r->gradient;
  float *value = values_stay ? NULL : ylm_alloc(block, w * sizeof *value);
  float *gradient = slopes && !slopes_stay ? ylm_alloc(block, 3 * w * sizeof *gradient) : NULL;
  ylm_status s =
      (value || values_stay) && (gradient || !slopes || slopes_stay) ? YLM_OK : YLM_ENOMEM;
  ylm_grid_query own = {
      .point_dtype = q->dtype, .dtype = YLM_FLOAT, .threads = q->threads, .origin = q->origin};
  for (size_t i = 0; i < n && s == YLM_OK; i += block) {
    size_t now = n - i < block ? n - i : block, size = ylm_dtype_size(q->dtype);
    size_t k = i * (size_t)(q->channels * (q->lmax + 1) * (q->lmax + 1)) * size;
    const char *p = (const char *)points + 3 * i * size;
    ylm_field_result part = {.value = r->value ? (char *)r->value + k : NULL,
                             .gradient = r->gradient ? (char *)r->gradient + 3 * k : NULL,
                             .lambda = r->lambda ? (char *)r->lambda + i * size : NULL,
                             .norm = r->norm ? (char *)r->norm + i * size : NULL,
                             .inside = r->inside ? r->inside + i : NULL};
    float *v = values_stay ? part.value : value;
    float *slope = slopes && slopes_stay ? part.gradient : gradient;
    s = ylm_grid_sample(g, &own, now, p, v, slope, NULL, e);
    if (s == YLM_OK) convert(g, q, now, p, v, slope, &part);
    if (s == YLM_OK) s = ylm_report(q->progress, i + now, n, "sampling");
  }
  ylm_free(value);
  ylm_free(gradient);
  return s == YLM_ENOMEM ? ylm_fail(e, s, "no memory to sample %zu points", n) : s;
}

const ylm_field *ylm_grid_field(const ylm_grid *g) { return &g->field; }
