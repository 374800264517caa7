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

/* -- light of rare rays ---------------------------------------------------------------------------- */

/* Irradiance that was left out of the pixels of a cell, and the weight of its points. */
typedef struct share_cell {
  double rare[2][3], weight;
} share_cell;

typedef struct sharing {
  balancing cells; /* without their sums */
  const uint32_t *point;
  const float (*rare)[2][3];
  share_cell *cell;
} sharing;

static bool is_filtered(const denoise_balance *b, size_t i) { return b->reach[i] >= 1; }

/* Adds pixel p, of the tent w, to a row's cells at `cell`, and the next ones. */
static void add_rare(const sharing *j, size_t p, double w, double left, share_cell *cell) {
  const denoise_balance *b = j->cells.b;
  const ylm_shade_view *v = b->view;
  for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++) {
    if (!is_filtered(b, i)) continue;
    share_cell *to = cell + face_of(v->normal[i]);
    double weight = w * (double)v->entry[i].weight;
    to->weight += weight * (1 - left);
    to[FACES].weight += weight * left;
    for (size_t h = 0; j->point[p] == i && h < 2; h++)
      for (size_t k = 0; k < 3; k++) {
        double rare = weight * (double)j->rare[p][h][k];
        to->rare[h][k] += rare * (1 - left);
        to[FACES].rare[h][k] += rare * left;
      }
  }
}

static ylm_status gather_rare(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const sharing *j = context;
  const balancing *of = &j->cells;
  size_t width = (size_t)of->b->view->o.width, height = (size_t)of->b->view->o.height;
  for (size_t row = begin; row < end; row++) {
    size_t y = row > 0 ? (row - 1) * of->side : 0, stop = (row + 1) * of->side;
    for (; y < stop && y < height; y++) {
      double up, left;
      double down = cell_at(of, y, &up) == row ? 1 - up : up;
      for (size_t x = 0; x < width; x++) {
        size_t cell = cell_at(of, x, &left);
        add_rare(j, y * width + x, down, left, j->cell + (row * of->across + cell) * FACES);
      }
    }
  }
  return YLM_OK;
}

/* Adds to point i its part of the four cells around, which begin at `cell`. */
static void take_rare(const sharing *j, size_t i, const share_cell *cell, double left, double up) {
  const denoise_balance *b = j->cells.b;
  const share_cell *below = cell + j->cells.across * FACES;
  const share_cell *of[4] = {cell, cell + FACES, below, below + FACES};
  const double part[4] = {(1 - left) * (1 - up), left * (1 - up), (1 - left) * up, left * up};
  float albedo[3];
  ylm__shade_albedo(b->view, i, albedo);
  for (size_t q = 0; q < 4; q++)
    for (size_t h = 0; of[q]->weight > 0 && h < 2; h++)
      for (size_t k = 0; k < 3; k++)
        b->half[h][3 * i + k] += (float)(part[q] * of[q]->rare[h][k] / of[q]->weight) * albedo[k];
}

static ylm_status spread_rare(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const sharing *j = context;
  const balancing *of = &j->cells;
  const ylm_shade_view *v = of->b->view;
  size_t width = (size_t)v->o.width;
  for (size_t y = begin; y < end; y++) {
    double up, left;
    const share_cell *cells = j->cell + cell_at(of, y, &up) * of->across * FACES;
    for (size_t x = 0, p = y * width; x < width; x++, p++) {
      size_t cell = cell_at(of, x, &left);
      for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++)
        if (is_filtered(of->b, i))
          take_rare(j, i, cells + cell * FACES + face_of(v->normal[i]), left, up);
    }
  }
  return YLM_OK;
}

ylm_status ylm__denoise_share(const denoise_balance *b, const uint32_t *point,
                              const float (*rare)[2][3], int threads) {
  size_t width = (size_t)b->view->o.width, height = (size_t)b->view->o.height;
  sharing j = {.cells = {.b = b,
                         .side = BALANCE_RARE,
                         .across = width / BALANCE_RARE + 2,
                         .down = height / BALANCE_RARE + 2},
               .point = point,
               .rare = rare};
  j.cell = ylm_alloc_zero(j.cells.across * j.cells.down * FACES, sizeof *j.cell);
  if (!j.cell) return YLM_ENOMEM;
  ylm_status s = ylm_parallel(j.cells.down, 1, threads, gather_rare, &j, NULL, NULL);
  if (s == YLM_OK) s = ylm_parallel(height, 1, threads, spread_rare, &j, NULL, NULL);
  ylm_free(j.cell);
  return s;
}
