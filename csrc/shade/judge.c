/* judge.c - what paths say of shading points, and how far other estimates are from it. */
#include <math.h>

#include "view.h"

/* A point has the mean tint of a pixel's samples, the judge that of its place. */
static void exchange_tints(const ylm_shade_view *v, size_t i, const ylm_scene_surface *at,
                           float *mean, float *variance) {
  for (int c = 0; c < 3; c++) {
    float ratio = at->tint[c] > 0 ? v->tint[i][c] / at->tint[c] : 0;
    mean[c] *= ratio;
    variance[c] *= ratio * ratio;
  }
}

ylm_status ylm_shade_judge(const ylm_shade_view *v, const ylm_path_options *o, float *mean,
                           float *variance, ylm_path_stats *stats, ylm_error *e) {
  if (v->corner) return ylm_fail(e, YLM_EINVAL, "points at vertices are not judged");
  size_t n = v->points;
  ylm_scene_place *place = ylm_alloc(n, sizeof *place);
  float *rest = ylm_alloc_zero(n, 12);
  ylm_path_sum sum = {0, mean, rest, variance};
  ylm_status s = place && rest ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) place[i] = v->entry[i].at;
  if (s == YLM_OK) s = ylm_path_places(v->scene, n, place, v->frame.from, true, o, &sum, stats, e);
  for (size_t i = 0; s == YLM_OK && v->tint && i < n; i++) {
    ylm_scene_surface at;
    ylm_scene_surfaces(v->scene, 1, &place[i], &at);
    exchange_tints(v, i, &at, mean + 3 * i, variance + 3 * i);
  }
  ylm_free(place);
  ylm_free(rest);
  return s;
}

/* -- errors ----------------------------------------------------------------------- */

/* One channel of a pixel: sums over its entries of a, b and the variance of b. */
typedef struct pixel_sum {
  double a, b, variance;
} pixel_sum;

static pixel_sum sum_pixel(const ylm_shade_view *v, const shade_pixel *q, size_t c, const float *a,
                           const float *b, const float *variance) {
  pixel_sum s = {0, 0, 0};
  for (size_t i = q[0].first; i < q[1].first; i++) {
    double w = (double)v->entry[i].weight;
    s.a += w * (double)a[3 * i + c];
    s.b += w * (double)b[3 * i + c];
    if (variance) s.variance += w * w * (double)variance[3 * i + c];
  }
  return s;
}

/* The variance of a channel of a pixel that other camera rays would leave: a stretch of edge crosses some
   2 sqrt(N) of N strata, and each of these takes the one side or the other by chance; the part without surfaces counts as black. */
static double edge_variance(const ylm_shade_view *v, const shade_pixel *q, size_t c, double sum,
                            const float *a) {
  double n = v->o.samples, between = fmax(0, 1 - (double)q->coverage) * sum * sum;
  for (size_t i = q[0].first; i < q[1].first; i++) {
    double d = (double)a[3 * i + c] - sum;
    between += (double)v->entry[i].weight * d * d;
  }
  return 2 * between / (n * sqrt(n));
}

ylm_status ylm_shade_compare(const ylm_shade_view *v, const float *a, const float *b,
                             const float *variance, ylm_shade_error *out) {
  double spread = 0;
  *out = (ylm_shade_error){0};
  if (v->corner) return YLM_EINVAL;
  for (size_t p = 0; p < v->stats.pixels; p++) {
    const shade_pixel *q = &v->pixel[p];
    double square = 0;
    if (q[1].first == q[0].first) continue;
    for (size_t c = 0; c < 3; c++) {
      pixel_sum s = sum_pixel(v, q, c, a, b, variance);
      square += ((s.a - s.b) * (s.a - s.b) - s.variance) / 3;
      out->mean += s.b / 3;
      out->edges += edge_variance(v, q, c, s.a, a) / 3;
    }
    out->pixels++;
    out->square += square;
    spread += square * square;
  }
  double n = out->pixels > 0 ? (double)out->pixels : 1;
  out->mean /= n;
  out->square /= n;
  out->edges /= n;
  out->uncertainty = sqrt(fmax(0, spread / n - out->square * out->square) / n);
  return YLM_OK;
}
