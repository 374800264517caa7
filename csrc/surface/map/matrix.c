/*
** matrix.c - rows of places, differences and seams as a matrix of a picture.
**
** Look-ups read squares of two by two texels, so rows of places join texels to their eight neighbours alone. Rows of seams
** stay rows.
*/
#include "map.h"

void ylm__map_matrix_free(map_matrix *a) {
  ylm_free(a->pair), ylm_free(a->line), ylm_free(a->scale);
  *a = (map_matrix){.pair = NULL};
}

/* Adds to the entry of two texels of one square. */
static void add_pair(const map_bake *b, size_t p, size_t q, double x) {
  size_t first = p < q ? p : q, step = p < q ? q - p : p - q;
  size_t k = step < 2 ? step : step + 3 - b->width; /* 0, 1; width - 1, width, width + 1: 2, 3, 4 */
  b->matrix.pair[k * b->texels + first] += (float)x;
}

/* Mean weights of the rows that read a texel, or else of its chart, or of all. */
static ylm_status find_scales(map_bake *b) {
  float *scale = b->matrix.scale;
  double *sum = ylm_alloc_zero(b->texels, sizeof *sum),
         (*chart)[2] = ylm_alloc_zero(b->charts + 1, sizeof *chart);
  bool ok = sum && chart;
  for (size_t i = 0; ok && i < b->sites; i++) {
    const map_site *s = &b->site[i];
    if (!map_counts(s)) continue;
    double w = (double)s->weight;
    for (int k = 0; k < 4; k++) {
      scale[s->tap.texel[k]] += (float)w * s->tap.weight[k];
      sum[s->tap.texel[k]] += (double)s->tap.weight[k];
    }
    for (size_t k = 0; k < 2; k++) {
      size_t of = k ? b->charts : s->chart;
      chart[of][0] += w;
      chart[of][1]++;
    }
  }
  for (size_t i = 0; ok && i < b->texels; i++) {
    if (b->chart[i] == YLM_UNWRAP_NONE) continue;
    const double *of = chart[b->chart[i]];
    if (!(of[1] > 0)) of = chart[b->charts];
    scale[i] = (float)(sum[i] > 0.05 ? (double)scale[i] / sum[i] : of[1] > 0 ? of[0] / of[1] : 0);
  }
  ylm_free(sum);
  ylm_free(chart);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* Differences of texels, and where bends are. */
static void add_lines(map_bake *b) {
  for (size_t i = 0; i < b->texels; i++)
    for (size_t axis = 0; axis < 2; axis++) {
      size_t step = axis ? b->width : 1, at = axis ? i / b->width : i % b->width;
      size_t last = axis ? b->height : b->width;
      if (b->chart[i] == YLM_UNWRAP_NONE || at + 1 >= last || b->chart[i + step] != b->chart[i])
        continue;
      double w = MAP_LEVEL * (double)b->matrix.scale[i];
      add_pair(b, i, i, w);
      add_pair(b, i + step, i + step, w);
      add_pair(b, i, i + step, -w);
      if (at > 0 && b->chart[i - step] == b->chart[i])
        b->matrix.line[axis * b->texels + i] = b->matrix.scale[i];
    }
}

ylm_status ylm__map_matrix(map_bake *b) {
  map_matrix *a = &b->matrix;
  ylm__map_matrix_free(a);
  a->pair = ylm_alloc_zero(5 * b->texels, sizeof *a->pair);
  a->line = ylm_alloc_zero(2 * b->texels, sizeof *a->line);
  a->scale = ylm_alloc_zero(b->texels, sizeof *a->scale);
  if (!a->pair || !a->line || !a->scale) return YLM_ENOMEM;
  ylm_status s = find_scales(b);
  for (size_t i = 0; s == YLM_OK && i < b->sites; i++) {
    const map_site *x = &b->site[i];
    if (!map_counts(x)) continue;
    double w = (double)x->weight;
    for (int p = 0; p < 4; p++)
      for (int q = p; q < 4; q++) {
        double both = w * (double)x->tap.weight[p] * (double)x->tap.weight[q];
        bool twice = q != p && x->tap.texel[p] == x->tap.texel[q];
        if (both > 0) add_pair(b, x->tap.texel[p], x->tap.texel[q], twice ? 2 * both : both);
      }
  }
  if (s == YLM_OK) add_lines(b);
  return s;
}
