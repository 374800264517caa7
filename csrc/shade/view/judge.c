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

static bool is_empty(const ylm_shade_view *v, size_t p) {
  return v->pixel[p].first == v->pixel[p + 1].first;
}

/* -- pixels by paths ---------------------------------------------------------------- */

/* The pixels of a view that show surfaces: their places, with their weights. */
typedef struct shown_pixels {
  size_t n;
  size_t *pixel, *first;  /* [n], [n+1]: of its places */
  ylm_scene_place *place; /* [entries] */
  float *weight;          /* [entries] */
  float *sums;            /* [9 n]: mean, rest, variance */
} shown_pixels;

static void free_shown(shown_pixels *x) {
  ylm_free(x->pixel);
  ylm_free(x->first);
  ylm_free(x->place);
  ylm_free(x->weight);
  ylm_free(x->sums);
}

static ylm_status list_shown(const ylm_shade_view *v, shown_pixels *x) {
  size_t pixels = v->stats.pixels, n = v->entries;
  *x = (shown_pixels){.pixel = ylm_alloc(pixels, sizeof *x->pixel),
                      .first = ylm_alloc(pixels + 1, sizeof *x->first),
                      .place = ylm_alloc(n, sizeof *x->place),
                      .weight = ylm_alloc(n, sizeof *x->weight)};
  if (!x->pixel || !x->first || !x->place || !x->weight) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) x->place[i] = v->entry[i].at, x->weight[i] = v->entry[i].weight;
  for (size_t p = 0; p < pixels; p++) {
    if (is_empty(v, p)) continue;
    x->pixel[x->n] = p;
    x->first[x->n++] = v->pixel[p].first;
  }
  x->first[x->n] = n;
  x->sums = ylm_alloc(x->n, 9 * sizeof *x->sums);
  return x->sums ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm_shade_judge_pixels(const ylm_shade_view *v, const ylm_path_options *o,
                                  float (*radiance)[3], float (*variance)[3], ylm_path_stats *stats,
                                  ylm_error *e) {
  shown_pixels x;
  if (v->corner || v->o.share > 0)
    return ylm_fail(e, YLM_EINVAL, "pixels are judged by camera rays that are not grouped");
  memset(radiance, 0, v->stats.pixels * sizeof *radiance);
  if (variance) memset(variance, 0, v->stats.pixels * sizeof *variance);
  ylm_status s = list_shown(v, &x);
  if (s == YLM_OK) {
    ylm_path_sum sum = {0, x.sums, x.sums + 3 * x.n, x.sums + 6 * x.n};
    s = ylm_path_places(v->scene, x.n, x.place, x.first, x.weight, v->frame.from, true, o, &sum,
                        stats, e);
  }
  for (size_t k = 0; s == YLM_OK && k < x.n; k++) {
    float whole = 0;
    for (size_t i = x.first[k]; i < x.first[k + 1]; i++) whole += x.weight[i];
    for (size_t c = 0; c < 3; c++) {
      radiance[x.pixel[k]][c] = whole * (x.sums[3 * k + c] + x.sums[3 * (x.n + k) + c]);
      if (variance) variance[x.pixel[k]][c] = whole * whole * x.sums[3 * (2 * x.n + k) + c];
    }
  }
  free_shown(&x);
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
