/*
** density.c - how dense the texels of charts are: by what they miss, and how that falls with their density.
**
** A chart of area A misses a square error q at density d, and q (x)^-p at x d. The sum of A q x^-p over charts is least for a
** number of texels where p q x^-(p+2) / d^2 is the same for all.
*/
#include "map.h"

/* The product of what the two halves miss of a site, each of its own light: its noise cancels, as the halves share none. */
static double product(const map_bake *b, const map_site *s) {
  double sum = 0, w = (double)s->weight;
  for (int c = 0; c < 3; c++)
    sum += (map_value(b, b->value, 0, s, c) - (double)s->light.a[c]) *
           (map_value(b, b->value, 1, s, c) - (double)s->light.b[c]) * w / 3;
  return sum;
}

void ylm__map_products(const map_bake *b, double *out) {
  for (size_t i = 0; i < b->sites; i++)
    out[i] = map_counts(&b->site[i]) ? product(b, &b->site[i]) : 0;
}

void ylm__map_sum(const map_bake *b, const double *values, float *sum, float *count) {
  for (size_t i = 0; i < b->sites; i++) {
    const map_site *s = &b->site[i];
    for (int k = 0; map_counts(s) && k < 4; k++) {
      sum[s->tap.texel[k]] += s->tap.weight[k] * (float)values[i];
      count[s->tap.texel[k]] += s->tap.weight[k];
    }
  }
}

double ylm__map_mean_at(const map_site *s, const float *sum, const float *count) {
  double a = 0, n = 0;
  for (int k = 0; map_counts(s) && k < 4; k++) {
    a += (double)(s->tap.weight[k] * sum[s->tap.texel[k]]);
    n += (double)(s->tap.weight[k] * count[s->tap.texel[k]]);
  }
  return n > 0 ? a / n : 0;
}

ylm_status ylm__map_bound(const map_bake *b, double *products) {
  float *sum = ylm_alloc_zero(2 * b->texels, sizeof *sum);
  if (!sum) return YLM_ENOMEM;
  float *count = sum + b->texels;
  ylm__map_sum(b, products, sum, count);
  double most = MAP_BOUND * MAP_BOUND * b->aim * b->aim;
  for (size_t i = 0; i < b->sites; i++) { /* odd, so that noise has a mean of about 0 yet */
    double x = ylm__map_mean_at(&b->site[i], sum, count);
    products[i] = x / (1 + fabs(x) / most);
  }
  ylm_free(sum);
  return YLM_OK;
}

ylm_status ylm__map_square(const map_bake *b, const double *products, double *square) {
  double(*sum)[3] = ylm_alloc_zero(b->charts, sizeof *sum);
  if (!sum) return YLM_ENOMEM;
  for (size_t i = 0; i < b->sites; i++) {
    const map_site *s = &b->site[i];
    if (!map_counts(s)) continue;
    sum[s->chart][0]++;
    sum[s->chart][1] += products[i];
    sum[s->chart][2] += products[i] * products[i];
  }
  for (size_t i = 0; i < b->charts; i++) { /* at least what the mean may be off by */
    double n = sum[i][0];
    square[i] = n > 0 ? fmax(sum[i][1] / n, sqrt(sum[i][2]) / n) : 0;
  }
  ylm_free(sum);
  return YLM_OK;
}

void ylm__map_slopes(map_bake *b, const double *coarse) {
  for (size_t i = 0; i < b->charts; i++) {
    double p = b->square[i] > 0 && coarse[i] > 0 ? log2(coarse[i] / b->square[i]) : 2;
    b->slope[i] = fmin(fmax(p, MAP_SLOPE_LEAST), MAP_SLOPE_MOST);
  }
}

void ylm__map_spread(map_bake *b) {
  double area = 0, texels = 0, mean, wanted = 0;
  for (size_t i = 0; i < b->charts; i++) {
    double one = ylm_unwrap_area(b->m->charts, i);
    area += one;
    texels += one * b->density[i] * b->density[i];
    wanted += one * b->square[i];
  }
  mean = sqrt(texels / area);
  double low = 1e-30, high = 1e30, least = 1e-4 * wanted / area;
  double *next = ylm_alloc(b->charts, sizeof *next);
  for (int step = 0; next && step < 200; step++) { /* the price of a texel */
    double price = sqrt(low * high), sum = 0;
    for (size_t i = 0; i < b->charts; i++) {
      double p = b->slope[i], d = b->density[i];
      double x = pow(p * (b->square[i] + least) / (d * d) / price, 1 / (p + 2));
      next[i] = fmin(fmax(d * x, MAP_SPARSEST * mean), MAP_DENSEST * mean);
      sum += ylm_unwrap_area(b->m->charts, i) * next[i] * next[i];
    }
    if (sum > texels)
      low = price;
    else
      high = price;
  }
  if (next) memcpy(b->density, next, b->charts * sizeof *next);
  ylm_free(next);
}
