/* judge.c - what paths say of shading points, and how far other estimates are from it. */
#include <math.h>

#include "../view.h"

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
  if (s == YLM_OK)
    s = ylm_path_places(v->scene, n, place, NULL, NULL, v->frame.from, true, o, &sum, stats, e);
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

/* A channel of pixel p. */
static double sum_pixel(const ylm_shade_view *v, size_t p, size_t c, const float *radiance) {
  double sum = 0;
  for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++)
    sum += (double)v->entry[i].weight * (double)radiance[3 * i + c];
  return sum;
}

/* The variance of that sum. */
static double pixel_variance(const ylm_shade_view *v, size_t p, size_t c, const float *variance) {
  double sum = 0;
  for (size_t i = v->pixel[p].first; variance && i < v->pixel[p + 1].first; i++)
    sum += (double)v->entry[i].weight * (double)v->entry[i].weight * (double)variance[3 * i + c];
  return sum;
}

static bool is_empty(const ylm_shade_view *v, size_t p) {
  return v->pixel[p].first == v->pixel[p + 1].first;
}

/* The mean over channels of products of differences in pixel p; adds b to *sum. */
static double product(const ylm_shade_estimate *a, const ylm_shade_estimate *b,
                      const float *variance, size_t p, double *sum) {
  double square = 0;
  for (size_t c = 0; c < 3; c++) {
    double second = sum_pixel(b->view, p, c, b->radiance);
    double first = sum_pixel(a->view, p, c, a->radiance) - second, other = first;
    if (a->again || b->again)
      other = sum_pixel(a->view, p, c, a->again ? a->again : a->radiance) -
              sum_pixel(b->view, p, c, b->again ? b->again : b->radiance);
    square += (first * other - pixel_variance(b->view, p, c, variance)) / 3;
    *sum += second / 3;
  }
  return square;
}

ylm_status ylm_shade_compare(const ylm_shade_estimate *a, const ylm_shade_estimate *b,
                             const float *variance, const double *weight, ylm_shade_error *out) {
  double spread = 0, weights = 0;
  *out = (ylm_shade_error){0};
  if (a->view->corner || b->view->corner) return YLM_EINVAL;
  if (a->view->stats.pixels != b->view->stats.pixels) return YLM_ESHAPE;
  for (size_t p = 0; p < a->view->stats.pixels; p++) {
    if (is_empty(a->view, p) && is_empty(b->view, p)) continue;
    double mean = 0, w = weight ? weight[p] : 1, square = product(a, b, variance, p, &mean);
    out->pixels++;
    out->mean += w * mean;
    out->square += w * square;
    weights += w;
    spread += w * square * square;
  }
  double n = out->pixels > 0 ? weights : 1;
  out->mean /= n;
  out->square /= n;
  out->uncertainty = sqrt(fmax(0, spread / n - out->square * out->square) /
                          (out->pixels > 0 ? (double)out->pixels : 1));
  return YLM_OK;
}
