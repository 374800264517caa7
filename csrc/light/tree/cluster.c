/* cluster.c - the moments of a node's lights. */
#include "proxy.h"

#include <math.h>

#include "ylm_image.h"

static double magnitude(const ylm__lamp_d *l) { return ylm_luminance_size(l->rgb); }

void ylm__tree_add(double m[MOMENTS], double e, const double *x, double r2) {
  int k2 = M2, k3 = M3;
  m[M0] += e;
  m[MR0] += e * r2;
  for (int a = 0; a < 3; a++) {
    m[M1 + a] += e * x[a];
    m[MR1 + a] += e * r2 * x[a];
    for (int b = a; b < 3; b++) {
      m[k2++] += e * x[a] * x[b];
      for (int c = b; c < 3; c++) m[k3++] += e * x[a] * x[b] * x[c];
    }
  }
}

void ylm__tree_add_fourth(double m[15], double w, const double *x) {
  int k = 0;
  for (int a = 0; a < 3; a++)
    for (int b = a; b < 3; b++)
      for (int c = b; c < 3; c++)
        for (int d = c; d < 3; d++) m[k++] += w * x[a] * x[b] * x[c] * x[d];
}

/* The weighted centroid of n lights; the mean of their centres where nothing emits. */
static void find_centroid(cluster *q, const ylm__lamp_d *lamps, const uint32_t *order, size_t n) {
  double plain[3] = {0}, sum[3] = {0}, r4 = 0;
  q->weight = 0;
  for (size_t i = 0; i < n; i++) {
    const ylm__lamp_d *l = &lamps[order[i]];
    double r2 = l->radius * l->radius, w = magnitude(l) * r2;
    q->weight += w;
    r4 += w * r2;
    for (int a = 0; a < 3; a++) plain[a] += l->at[a] / (double)n, sum[a] += w * l->at[a];
  }
  bool emits = q->weight > 0 && isfinite(r4) && r4 > 0;
  if (!emits) q->weight = 0;
  q->radius2 = emits ? r4 / q->weight : 0;
  for (int a = 0; a < 3; a++) q->at[a] = emits ? sum[a] / q->weight : plain[a];
}

static void find_moments(cluster *q, const ylm__lamp_d *lamps, const uint32_t *order, size_t n) {
  for (size_t i = 0; i < n; i++) {
    const ylm__lamp_d *l = &lamps[order[i]];
    double x[3], d2 = 0, r2 = l->radius * l->radius, norm2 = 0;
    for (int a = 0; a < 3; a++) x[a] = l->at[a] - q->at[a], d2 += x[a] * x[a];
    for (int c = 0; c < 3; c++) {
      ylm__tree_add(q->sum[c], l->rgb[c] * r2, x, r2);
      norm2 += l->rgb[c] * l->rgb[c];
    }
    q->strength[YLM__STRENGTH_RGB] += sqrt(norm2) * r2;
    q->strength[YLM__STRENGTH_LUM] += fabs(l->luminance) * r2;
    q->reach = fmax(q->reach, sqrt(d2) + l->radius);
    if (q->weight == 0) continue;
    double w = magnitude(l) * r2 / q->weight;
    ylm__tree_add(q->shape, w, x, r2);
    ylm__tree_add_fourth(q->fourth_of, w, x);
    q->fourth += w * (d2 + r2) * (d2 + r2);
  }
}

void ylm__tree_cluster(cluster *q, const ylm__lamp_d *lamps, const uint32_t *order, size_t n) {
  *q = (cluster){.weight = 0};
  find_centroid(q, lamps, order, n);
  find_moments(q, lamps, order, n);
}

uint32_t ylm__tree_part_signs(const ylm__lamp_d *lamps, uint32_t n, uint32_t *order) {
  uint32_t positive = 0, next = 0;
  for (uint32_t i = 0; i < n; i++) positive += lamps[i].luminance >= 0;
  next = positive;
  for (uint32_t i = 0, k = 0; i < n; i++) order[lamps[i].luminance >= 0 ? k++ : next++] = i;
  return positive;
}

double ylm__tree_units(size_t n, const double *at, size_t step, const double *radius,
                       size_t step_radius, double centre[3]) {
  double lo[3], hi[3], size = 0;
  for (int a = 0; a < 3; a++) lo[a] = INFINITY, hi[a] = -INFINITY;
  for (size_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) {
      lo[a] = fmin(lo[a], at[step * i + (size_t)a] - radius[step_radius * i]);
      hi[a] = fmax(hi[a], at[step * i + (size_t)a] + radius[step_radius * i]);
    }
  for (int a = 0; a < 3; a++) {
    centre[a] = lo[a] + (hi[a] - lo[a]) / 2;
    size = fmax(size, (hi[a] - lo[a]) / 2);
  }
  return size > 0 ? size : 1;
}
