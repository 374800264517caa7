/* plan.c - the plan of a query about virtual lights, and lights as kernels see them. */
#include "plan.h"

#include <stdlib.h>
#include <string.h>

#include "../moments/gen/recurrences.h"
#include "ylm_sets.h"
#include "ylm_sh.h"

/* -- lights --------------------------------------------------------------------------------- */

/* An emission of degree 2 as c[0] + c[1..3].u + u' C u, C being xx xy xz yy yz in c[4..8]: it has no trace. */
static void quadratic(int degree, const double *b, double *c) {
  double h[6]; /* 00, 10, 11, 20, 21, 22 */
  for (int l = 0, i = 0; l <= 2; l++)
    for (int m = 0; m <= l; m++) h[i++] = ylm__harmonic_scale(l, m, 1);
  c[0] = h[0] * b[0];
  c[1] = h[2] * b[3], c[2] = h[2] * b[1], c[3] = h[1] * b[2];
  if (degree < 2) return;
  c[4] = h[5] * b[8] - h[3] * b[6] / 3;
  c[5] = h[5] * b[4];
  c[6] = h[4] * b[7] / 2;
  c[7] = -h[5] * b[8] - h[3] * b[6] / 3;
  c[8] = h[4] * b[5] / 2;
}

static void numbers(int degree, const double *b, double *c) {
  if (degree == 0)
    c[0] = b[0] * ylm__harmonic_scale(0, 0, 1);
  else if (degree <= 2)
    quadratic(degree, b, c);
  else
    for (int l = 0, q = 0; l <= degree; l++)
      for (int m = -l; m <= l; m++, q++) c[q] = b[q] * ylm__harmonic_scale(l, abs(m), 1);
}

static void settle_one(const ylm_light_virtual *v, size_t i, double *to) {
  size_t n = YLM_LIGHT_VIRTUAL_NUMBERS(v->degree);
  double c[81];
  for (size_t a = 0; a < 3; a++) {
    to[YLM__VIRTUAL_AT + a] = v->local[3 * i + a];
    to[YLM__VIRTUAL_NORMAL + a] = v->normal[3 * i + a];
  }
  to[YLM__VIRTUAL_SHIFT] = v->shift[i];
  to[YLM__VIRTUAL_RADIUS] = v->radius[i];
  for (size_t k = 0; k < 3; k++) {
    numbers(v->degree, v->emission + (3 * i + k) * n, c);
    for (size_t q = 0; q < n; q++) to[YLM__VIRTUAL_EMISSION + 3 * q + k] = c[q];
  }
}

/* The places of the lights about their origin. */
static ylm_status make_local(ylm_light_virtual *v) {
  double box[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < 3 * v->n; i++) {
    box[i % 3] = fmin(box[i % 3], v->at[i] - v->radius[i / 3]);
    box[i % 3 + 3] = fmax(box[i % 3 + 3], v->at[i] + v->radius[i / 3]);
  }
  if (v->n) ylm_origin(box, v->origin);
  v->local = v->at;
  if (v->origin[0] == 0 && v->origin[1] == 0 && v->origin[2] == 0) return YLM_OK;
  v->local = ylm_alloc(3 * v->n, sizeof *v->local);
  for (size_t i = 0; v->local && i < 3 * v->n; i++) v->local[i] = v->at[i] - v->origin[i % 3];
  return v->local ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm__virtual_settle(ylm_light_virtual *v) {
  double one[YLM__VIRTUAL_EMISSION + 3 * YLM_LIGHT_VIRTUAL_NUMBERS(YLM_LIGHT_VIRTUAL_DEGREE)];
  v->stride = YLM__VIRTUAL_EMISSION + 3 * YLM_LIGHT_VIRTUAL_NUMBERS(v->degree);
  v->seen = ylm_alloc(v->n * v->stride, sizeof *v->seen);
  if (!v->seen || make_local(v) != YLM_OK) return YLM_ENOMEM;
  for (size_t i = 0; i < v->n; i++) {
    settle_one(v, i, one);
    for (size_t k = 0; k < v->stride; k++) v->seen[i * v->stride + k] = (float)one[k];
  }
  return YLM_OK;
}

/* Rows of all lights for kernels in double. */
static ylm_status make_lights(ylm__virtual_plan *p) {
  const ylm_light_virtual *v = p->lights;
  double *x = ylm_alloc(v->n * v->stride, sizeof *x);
  p->seen = x;
  if (!x) return YLM_ENOMEM;
  for (size_t i = 0; i < v->n; i++) settle_one(v, i, x + i * v->stride);
  return YLM_OK;
}

static bool is_narrow(const ylm_field_query *q) {
  return q->dtype == YLM_FLOAT && q->lmax <= YLM__VIRTUAL_FLOAT;
}

/* -- sums ----------------------------------------------------------------------------------- */

static void add_product(ylm__virtual_plan *p, ylm__virtual_sums *s, int block, int part,
                        int parts) {
  int channels = parts * s->channels, from = s->from + part * s->channels;
  for (int i = 0; i < parts; i++)
    s->at[block][part + i] = p->sums + (size_t)(i * s->channels) * p->rows[block];
  ylm__virtual_product *last = p->products ? &p->product[p->products - 1] : NULL;
  if (last && last->block == block && last->from + last->channels == from)
    last->channels += channels;
  else
    p->product[p->products++] = (ylm__virtual_product){block, from, channels, p->sums};
  p->sums += (size_t)channels * p->rows[block];
}

static void add_sums(ylm__virtual_plan *p, ylm__virtual_sums *s, int kinds, int channels) {
  *s = (ylm__virtual_sums){
      .kinds = kinds, .channels = channels, .from = p->numbers, .first = p->sums};
  if (!kinds) return;
  if (kinds & 1) add_product(p, s, 0, 0, 1);
  if (kinds & 2) add_product(p, s, 0, 1, 3);
  if (kinds & 4) add_product(p, s, 0, 4, 6);
  if (kinds & 2) add_product(p, s, 1, 0, 1);
  if (kinds & 4) add_product(p, s, 1, 1, 3);
  if (kinds & 12) add_product(p, s, 2, 0, 1);
  p->numbers += channels * (kinds & 4 ? 10 : kinds & 2 ? 4 : 1);
}

/* -- maps ----------------------------------------------------------------------------------- */

static size_t row_of(int k, int m) { return (size_t)(k * (k + 1) + m); }

/* Orders that axis a couples order m to, at most three. */
static int partners(int m, int k, int of[6]) {
  int n = 0;
  for (int side = -1; side <= 1; side++)
    for (int sign = 1; sign >= -1; sign -= 2) {
      int q = sign * (abs(m) + side);
      if (abs(m) + side < 0 || (abs(m) + side == 0 && sign < 0) || abs(q) > k) continue;
      of[n++] = q;
    }
  return n;
}

/* The part of w_a Y_lm of degree l+1 (up) or l-1, in Y of order m. */
static double part_of(int a, int l, int m, bool up, int to) {
  return up ? ylm__coupling(a, l, m, to) : ylm__coupling(a, l - 1, to, m);
}

/* The factor of Y_km in the row of block 1 of (k, m), reached from l. */
static void term(ylm__rows *r, const ylm__virtual_plan *p, int l, int k, int m, double c) {
  size_t at = k > l ? row_of(k, m) - 1 : row_of(p->lmax + 1, p->lmax + 1) + row_of(k, m);
  if (c != 0) ylm__rows_term(r, at, c * ylm__harmonic_scale(k, abs(m), 1));
}

static ylm_status make_once(ylm__virtual_plan *p) {
  size_t n = 3 * ylm_sh_count(p->lmax);
  if (ylm__rows_create(&p->once, n, 12 * n) != YLM_OK) return YLM_ENOMEM;
  for (int l = 0; l <= p->lmax; l++)
    for (int m = -l; m <= l; m++)
      for (int a = 0; a < 3; a++) {
        for (int k = l + 1; k >= l - 1; k -= 2) {
          int of[6], found = k < 0 ? 0 : partners(m, k, of);
          for (int i = 0; i < found; i++)
            term(&p->once, p, l, k, of[i], part_of(a, l, m, k > l, of[i]));
        }
        ylm__rows_end(&p->once);
      }
  return YLM_OK;
}

/* Kinds of straight sums of degree k: 0 from l = k-2, 1 from k, 2 from k+2. */
static bool has_bend(const ylm__virtual_plan *p, int k, int kind) {
  return kind == 0 ? k > 1 && k <= p->lmax + 2 : kind == 1 ? k <= p->lmax : k <= p->lmax - 2;
}

/* Where straight sums begin that have degree k. */
static size_t bends_before(const ylm__virtual_plan *p, int k) {
  size_t n = 0;
  for (int j = 0; j < k; j++)
    for (int kind = 0; kind < 3; kind++) n += has_bend(p, j, kind) ? 2 * (size_t)j + 1 : 0;
  return n;
}

/* Where block 2 has what came from degree l to k in two steps. */
static size_t second_at(const ylm__virtual_plan *p, int l, int k, int m) {
  if (p->straight) {
    size_t kinds = 0, before = 0;
    for (int kind = 0; kind < 3; kind++) {
      before += kind < (l - k + 2) / 2 && has_bend(p, k, kind);
      kinds += has_bend(p, k, kind);
    }
    return bends_before(p, k) + (size_t)(m + k) * kinds + before;
  }
  size_t up = row_of(p->lmax + 2, p->lmax + 2) + 1 - 4, same = ylm_sh_count(p->lmax);
  return k > l ? row_of(k, m) - 4 : k == l ? up + row_of(k, m) : up + same + row_of(k, m);
}

/* Y_km over the harmonic of straight sums. */
static double straight_scale(int k, int m) {
  double c = ylm__harmonic_scale(k, abs(m), 1) * (m ? 1 : 2);
  for (int j = 1; j <= abs(m); j++) c *= 2 * j;
  for (int j = abs(m) + 1; j <= k; j++) c *= (double)(j + abs(m)) * (j - abs(m)) / (2.0 * j - 1);
  return c;
}

static double scale_of(const ylm__virtual_plan *p, int k, int m) {
  return p->straight ? straight_scale(k, m) : ylm__harmonic_scale(k, abs(m), 1);
}

/* Adds what the second derivative by a and b of G_l Y_lm has, in two steps by way of degree k. */
static void add_second(const ylm__virtual_plan *p, double *sum, int l, int m, int a, int b) {
  int of[6], to[6];
  for (int k = l + 1; k >= l - 1; k -= 2) {
    int found = k < 0 ? 0 : partners(m, k, of);
    for (int i = 0; i < found; i++) {
      double c = part_of(a, l, m, k > l, of[i]);
      for (int j = k + 1; j >= k - 1 && c != 0; j -= 2) {
        int next = j < 0 ? 0 : partners(of[i], j, to);
        for (int t = 0; t < next; t++)
          sum[second_at(p, l, j, to[t])] +=
              c * part_of(b, k, of[i], j > k, to[t]) * scale_of(p, j, to[t]);
      }
    }
  }
}

static ylm_status make_twice(ylm__virtual_plan *p) {
  static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
  size_t n = 6 * ylm_sh_count(p->lmax);
  double *sum = ylm_alloc(p->rows[2], sizeof *sum);
  ylm_status s = sum ? ylm__rows_create(&p->twice, n, 24 * n) : YLM_ENOMEM;
  for (int l = 0; l <= p->lmax && s == YLM_OK; l++)
    for (int m = -l; m <= l; m++)
      for (int q = 0; q < 6; q++) {
        memset(sum, 0, p->rows[2] * sizeof *sum);
        add_second(p, sum, l, m, row[q], column[q]);
        for (size_t i = 0; i < p->rows[2]; i++)
          if (fabs(sum[i]) > 1e-14) ylm__rows_term(&p->twice, i, sum[i]);
        ylm__rows_end(&p->twice);
      }
  ylm_free(sum);
  return s;
}

static ylm_status make_maps(ylm__virtual_plan *p) {
  size_t n = ylm_sh_count(p->lmax), top = (size_t)p->lmax + 3;
  double *beta = ylm_alloc_zero(top * top, sizeof *beta), *scale = ylm_alloc(n, sizeof *scale);
  p->beta = beta;
  p->scale = scale;
  if (!beta || !scale || ylm__rows_create(&p->value, n, n) != YLM_OK) return YLM_ENOMEM;
  for (int k = 1; k < (int)top; k++)
    for (int m = 0; m <= k; m++) beta[(size_t)k * top + (size_t)m] = YLM__BETA(k, m);
  for (int l = 0; l <= p->lmax; l++)
    for (int m = -l; m <= l; m++) {
      scale[row_of(l, m)] = p->straight ? straight_scale(l, m) : 0;
      ylm__rows_term(&p->value, row_of(l, m), ylm__harmonic_scale(l, abs(m), 1));
      ylm__rows_end(&p->value);
    }
  ylm_status s = p->kinds & 6 && !p->straight ? make_once(p) : YLM_OK;
  return s == YLM_OK && p->kinds & 12 ? make_twice(p) : s;
}

/* Straight sums, and rows of lights for them. */
static void plan_straight(ylm__virtual_plan *p) {
  const size_t degrees = (size_t)p->lmax + 1, wide = p->slopes ? 12 : 3;
  p->factors = ylm_sh_count(p->bends ? p->lmax + 2 : p->lmax);
  p->bent = p->factors + (p->slopes ? 1 + 12 * degrees : 3 + degrees);
  p->width = p->bent + (p->bends ? 3 * (degrees + 2) : 0);
  p->bend_sums = p->sums = wide * p->rows[0];
  p->sums += p->bends ? p->rows[2] : 0;
}

ylm_status ylm__virtual_plan_create(ylm__virtual_plan *p, const ylm_light_virtual *v,
                                    const ylm_field_query *q) {
  int wanted = (q->want & YLM_WANT_VALUE ? 1 : 0) | (q->want & YLM_WANT_GRADIENT ? 2 : 0) |
               (q->want & YLM_WANT_HESSIAN ? 4 : 0);
  int metric = q->want & YLM_WANT_METRIC ? (q->want & YLM_WANT_ROUGH ? 9 : 5) : 0;
  int rgb = (q->channels == 3 ? wanted : 0) | (q->metric_channels == 3 ? metric : 0);
  int lum = (q->channels == 1 ? wanted : 0) | (q->metric_channels != 3 ? metric : 0);
  size_t count = ylm_sh_count(q->lmax), less = q->lmax > 0 ? ylm_sh_count(q->lmax - 1) : 0,
         least = q->lmax > 1 ? ylm_sh_count(q->lmax - 2) : 0;
  *p = (ylm__virtual_plan){.lights = v, .q = q, .lmax = q->lmax, .kinds = rgb | lum, .need = lum};
  p->rows[0] = count;
  p->rows[1] = p->kinds & 6 ? ylm_sh_count(q->lmax + 1) - 1 + less : 0;
  p->rows[2] = p->kinds & 12 ? ylm_sh_count(q->lmax + 2) - 4 + count + least : 0;
  p->width = p->rows[0] + p->rows[1] + p->rows[2];
  p->straight = q->lmax <= YLM__VIRTUAL_STRAIGHT && rgb && !(rgb & ~3) && !(lum & ~9);
  p->slopes = rgb & 2;
  p->bends = p->kinds & 8;
  add_sums(p, &p->of[0], rgb, 3);
  add_sums(p, &p->of[1], lum & ~rgb, 1);
  if (p->straight) plan_straight(p);
  ylm_status s = is_narrow(q) ? YLM_OK : make_lights(p);
  return s == YLM_OK ? make_maps(p) : s;
}

void ylm__virtual_plan_free(ylm__virtual_plan *p) {
  ylm__rows_free(&p->value);
  ylm__rows_free(&p->once);
  ylm__rows_free(&p->twice);
  ylm_free((void *)(uintptr_t)p->beta);
  ylm_free((void *)(uintptr_t)p->scale);
  ylm_free((void *)(uintptr_t)p->seen);
}

/* -- kernels -------------------------------------------------------------------------------- */

static YLM_KERNEL_CHOICE_OF(ylm__virtual_range, kernel_float, ylm__virtual_range_float, NULL);
static YLM_KERNEL_CHOICE_OF(ylm__virtual_range, kernel_double, ylm__virtual_range_double, NULL);

ylm__virtual_range *ylm__virtual_kernel(ylm_isa isa, const ylm_field_query *q) {
  return is_narrow(q) ? kernel_float(isa) : kernel_double(isa);
}
