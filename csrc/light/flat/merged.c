/*
** merged.c - flat lights that are approximated by spheres, summed by merged moments.
**
** A light's coefficients are those of a sphere, S, times c = |cos gamma|, which differs from point
** to point. The kernels of sphere lights are given c and its derivatives in place of a radiance:
**
**   d_a (c S)  = c d_a S + S d_a c
**   d_ab (c S) = c d_ab S + d_a c d_b S + d_b c d_a S + S d_ab c
**
** so all kinds of moments are summed times c, those of fewer derivatives times d_a c, and those of
** values times d_ab c. Lanes are points.
**
** Source  docs/math.md "Polygons and disks"; Mezieres et al. 2022, Eqs. 24-28
*/
#include "merged.h"

#include <math.h>
#include <string.h>

#include "gen/jet.h"

/* Points that the widest kernel sums at once. */
#define MOST_LANES 16

/* The results that are wanted, by their derivatives. */
static int derivatives_of(const ylm_field_query *q) {
  if (q->want & (YLM_WANT_HESSIAN | YLM_WANT_METRIC)) return 2;
  return q->want & YLM_WANT_GRADIENT ? 1 : 0;
}

ylm_status ylm__merged_make(ylm__merged *m, const ylm_polygons *p, const ylm_field_query *q,
                            ylm_isa isa) {
  ylm__kernel_set set;
  *m = (ylm__merged){.derivatives = derivatives_of(q)};
  if (p->n < YLM__MERGED_LEAST || q->lmax > YLM__SPECIAL ||
      !ylm__kernels_of(isa, q->lmax, YLM_DOUBLE, &set) || set.moments->lanes > MOST_LANES)
    return YLM_OK;
  m->kernel = set.moments;
  return ylm_light_flat_maps_create(q->lmax, m->derivatives, &m->maps);
}

void ylm__merged_free(ylm__merged *m) { ylm_light_maps_free(&m->maps); }

/* Scratch: vectors of `lanes` numbers. */
typedef struct work {
  double *geometry, *weights, *emission, *state, *jet, *sums, *xyz;
} work;

static ylm_status work_create(work *k, const ylm__merged *m, int lmax, double **scratch) {
  size_t G = (size_t)ylm__geometry_slots(lmax), W = (size_t)ylm__weight_slots(lmax);
  size_t total = 0;
  size_t sizes[] = {YLM__TILE * G,
                    YLM__TILE * W,
                    YLM__TILE * 3,
                    YLM__TILE * 2,
                    YLM__TILE * 10,
                    3 * m->maps.sums,
                    3};
  double **slots[] = {&k->geometry, &k->weights, &k->emission, &k->state,
                      &k->jet,      &k->sums,    &k->xyz};
  size_t lanes = (size_t)m->kernel->lanes;
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) total += sizes[i];
  double *at = *scratch = ylm_alloc_zero(total * lanes, sizeof *at);
  if (!at) return YLM_ENOMEM;
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) *slots[i] = at, at += sizes[i] * lanes;
  return YLM_OK;
}

/* c and its derivatives by v in each lane: [10][lanes]; in the sphere c is 1. */
static void cosines(const ylm_polygons *p, size_t light, const ylm__merged *m, const double *xyz,
                    double *jet, uint8_t *in) {
  size_t lanes = (size_t)m->kernel->lanes, parts = m->derivatives == 2 ? 10 : 4;
  const double *y = p->centroid + 3 * light, *normal = p->normal + 3 * light;
  double r = p->radius[light];
  for (size_t i = 0; i < lanes; i++) {
    double v[3] = {y[0] - xyz[i], y[1] - xyz[lanes + i], y[2] - xyz[2 * lanes + i]};
    double d2 = ylm_dot3d(v, v), slope = ylm_dot3d(normal, v), one[10] = {1};
    if (d2 > r * r && m->derivatives == 0) {
      one[0] = fabs(slope) / sqrt(d2);
    } else if (d2 > r * r) {
      double id = 1 / sqrt(d2), sign = slope < 0 ? -1 : 1, n[3], w[3];
      for (int a = 0; a < 3; a++) n[a] = sign * normal[a], w[a] = v[a] * id;
      jet_cosine(n, w, id, one);
    } else
      in[i] = 1;
    for (size_t k = 0; k < (m->derivatives ? parts : 1); k++) jet[k * lanes + i] = one[k];
  }
}

/* Adds `kinds` of moments of n lights times part `part` of c's jet to the sums at `to`. */
static void add(const ylm_polygons *p, const ylm__merged *m, const work *k, int lmax, int kinds,
                size_t first, int n, size_t part, size_t to) {
  size_t lanes = (size_t)m->kernel->lanes;
  for (size_t t = 0; t < (size_t)n; t++)
    for (size_t c = 0; c < 3; c++) {
      const double e = p->radiance[3 * (first + t) + c];
      for (size_t i = 0; i < lanes; i++)
        k->emission[(3 * t + c) * lanes + i] = e * k->jet[(10 * t + part) * lanes + i];
    }
  m->kernel->sum_rgb(lmax, kinds, n, k->geometry, k->weights, k->emission, k->state,
                     k->sums + to * lanes, (int)m->maps.sums);
}

/* Adds n lights from `first` on at the points of the lanes. */
static void add_tile(const ylm_polygons *p, const ylm__merged *m, const work *k, int lmax,
                     size_t first, int n, uint8_t *in) {
  static const int all[3] = {YLM__M0, YLM__M0 | YLM__M1, 7};
  static const int less[3] = {0, YLM__M0, YLM__M0 | YLM__M1};
  size_t lanes = (size_t)m->kernel->lanes, at = (size_t)ylm__sum_count(lmax, all[m->derivatives]);
  size_t slope = (size_t)ylm__sum_count(lmax, less[m->derivatives]);
  size_t sums = (size_t)ylm__sum_count(lmax, YLM__M0);
  ylm__lamp_d lamp[YLM__TILE];
  double unused[MOST_LANES] __attribute__((aligned(YLM_ALIGN))) = {0};
  for (size_t t = 0; t < (size_t)n; t++) {
    const double *c = p->centroid + 3 * (first + t);
    lamp[t] = (ylm__lamp_d){{c[0], c[1], c[2]}, p->radius[first + t], 1, {1, 1, 1}};
    cosines(p, first + t, m, k->xyz, k->jet + 10 * t * lanes, in);
  }
  m->kernel->prepare(lmax, all[m->derivatives], n, lamp, 0, k->xyz, k->geometry, k->weights,
                     unused);
  add(p, m, k, lmax, all[m->derivatives], first, n, 0, 0);
  for (size_t a = 0; m->derivatives && a < 3; a++, at += slope)
    add(p, m, k, lmax, less[m->derivatives], first, n, 1 + a, at);
  for (size_t a = 0; m->derivatives == 2 && a < 6; a++, at += sums)
    add(p, m, k, lmax, YLM__M0, first, n, 4 + a, at);
}

/* Rows of results of channel c to the lanes' points: numbers `before` .. of sum
   [point][3][wide]. */
static void put(const ylm__merged *m, const work *k, const ylm_light_rows *rows, size_t c,
                size_t before, size_t wide, size_t points, double *sum) {
  size_t lanes = (size_t)m->kernel->lanes;
  const double *x = k->sums + c * m->maps.sums * lanes;
  for (size_t row = 0; row < rows->n; row++) {
    double s[MOST_LANES] = {0};
    for (uint32_t t = rows->start[row]; t < rows->start[row + 1]; t++)
      for (size_t i = 0; i < lanes; i++) s[i] += rows->coef[t] * x[rows->index[t] * lanes + i];
    for (size_t i = 0; i < points; i++) sum[(3 * i + c) * wide + before + row] = s[i];
  }
}

ylm_status ylm__polygon_merged(const ylm_polygons *p, const ylm__merged *m,
                               const ylm_field_query *q, size_t n, const double (*x)[3],
                               double *sum, uint8_t *inside) {
  size_t lanes = (size_t)m->kernel->lanes, count = (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1);
  size_t wide = 10 * count;
  double *scratch;
  work k;
  if (work_create(&k, m, q->lmax, &scratch) != YLM_OK) return YLM_ENOMEM;
  for (size_t begin = 0; begin < n; begin += lanes) {
    size_t points = n - begin < lanes ? n - begin : lanes;
    uint8_t in[MOST_LANES] = {0};
    for (size_t i = 0; i < lanes; i++)
      for (size_t a = 0; a < 3; a++) k.xyz[a * lanes + i] = x[begin + (i < points ? i : 0)][a];
    memset(k.sums, 0, 3 * m->maps.sums * lanes * sizeof *k.sums);
    for (size_t l = 0; l < p->n; l += YLM__TILE)
      add_tile(p, m, &k, q->lmax, l, p->n - l < YLM__TILE ? (int)(p->n - l) : YLM__TILE, in);
    for (size_t c = 0; c < 3; c++) {
      double *to = sum + 3 * begin * wide;
      put(m, &k, &m->maps.value, c, 0, wide, points, to);
      if (m->derivatives) put(m, &k, &m->maps.gradient, c, count, wide, points, to);
      if (m->derivatives == 2) put(m, &k, &m->maps.hessian, c, 4 * count, wide, points, to);
    }
    memcpy(inside + begin, in, points);
  }
  ylm_free(scratch);
  return YLM_OK;
}
