/* polygon_sphere.c - flat lights approximated by spheres (Mezieres et al. 2022, Sec. 4.4): the
   sphere at the centroid whose disk has the light's area, times |cos gamma|. */
#include "polygon.h"

#include <math.h>

#include "ylm_sh.h"

static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};

/* |cos gamma| at v = centre - x, its gradient with respect to x and its Hessian: Eqs. 26-28, and
   one derivative more. */
static double cosine(const double *n, const double *v, double *gradient, double *hessian) {
  double d2 = ylm__dot(v, v), d = sqrt(d2), d3 = d * d2, nv = ylm__dot(n, v), c = nv / d,
         sign = c < 0 ? -1 : 1;
  for (int k = 0; k < 3; k++) gradient[k] = -sign * (n[k] / d - v[k] * nv / d3);
  for (int q = 0; q < 6; q++) {
    int i = row[q], j = column[q];
    hessian[q] = sign * (-(n[i] * v[j] + v[i] * n[j]) / d3 - (i == j ? nv / d3 : 0) +
                         3 * nv * v[i] * v[j] / (d3 * d2));
  }
  return fabs(c);
}

/* What a sphere's coefficients become times c: product rule. Any of g, h may be NULL. */
static void times(size_t count, double c, const double *cg, const double *ch, double *value,
                  double *gradient, double *hessian) {
  for (size_t k = 0; k < count; k++) {
    double *g = gradient ? gradient + 3 * k : NULL, *h = hessian ? hessian + 6 * k : NULL;
    for (int q = 0; h && q < 6; q++)
      h[q] = c * h[q] + g[row[q]] * cg[column[q]] + g[column[q]] * cg[row[q]] + value[k] * ch[q];
    for (int a = 0; g && a < 3; a++) g[a] = c * g[a] + value[k] * cg[a];
    value[k] *= c;
  }
}

/* Adds a point's numbers times radiance to its three channels. */
static void add(size_t n, const double *one, const double *radiance, size_t wide, double *sum) {
  for (size_t c = 0; c < 3; c++)
    for (size_t t = 0; t < n; t++) sum[c * wide + t] += radiance[c] * one[t];
}

ylm_status ylm__polygon_spheres(const ylm_polygons *p, const ylm_field_query *q, size_t n,
                                const double (*x)[3], double *sum, uint8_t *inside) {
  size_t count = ylm_sh_count(q->lmax), wide = 10 * count;
  bool h = q->want & (YLM_WANT_HESSIAN | YLM_WANT_METRIC), g = h || (q->want & YLM_WANT_GRADIENT);
  double *value = ylm_alloc(n * wide, sizeof *value), *gradient = value ? value + n * count : NULL,
         *hessian = value ? value + 4 * n * count : NULL;
  uint8_t *in = ylm_alloc(n, 1);
  ylm_status s = value && in ? YLM_OK : YLM_ENOMEM;
  ylm_field_query unit = {.lmax = q->lmax,
                          .channels = 1,
                          .metric_channels = 1,
                          .dtype = YLM_DOUBLE,
                          .threads = 1,
                          .want = YLM_WANT_VALUE | (g ? YLM_WANT_GRADIENT : 0) |
                                  (h ? YLM_WANT_HESSIAN : 0)};
  ylm_field_result r = {.value = value, .gradient = gradient, .hessian = hessian, .inside = in};
  for (size_t k = 0; k < p->n && s == YLM_OK; k++) {
    const ylm_field *f = ylm_lights_field(p->sphere[k]);
    s = f->evaluate(f, &unit, n, x, &r, NULL);
    for (size_t i = 0; s == YLM_OK && i < n; i++) {
      double *one = value + i * count, *dg = g ? gradient + 3 * i * count : NULL,
             *dh = h ? hessian + 6 * i * count : NULL, *to = sum + 3 * i * wide;
      const double *e = p->radiance + 3 * k;
      if (!in[i]) {
        double v[3], cg[3], ch[6];
        for (int a = 0; a < 3; a++) v[a] = p->centroid[3 * k + (size_t)a] - x[i][a];
        double c = cosine(p->normal + 3 * k, v, cg, ch);
        times(count, c, cg, ch, one, dg, dh);
      }
      inside[i] |= in[i];
      add(count, one, e, wide, to);
      if (g) add(3 * count, dg, e, wide, to + count);
      if (h) add(6 * count, dh, e, wide, to + 4 * count);
    }
  }
  ylm_free(value);
  ylm_free(in);
  return s;
}
