/* learn.c - turns of colours and of coefficients in which differences from predictions are small numbers. */
#include "small.h"

#include <math.h>
#include <string.h>

#define SWEEPS 12
#define LEARNT_FROM 16384 /* points at most, of coefficients */

/* Eigenvectors of a symmetric matrix [n][n], as rows of v, by falling eigenvalue; a is spent. Jacobi's turns. */
static void eigenvectors(size_t n, double *a, double *v, double *value) {
  for (size_t i = 0; i < n * n; i++) v[i] = i % (n + 1) == 0;
  for (int sweep = 0; sweep < SWEEPS; sweep++)
    for (size_t p = 0; p < n; p++)
      for (size_t q = p + 1; q < n; q++) {
        double off = a[p * n + q];
        if (fabs(off) <= 1e-14 * sqrt(fabs(a[p * n + p] * a[q * n + q]))) continue;
        double theta = (a[q * n + q] - a[p * n + p]) / (2 * off);
        double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1)),
               c = 1 / sqrt(t * t + 1), s = t * c;
        for (size_t k = 0; k < n; k++) {
          double x = a[p * n + k], y = a[q * n + k];
          a[p * n + k] = c * x - s * y;
          a[q * n + k] = s * x + c * y;
        }
        for (size_t k = 0; k < n; k++) {
          double x = a[k * n + p], y = a[k * n + q];
          a[k * n + p] = c * x - s * y;
          a[k * n + q] = s * x + c * y;
          x = v[p * n + k], y = v[q * n + k];
          v[p * n + k] = c * x - s * y;
          v[q * n + k] = s * x + c * y;
        }
      }
  for (size_t i = 0; i < n; i++) value[i] = a[i * n + i];
  for (size_t i = 0; i < n; i++) { /* the largest first */
    size_t most = i;
    for (size_t k = i + 1; k < n; k++)
      if (value[k] > value[most]) most = k;
    if (most == i) continue;
    double x = value[i];
    value[i] = value[most];
    value[most] = x;
    for (size_t k = 0; k < n; k++) {
      x = v[i * n + k];
      v[i * n + k] = v[most * n + k];
      v[most * n + k] = x;
    }
  }
}

/* -- colours ------------------------------------------------------------------------------------------ */

/* A proper turn with columns v[0], v[1], v[2], as it is written. */
static uint32_t pack_turn(const double v[9]) {
  double m[3][3], best = -1, q[4] = {1, 0, 0, 0};
  for (int signs = 0; signs < 8;
       signs++) { /* the signs of columns are free: of turns, the smallest */
    for (int d = 0; d < 3; d++)
      for (int c = 0; c < 3; c++) m[c][d] = v[3 * d + c] * (signs >> d & 1 ? -1 : 1);
    double det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                 m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                 m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    double w = sqrt(fmax(0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2;
    if (det < 0 || w <= best || w < 1e-3) continue;
    best = w;
    q[0] = w;
    q[1] = (m[2][1] - m[1][2]) / (4 * w);
    q[2] = (m[0][2] - m[2][0]) / (4 * w);
    q[3] = (m[1][0] - m[0][1]) / (4 * w);
  }
  uint32_t largest = 0, out = 0, shift = 0;
  for (uint32_t i = 1; i < 4; i++)
    if (fabs(q[i]) > fabs(q[largest])) largest = i;
  double sign = q[largest] < 0 ? -1 : 1;
  for (uint32_t i = 0; i < 4; i++) {
    if (i == largest) continue;
    double n = floor(sign * q[i] * 1.4142135623730951 * 511 + 0.5);
    out |= (uint32_t)(int32_t)(511 + fmin(fmax(n, -511), 511)) << shift;
    shift += 10;
  }
  return out | largest << 30;
}

typedef struct learning {
  small_frame *f;
  float *number, *predicted, *room; /* of a point */
  double *sum;                      /* [kinds][size] products of coefficients, turned */
} learning;

static void difference(const learning *j, size_t met, const int16_t *exponent) {
  const small_frame *f = j->f;
  float step[4];
  int ways = ylm__small_ways(f, met);
  ylm__small_predict(f, met, ways == 3 ? 1 : ways, j->predicted);
  ylm__small_steps(f, met, exponent[met], step);
  const float *row = ylm__grid_row(f->k->from, f->k->old[met], 0);
  ylm__small_difference(f, met, step, row, j->predicted, j->number, j->room);
}

/* Shared points are not turned by what one part of a set learns. */
static bool is_shared(const small_frame *f, size_t met) {
  return small_is_shared(f->g, f->head.finest, f->g->lattice + 3 * (size_t)f->k->place[met]);
}

/* How much a point counts: those that rounding leaves nothing of count most, in proportion. */
static double weight_of(const learning *j) {
  size_t n = j->f->rows * j->f->width;
  double sum = 0;
  for (size_t i = 0; i < n; i++) sum += (double)j->number[i] * (double)j->number[i];
  return 1 / (1 + sum / (double)n);
}

/* Products of a point's colours, added to those of its block. */
static void sum_colours(const learning *j, double a[9]) {
  const small_frame *f = j->f;
  size_t count = (size_t)f->count;
  double w = weight_of(j);
  for (size_t i = 0; i < f->rows * count; i++) {
    const float *x = j->number + i / count * f->width + i % count;
    for (size_t c = 0; c < 3; c++)
      for (size_t d = 0; d < 3; d++)
        a[3 * c + d] += w * (double)x[c * count] * (double)x[d * count];
  }
}

static ylm_status learn_colours(learning *j, const int16_t *exponent) {
  small_frame *f = j->f;
  size_t blocks = small_blocks(f);
  double(*sum)[9] = ylm_alloc_zero(blocks, sizeof *sum), v[9], value[3];
  if (!sum) return YLM_ENOMEM;
  for (size_t i = 0; i < blocks; i++) /* differences are as they are */
    ylm__small_turn(SMALL_NO_TURN, f->colour + 9 * i);
  for (size_t met = 0; met < f->k->met; met++) {
    if (is_shared(f, met)) continue;
    difference(j, met, exponent);
    sum_colours(j, sum[f->k->before[met] / SMALL_BLOCK]);
  }
  for (size_t i = 0; i < blocks; i++) {
    eigenvectors(3, sum[i], v, value);
    f->turns[i] = pack_turn(v);
    ylm__small_turn(f->turns[i], f->colour + 9 * i);
  }
  ylm_free(sum);
  return YLM_OK;
}

/* -- coefficients ---------------------------------------------------------------------------------------- */

static void sum_products(learning *j) {
  const small_frame *f = j->f;
  const small_basis *b = &f->basis;
  size_t count = (size_t)f->count;
  double w = weight_of(j);
  for (size_t r = 0; r < f->rows; r++)
    for (size_t c = 0; c < (size_t)f->channels; c++) {
      const float *x = j->number + r * f->width + c * count;
      double *sum = j->sum + r * b->size;
      size_t blocks = b->turn == SMALL_ALL ? 1 : (size_t)b->lmax + 1;
      for (size_t l = 0; l < blocks; l++) {
        size_t first = b->turn == SMALL_ALL ? 0 : l * l,
               n = b->turn == SMALL_ALL ? count : 2 * l + 1;
        for (size_t i = 0; i < n; i++) {
          double scaled = w * (double)x[first + i];
          for (size_t k = 0; k < n; k++) sum[i * n + k] += scaled * (double)x[first + k];
        }
        sum += n * n;
      }
    }
}

/* Columns of a matrix of products, as bytes: their largest entry is positive. */
static void keep_columns(size_t n, double *sum, int8_t *entry) {
  double v[SMALL_COLUMNS * SMALL_COLUMNS], value[SMALL_COLUMNS];
  eigenvectors(n, sum, v, value);
  for (size_t k = 0; k < n; k++) {
    size_t most = 0;
    for (size_t i = 1; i < n; i++)
      if (fabs(v[k * n + i]) > fabs(v[k * n + most])) most = i;
    double sign = v[k * n + most] < 0 ? -127 : 127;
    for (size_t i = 0; i < n; i++) entry[k * n + i] = (int8_t)floor(sign * v[k * n + i] + 0.5);
  }
}

static void learn_coefficients(learning *j, const int16_t *exponent) {
  small_frame *f = j->f;
  small_basis *b = &f->basis;
  small_turn turn = b->turn;
  b->turn = SMALL_AS_THEY_ARE; /* while differences are looked at */
  size_t apart = f->k->met / LEARNT_FROM + 1;
  for (size_t met = 0; met < f->k->met; met += apart) {
    difference(j, met, exponent);
    b->turn = turn;
    sum_products(j);
    b->turn = SMALL_AS_THEY_ARE;
  }
  b->turn = turn;
  for (size_t r = 0; r < b->kinds; r++) {
    double *sum = j->sum + r * b->size;
    int8_t *entry = b->entry + r * b->size;
    if (turn == SMALL_ALL) keep_columns((size_t)b->count, sum, entry);
    for (size_t l = 0; turn == SMALL_BY_DEGREE && l <= (size_t)b->lmax; l++) {
      size_t n = 2 * l + 1;
      keep_columns(n, sum, entry);
      sum += n * n;
      entry += n * n;
    }
  }
  ylm__small_settle(b);
}

ylm_status ylm__small_learn(small_frame *f, const int16_t *exponent, const int8_t *entry) {
  size_t n = f->rows * f->g->stride;
  learning j = {.f = f,
                .number = ylm_alloc(n, sizeof *j.number),
                .predicted = ylm_alloc(n, sizeof *j.predicted),
                .room = ylm_alloc(f->width, sizeof *j.room),
                .sum = ylm_alloc_zero(f->basis.kinds * f->basis.size + 1, sizeof *j.sum)};
  bool ok = j.number && j.predicted && j.room && j.sum;
  small_turn turn = f->basis.turn;
  f->basis.turn = SMALL_AS_THEY_ARE;
  ylm_status s = ok && f->colour ? learn_colours(&j, exponent) : YLM_OK;
  f->basis.turn = turn;
  if (ok && s == YLM_OK && turn != SMALL_AS_THEY_ARE && entry) {
    memcpy(f->basis.entry, entry, f->basis.kinds * f->basis.size);
    ylm__small_settle(&f->basis);
  } else if (ok && s == YLM_OK && turn != SMALL_AS_THEY_ARE)
    learn_coefficients(&j, exponent);
  ylm_free(j.number);
  ylm_free(j.predicted);
  ylm_free(j.room);
  ylm_free(j.sum);
  return ok ? s : YLM_ENOMEM;
}
