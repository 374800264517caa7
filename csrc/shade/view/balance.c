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

/* Irradiance that was left out of points of a cell, and the weight of all. */
typedef struct share_cell {
  double rare[2][3], weight;
} share_cell;

/* Cells of one size: the middle of one is `side` pixels from that of the next. Of each there are FACES. */
typedef struct balancing {
  const denoise_balance *b;
  size_t side, across, down; /* their numbers */
  balance_cell *cell;        /* [down][across][FACES] or NULL */
  const float (*rare)[2][3]; /* [points] or NULL */
  share_cell *share;         /* [down][across][FACES] or NULL */
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

/* Adds point i, of the weight w, to cell k. */
typedef void add_fn(const balancing *j, size_t i, double w, size_t k);
/* Gives point i its part of cell k, the one to the right of it, and those below. */
typedef void take_fn(const balancing *j, size_t i, size_t k, double left, double up);

/* Adds all filtered points of a row of cells. */
static void add_row(const balancing *j, size_t row, add_fn *f) {
  const ylm_shade_view *v = j->b->view;
  size_t width = (size_t)v->o.width, height = (size_t)v->o.height;
  size_t y = row > 0 ? (row - 1) * j->side : 0, stop = (row + 1) * j->side;
  for (; y < stop && y < height; y++) {
    double up, left;
    double down = cell_at(j, y, &up) == row ? 1 - up : up;
    for (size_t x = 0; x < width; x++) {
      size_t p = y * width + x, cell = row * j->across + cell_at(j, x, &left);
      for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++) {
        if (!(j->b->reach[i] >= 1)) continue;
        double w = down * (double)v->entry[i].weight;
        size_t k = cell * FACES + face_of(v->normal[i]);
        f(j, i, w * (1 - left), k);
        f(j, i, w * left, k + FACES);
      }
    }
  }
}

/* Calls f for all filtered points of a row of pixels. */
static void take_row(const balancing *j, size_t y, take_fn *f) {
  const ylm_shade_view *v = j->b->view;
  size_t width = (size_t)v->o.width;
  double up, left;
  size_t row = cell_at(j, y, &up) * j->across;
  for (size_t x = 0, p = y * width; x < width; x++, p++) {
    size_t cell = row + cell_at(j, x, &left);
    for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++)
      if (j->b->reach[i] >= 1) f(j, i, cell * FACES + face_of(v->normal[i]), left, up);
  }
}

/* Runs over rows of cells, then over rows of pixels. */
static ylm_status run(balancing *j, ylm_range_fn *gather, ylm_range_fn *spread, int threads) {
  ylm_status s = ylm_parallel(j->down, 1, threads, gather, j, NULL, NULL);
  size_t height = (size_t)j->b->view->o.height;
  return s == YLM_OK ? ylm_parallel(height, 1, threads, spread, j, NULL, NULL) : s;
}

static balancing cells_of(const denoise_balance *b, size_t side) {
  size_t width = (size_t)b->view->o.width, height = (size_t)b->view->o.height;
  return (balancing){.b = b, .side = side, .across = width / side + 2, .down = height / side + 2};
}

/* -- light that a filter moved ----------------------------------------------------------------------- */

static void add(const balancing *j, size_t i, double w, size_t k) {
  const denoise_balance *b = j->b;
  balance_cell *cell = j->cell + k;
  for (size_t h = 0; h < 2; h++)
    for (size_t c = 0; c < 3; c++) {
      cell->before[h][c] += w * (double)b->before[i][h][c];
      cell->after[h][c] += w * (double)b->half[h][3 * i + c];
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
  for (size_t row = begin; row < end; row++) {
    add_row(j, row, add);
    for (size_t k = 0; k < j->across * FACES; k++) settle(j->cell + row * j->across * FACES + k);
  }
  return YLM_OK;
}

/* Multiplies point i by the factors of its cells. */
static void scale(const balancing *j, size_t i, size_t first, double left, double up) {
  const balance_cell *cell = j->cell + first, *below = cell + j->across * FACES;
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
  for (size_t y = begin; y < end; y++) take_row(context, y, scale);
  return YLM_OK;
}

/* Balances cells of one size. */
static ylm_status balance(const denoise_balance *b, size_t side, int threads) {
  balancing j = cells_of(b, side);
  j.cell = ylm_alloc_zero(j.across * j.down * FACES, sizeof *j.cell);
  ylm_status s = j.cell ? run(&j, gather, spread, threads) : YLM_ENOMEM;
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

static void add_rare(const balancing *j, size_t i, double w, size_t k) {
  share_cell *cell = j->share + k;
  cell->weight += w;
  for (size_t h = 0; h < 2; h++)
    for (size_t c = 0; c < 3; c++) cell->rare[h][c] += w * (double)j->rare[i][h][c];
}

static ylm_status gather_rare(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  for (size_t row = begin; row < end; row++) add_row(context, row, add_rare);
  return YLM_OK;
}

/* Adds its part of the rare light of its cells to point i. */
static void take_rare(const balancing *j, size_t i, size_t first, double left, double up) {
  const share_cell *cell = j->share + first, *below = cell + j->across * FACES;
  const share_cell *of[4] = {cell, cell + FACES, below, below + FACES};
  const double part[4] = {(1 - left) * (1 - up), left * (1 - up), (1 - left) * up, left * up};
  float albedo[3];
  ylm__shade_albedo(j->b->view, i, albedo);
  for (size_t q = 0; q < 4; q++)
    for (size_t h = 0; of[q]->weight > 0 && h < 2; h++)
      for (size_t c = 0; c < 3; c++)
        j->b->half[h][3 * i + c] +=
            (float)(part[q] * of[q]->rare[h][c] / of[q]->weight) * albedo[c];
}

static ylm_status spread_rare(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  for (size_t y = begin; y < end; y++) take_row(context, y, take_rare);
  return YLM_OK;
}

ylm_status ylm__denoise_share(const denoise_balance *b, const float (*rare)[2][3], int threads) {
  balancing j = cells_of(b, BALANCE_RARE);
  j.rare = rare;
  j.share = ylm_alloc_zero(j.across * j.down * FACES, sizeof *j.share);
  ylm_status s = j.share ? run(&j, gather_rare, spread_rare, threads) : YLM_ENOMEM;
  ylm_free(j.share);
  return s;
}
