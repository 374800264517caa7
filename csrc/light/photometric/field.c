/*
** field.c - the light field of lamps with a table.
**
** With c(x) the coefficients of the opening at radiance 1, which its own kind knows with their derivatives, and g(x) the radiance
** of the lamp towards x,
**
**   L = g c,   dL = g dc + c dg,   HL = g Hc + dc dg + dg dc + c Hg
**
** g is that of one direction for the whole opening, u: the mean of the directions from the places of the opening to x, as x sees
** them. It is parallel to the sum of c of degree 1, v, so that dg = Du g dv. Of a sphere u comes from its centre. L is exact to
** first order in the size of the opening over its distance.
**
** Source  docs/math.md "Photometric lamps"
*/
#include <string.h>

#include "../finite.h"
#include "../flat/flat.h"
#include "../flat/kernel.h"
#include "lamp.h"
#include "ylm_sh.h"
#include "ylm_vector.h"

enum { BLOCK = 128 };

static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};

/* -- radiance -------------------------------------------------------------------------------------- */

/* A number, and its derivatives by a place. */
typedef struct gain {
  double f, g[3], h[6];
} gain;

/* 1 over the area, and of flat openings over |cos|, by a unit direction w: of what is constant along rays. */
static gain spread_of(const double *x, const double w[3], int order) {
  gain s = {.f = 1 / ylm__lamp_area(x)};
  if (!ylm__lamp_is_flat(x)) return s;
  double facing[3], z = w[2], t[3];
  ylm__lamp_facing(z, facing);
  double q = 1 / facing[0], d = -facing[1] * q * q;
  double dd = (2 * facing[1] * facing[1] * q - facing[2]) * q * q;
  for (int a = 0; a < 3; a++) t[a] = (a == 2) - z * w[a];
  for (int a = 0; order > 0 && a < 3; a++) s.g[a] = s.f * d * t[a];
  for (int k = 0; order > 1 && k < 6; k++) {
    int a = row[k], b = column[k];
    double bend = 3 * z * w[a] * w[b] - (a == 2) * w[b] - (b == 2) * w[a] - (a == b) * z;
    s.h[k] = s.f * (dd * t[a] * t[b] + d * bend);
  }
  s.f *= q;
  return s;
}

static gain product(const gain *x, const gain *y, int order) {
  gain out = {.f = x->f * y->f};
  for (int a = 0; order > 0 && a < 3; a++) out.g[a] = x->f * y->g[a] + x->g[a] * y->f;
  for (int k = 0; order > 1 && k < 6; k++) {
    int a = row[k], b = column[k];
    out.h[k] = x->f * y->h[k] + x->g[a] * y->g[b] + x->g[b] * y->g[a] + x->h[k] * y->f;
  }
  return out;
}

/* The radiance along v, of any length, for a scale of 1, and its derivatives by v. */
static gain radiance_along(const ylm_light_photometry *p, const double *x, const double v[3],
                           int order) {
  double length = sqrt(ylm_dot3d(v, v)), unit[3], w[3];
  gain in, out = {0};
  for (int a = 0; a < 3; a++) unit[a] = length > 0 ? v[a] / length : x[YLM__LAMP_AXIS + a];
  ylm__lamp_local(x, unit, w);
  ylm_light_photometry_intensity(p, 1, (const double(*)[3])w, &in.f, order > 0 ? &in.g : NULL,
                                 order > 1 ? &in.h : NULL);
  gain spread = spread_of(x, w, order), local = product(&in, &spread, order);
  double side[3], over = length > 0 ? 1 / length : 0;
  ylm__lamp_side(x, side);
  const double *axes[3] = {x + YLM__LAMP_ACROSS, side, x + YLM__LAMP_AXIS};
  out.f = local.f;
  for (int a = 0; order > 0 && a < 3; a++)
    for (int i = 0; i < 3; i++) out.g[a] += over * local.g[i] * axes[i][a];
  for (int k = 0; order > 1 && k < 6; k++)
    for (int i = 0; i < 6; i++) {
      const double *p0 = axes[row[i]], *p1 = axes[column[i]];
      double both = p0[row[k]] * p1[column[k]] + p1[row[k]] * p0[column[k]];
      out.h[k] += over * over * local.h[i] * (row[i] == column[i] ? both / 2 : both);
    }
  return out;
}

/* The opening as its own field has it at a point. */
typedef struct seen {
  const double *value, *gradient, *hessian; /* [count], [count][3], [count][6]; NULL: not wanted */
} seen;

/* Harmonics of degree 1 along x, y, z, and their signs. */
static const int first[3] = {3, 1, 2};
static const double sign[3] = {-1, -1, 1};

static const int packed[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

/* The radiance towards the point that sees the opening so, by the mean of its directions. */
static gain flat_gain(const ylm_light_photometry *p, const double *x, const seen *s, int order) {
  double v[3], slope[3][3];
  for (int i = 0; i < 3; i++) v[i] = -sign[i] * s->value[first[i]];
  gain by = radiance_along(p, x, v, order), out = {.f = by.f};
  for (int i = 0; order > 0 && i < 3; i++)
    for (int a = 0; a < 3; a++) {
      slope[i][a] = -sign[i] * s->gradient[3 * first[i] + a];
      out.g[a] += by.g[i] * slope[i][a];
    }
  for (int k = 0; order > 1 && k < 6; k++)
    for (int i = 0; i < 3; i++) {
      out.h[k] -= by.g[i] * sign[i] * s->hessian[6 * first[i] + k];
      for (int j = 0; j < 3; j++)
        out.h[k] += by.h[packed[i][j]] * slope[i][row[k]] * slope[j][column[k]];
    }
  return out;
}

static gain gain_of(const ylm__photometric_lamps *l, size_t i, const double at[3], const seen *s,
                    int order) {
  const double *x = l->base.record[i];
  if (ylm__lamp_is_flat(x)) return flat_gain(l->table, x, s, order);
  double v[3];
  for (int a = 0; a < 3; a++) v[a] = at[a] - x[YLM__LAMP_AT + a];
  return radiance_along(l->table, x, v, order);
}

/* -- sums ------------------------------------------------------------------------------------------ */

/* Adds g c to sum [3][wide]. */
static void add(const gain *g, const seen *s, const double scale[3], size_t count, size_t wide,
                int order, double *sum) {
  for (size_t t = 0; t < count; t++) {
    double value = s->value[t], one[10];
    one[0] = g->f * value;
    for (int a = 0; order > 0 && a < 3; a++)
      one[1 + a] = g->f * s->gradient[3 * t + (size_t)a] + g->g[a] * value;
    for (int k = 0; order > 1 && k < 6; k++)
      one[4 + k] = g->f * s->hessian[6 * t + (size_t)k] + g->h[k] * value +
                   g->g[row[k]] * s->gradient[3 * t + (size_t)column[k]] +
                   g->g[column[k]] * s->gradient[3 * t + (size_t)row[k]];
    for (size_t c = 0; c < 3; c++) {
      double *to = sum + c * wide;
      to[t] += scale[c] * one[0];
      for (size_t a = 0; order > 0 && a < 3; a++) to[count + 3 * t + a] += scale[c] * one[1 + a];
      for (size_t k = 0; order > 1 && k < 6; k++)
        to[4 * count + 6 * t + k] += scale[c] * one[4 + k];
    }
  }
}

typedef struct job {
  const ylm__photometric_lamps *l;
  const ylm_field_query *q;
  const void *points;
  ylm_field_result *r;
  int order;
} job;

/* Results of one opening at the points of a block. */
typedef struct room {
  double *value, *gradient, *hessian, *sum;
  double at[BLOCK][3];
  uint8_t inside[BLOCK], one[BLOCK];
} room;

/* Adds lamp i at n points of the block. */
static ylm_status add_lamp(const job *j, room *m, size_t i, size_t n) {
  const double *x = j->l->base.record[i];
  int lmax = j->q->lmax > 1 || !ylm__lamp_is_flat(x) ? j->q->lmax : 1;
  size_t seen_count = ylm_sh_count(lmax), count = ylm_sh_count(j->q->lmax);
  size_t wide = ylm__flat_wide(j->q);
  ylm_field_query q = {.lmax = lmax,
                       .channels = 1,
                       .metric_channels = 1,
                       .dtype = YLM_DOUBLE,
                       .threads = 1,
                       .want = YLM_WANT_VALUE | (j->order > 0 ? YLM_WANT_GRADIENT : 0) |
                               (j->order > 1 ? YLM_WANT_HESSIAN : 0)};
  ylm_field_result r = {
      .value = m->value, .gradient = m->gradient, .hessian = m->hessian, .inside = m->one};
  memset(m->one, 0, n);
  ylm_status s = j->l->opening[i]->evaluate(j->l->opening[i], &q, n, m->at, &r, NULL);
  for (size_t k = 0; k < n && s == YLM_OK; k++) {
    seen here = {m->value + k * seen_count, m->gradient + 3 * k * seen_count,
                 m->hessian + 6 * k * seen_count};
    gain g = gain_of(j->l, i, m->at[k], &here, m->one[k] ? 0 : j->order);
    add(&g, &here, x, count, wide, j->order, m->sum + 3 * k * wide);
    m->inside[k] |= m->one[k];
  }
  return s;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  const ylm_field_query *q = j->q;
  size_t n = end - begin, wide = ylm__flat_wide(q);
  size_t count = ylm_sh_count(q->lmax > 1 ? q->lmax : 1);
  room *m = ylm_alloc_zero(1, sizeof *m);
  if (!m) return YLM_ENOMEM;
  m->sum = ylm_alloc_zero(3 * n * wide, sizeof(double));
  m->value = ylm_alloc(n * count, 10 * sizeof(double));
  bool ok = m->sum && m->value;
  m->gradient = ok ? m->value + n * count : NULL;
  m->hessian = ok ? m->value + 4 * n * count : NULL;
  for (size_t i = 0; i < 3 * n; i++) {
    m->at[i / 3][i % 3] = ylm_get(q->dtype, j->points, 3 * begin + i);
    if (q->origin) m->at[i / 3][i % 3] += q->origin[i % 3];
  }
  ylm_status s = ok ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < j->l->base.n && s == YLM_OK; i++) s = add_lamp(j, m, i, n);
  for (size_t i = 0; i < n && s == YLM_OK; i++) {
    ylm__field_write(q, begin + i, 3, m->sum + 3 * i * wide, wide, j->r);
    if (j->r->inside) j->r->inside[begin + i] = m->inside[i];
  }
  ylm_free(m->value);
  ylm_free(m->sum);
  ylm_free(m);
  return s;
}

ylm_status ylm__photometric_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                                     const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm__photometric_lamps *l = f->self;
  int most = YLM_LIGHT_LMAX;
  for (size_t i = 0; i < l->base.n; i++)
    if (ylm__lamp_is_flat(l->base.record[i])) most = YLM_LIGHT_RIM_LMAX;
  ylm_status s = ylm_field_check(q, n, points, r, most, "these lights", e);
  if (s != YLM_OK) return s;
  size_t count = ylm_sh_count(q->lmax), wide = ylm__flat_wide(q);
  job j = {l, q, points, r, wide == 10 * count ? 2 : wide == 4 * count ? 1 : 0};
  s = ylm_parallel(n, n < 512 ? 8 : BLOCK, q->threads, run, &j, q->progress, "lights");
  if (s != YLM_OK) return ylm_fail_plain(e, s);
  r->pairs += (uint64_t)n * l->base.n;
  return ylm_light_finite(q, n, points, r, e);
}

ylm_status ylm__photometric_crosses(const ylm_field *f, size_t n, const double *boxes,
                                    uint8_t *out) {
  const ylm__photometric_lamps *l = f->self;
  uint8_t *one = ylm_alloc(n, 1);
  if (!one) return YLM_ENOMEM;
  ylm_status s = YLM_OK;
  memset(out, 0, n);
  for (size_t i = 0; i < l->base.n && s == YLM_OK; i++) {
    s = l->opening[i]->crosses(l->opening[i], n, boxes, one);
    for (size_t k = 0; k < n && s == YLM_OK; k++) out[k] |= one[k];
  }
  ylm_free(one);
  return s;
}
