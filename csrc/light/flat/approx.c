/* approx.c - flat lights approximated by spheres (Mezieres et al. 2022, Sec. 4.4): the
   sphere at the centroid whose disk has the light's area, times |cos gamma|. */
#include "flat.h"

#include <math.h>

#include "../moments/plan.h"
#include "gen/jet.h"
#include "ylm_sh.h"

/* |cos gamma| at v = centre - x, its gradient with respect to x and its Hessian, as a jet. */
static void cosine(const double *normal, const double *v, double *jet) {
  double d = sqrt(ylm_dot3d(v, v)), sign = ylm_dot3d(normal, v) < 0 ? -1 : 1, n[3], w[3];
  for (int k = 0; k < 3; k++) n[k] = sign * normal[k], w[k] = v[k] / d;
  jet_cosine(n, w, 1 / d, jet);
  for (int k = 1; k < 4; k++) jet[k] = -jet[k]; /* by x */
}

/* A sphere's coefficients times c, with derivatives. Any of g, h may be NULL. */
static void times(size_t count, const double *c, double *value, double *gradient, double *hessian) {
  for (size_t k = 0; k < count; k++) {
    double *g = gradient ? gradient + 3 * k : NULL, *h = hessian ? hessian + 6 * k : NULL;
    double own[10] = {value[k]}, made[10];
    for (int a = 0; g && a < 3; a++) own[1 + a] = g[a];
    for (int q = 0; h && q < 6; q++) own[4 + q] = h[q];
    jet_times(c, own, made);
    value[k] = made[0];
    for (int a = 0; g && a < 3; a++) g[a] = made[1 + a];
    for (int q = 0; h && q < 6; q++) h[q] = made[4 + q];
  }
}

/* Adds a point's numbers times radiance to its three channels. */
static void add(size_t n, const double *one, const double *radiance, size_t wide, double *sum) {
  for (size_t c = 0; c < 3; c++)
    for (size_t t = 0; t < n; t++) sum[c * wide + t] += radiance[c] * one[t];
}

/* The coefficients of single spheres of radiance 1: one plan for all of them. */
typedef struct singly {
  ylm_field_query q;
  ylm__plan plan;
  ylm__sum_range *range; /* NULL: the reference */
  void *scratch;
} singly;

static ylm_status singly_make(singly *k, int lmax, int want) {
  static const ylm_lights none;
  ylm__kernel_set set;
  *k = (singly){.q = {.lmax = lmax,
                      .channels = 1,
                      .metric_channels = 1,
                      .dtype = YLM_DOUBLE,
                      .threads = 1,
                      .want = want}};
  if (!ylm__kernels_of(ylm_isa_current(), lmax, YLM_DOUBLE, &set)) return YLM_OK;
  k->range = set.range;
  return ylm__plan_create(&k->plan, &none, &k->q, set.moments);
}

static void singly_free(singly *k) {
  ylm__plan_free(&k->plan);
  ylm_free(k->scratch);
}

/* The sphere at c at n points x. */
static ylm_status singly_sum(singly *k, const double *c, double radius, size_t n,
                             const double (*x)[3], ylm_field_result *r) {
  ylm__lamp_d lamp = {{c[0], c[1], c[2]}, radius, 1, {1, 1, 1}};
  ylm_lights one = {.n = 1, .active = 1, .lamp_d = &lamp};
  if (!k->range) return ylm__reference_range(&one, &k->q, 0, n, x, r);
  k->plan.lights = &one;
  return k->range(&k->plan, &k->scratch, 0, n, x, r);
}

ylm_status ylm__polygon_spheres(const ylm_polygons *p, const ylm_field_query *q, size_t n,
                                const double (*x)[3], double *sum, uint8_t *inside) {
  size_t count = ylm_sh_count(q->lmax), wide = 10 * count;
  bool h = q->want & (YLM_WANT_HESSIAN | YLM_WANT_METRIC), g = h || (q->want & YLM_WANT_GRADIENT);
  double *value = ylm_alloc(n * wide, sizeof *value), *gradient = value ? value + n * count : NULL,
         *hessian = value ? value + 4 * n * count : NULL;
  uint8_t *in = ylm_alloc(n, 1);
  singly spheres;
  ylm_status s = singly_make(
      &spheres, q->lmax, YLM_WANT_VALUE | (g ? YLM_WANT_GRADIENT : 0) | (h ? YLM_WANT_HESSIAN : 0));
  if (!value || !in) s = YLM_ENOMEM;
  ylm_field_result r = {.value = value, .gradient = gradient, .hessian = hessian, .inside = in};
  for (size_t k = 0; k < p->n && s == YLM_OK; k++) {
    s = singly_sum(&spheres, p->centroid + 3 * k, p->radius[k], n, x, &r);
    for (size_t i = 0; s == YLM_OK && i < n; i++) {
      double *one = value + i * count, *dg = g ? gradient + 3 * i * count : NULL,
             *dh = h ? hessian + 6 * i * count : NULL, *to = sum + 3 * i * wide;
      const double *e = p->radiance + 3 * k;
      if (!in[i]) {
        double v[3], c[10];
        for (int a = 0; a < 3; a++) v[a] = p->centroid[3 * k + (size_t)a] - x[i][a];
        cosine(p->normal + 3 * k, v, c);
        times(count, c, one, dg, dh);
      }
      inside[i] |= in[i];
      add(count, one, e, wide, to);
      if (g) add(3 * count, dg, e, wide, to + count);
      if (h) add(6 * count, dh, e, wide, to + 4 * count);
    }
  }
  singly_free(&spheres);
  ylm_free(value);
  ylm_free(in);
  return s;
}
