/*
** balance.c - light that a filter moved goes back: sums over cells of pixels become those of the light before.
**
** Cells are tents that overlap, of pixels whose surfaces face alike, and all tents of a pixel count 1 together: factors of tents,
** spread over their pixels, keep the sum over the picture, and have no edges. Large cells come first. A second pass brings back
** what the first let pass from cell to cell.
*/
#include <math.h>

#include "denoise.h"

enum { FACES = 6 };

/* Sums of a cell, of surfaces that face one way; then factors of their light. */
typedef struct balance_cell {
  double before[2][3], after[2][3], variance;
  float factor[2][3];
} balance_cell;

/* Cells of one size. */
typedef struct balancing {
  const denoise_balance *b;
  size_t side, across, down; /* pixels between the middles of cells; their numbers */
  balance_cell *cell;        /* [down][across][FACES] */
} balancing;

/* The axis that a normal is nearest to, of six. */
static size_t face_of(const float n[3]) {
  size_t axis = 0;
  for (size_t a = 1; a < 3; a++)
    if (fabsf(n[a]) > fabsf(n[axis])) axis = a;
  return 2 * axis + (n[axis] < 0);
}

/* The first of the two cells along an axis that share a pixel; *part: that of the second. */
static size_t cell_at(const balancing *j, size_t pixel, double *part) {
  double at = ((double)pixel + 0.5) / (double)j->side;
  *part = at - floor(at);
  return (size_t)at;
}

/* Adds point i to a cell. */
static void add(const balancing *j, size_t i, double w, balance_cell *cell) {
  const denoise_balance *b = j->b;
  for (size_t h = 0; h < 2; h++)
    for (size_t k = 0; k < 3; k++) {
      cell->before[h][k] += w * (double)b->before[i][h][k];
      cell->after[h][k] += w * (double)b->half[h][3 * i + k];
    }
  cell->variance += w * w * (double)b->variance[i] / 2;
}

static double luminance(double sum[2][3]) {
  return ylm_luminance(sum[0]) / 2 + ylm_luminance(sum[1]) / 2;
}

/* Sums become factors: 1 where the sum before is little more than noise. */
static void settle(balance_cell *cell) {
  double mean = luminance(cell->after);
  double noise = mean > 0 ? cell->variance / (mean * mean) : INFINITY;
  double part = 1 / (1 + pow(noise / (BALANCE_NOISE * BALANCE_NOISE), 2));
  for (size_t h = 0; h < 2; h++)
    for (size_t k = 0; k < 3; k++) {
      double after = cell->after[h][k];
      cell->factor[h][k] = after > 0 ? (float)(1 + part * (cell->before[h][k] / after - 1)) : 1;
    }
}

/* Factors of rows of cells. */
static ylm_status gather(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const balancing *j = context;
  const ylm_shade_view *v = j->b->view;
  size_t width = (size_t)v->o.width, height = (size_t)v->o.height;
  for (size_t row = begin; row < end; row++) {
    balance_cell *cells = j->cell + row * j->across * FACES;
    size_t y = row > 0 ? (row - 1) * j->side : 0, stop = (row + 1) * j->side;
    for (; y < stop && y < height; y++) {
      double up, left;
      double down = cell_at(j, y, &up) == row ? 1 - up : up;
      for (size_t x = 0; x < width; x++) {
        size_t p = y * width + x, cell = cell_at(j, x, &left);
        for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++) {
          if (!(j->b->reach[i] >= 1)) continue;
          double w = down * (double)v->entry[i].weight;
          balance_cell *to = cells + cell * FACES + face_of(v->normal[i]);
          add(j, i, w * (1 - left), to);
          add(j, i, w * left, to + FACES);
        }
      }
    }
    for (size_t k = 0; k < j->across * FACES; k++) settle(cells + k);
  }
  return YLM_OK;
}

/* Multiplies point i by factors of the four cells around, which begin at `cell`. */
static void scale(const balancing *j, size_t i, const balance_cell *cell, double left, double up) {
  const balance_cell *below = cell + j->across * FACES;
  for (size_t h = 0; h < 2; h++)
    for (size_t k = 0; k < 3; k++) {
      double top =
          (double)cell->factor[h][k] * (1 - left) + (double)cell[FACES].factor[h][k] * left;
      double foot =
          (double)below->factor[h][k] * (1 - left) + (double)below[FACES].factor[h][k] * left;
      j->b->half[h][3 * i + k] *= (float)(top * (1 - up) + foot * up);
    }
}

static ylm_status spread(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const balancing *j = context;
  const ylm_shade_view *v = j->b->view;
  size_t width = (size_t)v->o.width;
  for (size_t y = begin; y < end; y++) {
    double up, left;
    const balance_cell *cells = j->cell + cell_at(j, y, &up) * j->across * FACES;
    for (size_t x = 0, p = y * width; x < width; x++, p++) {
      size_t cell = cell_at(j, x, &left);
      for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++)
        if (j->b->reach[i] >= 1)
          scale(j, i, cells + cell * FACES + face_of(v->normal[i]), left, up);
    }
  }
  return YLM_OK;
}

/* Balances cells of one size. */
static ylm_status balance(const denoise_balance *b, size_t side, int threads) {
  size_t width = (size_t)b->view->o.width, height = (size_t)b->view->o.height;
  balancing j = {.b = b, .side = side, .across = width / side + 2, .down = height / side + 2};
  j.cell = ylm_alloc_zero(j.across * j.down * FACES, sizeof *j.cell);
  if (!j.cell) return YLM_ENOMEM;
  ylm_status s = ylm_parallel(j.down, 1, threads, gather, &j, NULL, NULL);
  if (s == YLM_OK) s = ylm_parallel(height, 1, threads, spread, &j, NULL, NULL);
  ylm_free(j.cell);
  return s;
}

ylm_status ylm__denoise_balance(const denoise_balance *b, int threads) {
  ylm_status s = YLM_OK;
  for (int pass = 0; pass < BALANCE_PASSES; pass++)
    for (size_t side = BALANCE_LARGEST; s == YLM_OK && side >= BALANCE_SMALLEST; side /= 2)
      s = balance(b, side, threads);
  return s;
}
