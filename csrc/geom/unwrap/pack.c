/*
** pack.c - charts laid out on texels: the largest first, each where it ends highest up, as it is or turned by a quarter.
**
** A chart is a mask of the texels that look-ups in it read. The picture keeps the texels that are taken, gutters included. Of
** a few widths the one with the smallest picture stays.
*/
#include <math.h>
#include <stdlib.h>

#include "unwrap.h"

#define WIDTHS_FEW 3000 /* charts for which several widths are tried */
#define CLASSES 9500    /* of sizes, of which rows that are full are remembered */
static const double width_factor[] = {1, 0.94, 1.06, 0.88, 1.12, 1.2};

/* -- a picture that fills --------------------------------------------------------------------------- */

typedef struct sheet {
  unwrap_mask taken; /* height: rows that there is room for */
  size_t rows, columns, gutter;
  uint32_t full[CLASSES]; /* [classes] rows above which no chart of the size has found a place */
} sheet;

/* A mask, of each row its first bit, and whether it has no gaps. */
typedef struct stamp {
  unwrap_mask m;
  uint32_t *first;
  bool *solid;
} stamp;

static void free_stamp(stamp *p) {
  ylm_free(p->m.bit);
  ylm_free(p->first);
  ylm_free(p->solid);
}

static ylm_status make_stamp(const ylm_unwrap *u, const unwrap_chart *c, stamp *p) {
  *p = (stamp){.first = NULL};
  ylm_status s = ylm__unwrap_mask(u, c, &p->m);
  if (s != YLM_OK) return s;
  p->first = ylm_alloc_zero(p->m.height, sizeof *p->first);
  p->solid = ylm_alloc_zero(p->m.height, sizeof *p->solid);
  if (!p->first || !p->solid) return YLM_ENOMEM;
  for (size_t y = 0; y < p->m.height; y++) {
    size_t runs = 0;
    bool before = false;
    for (size_t x = 0; x < p->m.width; x++) {
      bool is = unwrap_is_set(&p->m, x, y);
      if (is && !before && !runs++) p->first[y] = (uint32_t)x;
      before = is;
    }
    p->solid[y] = runs == 1;
  }
  return YLM_OK;
}

/* 64 texels of a row from x on. */
static uint64_t bits_at(const unwrap_mask *m, size_t y, size_t x) {
  const uint64_t *row = m->bit + y * m->words;
  size_t w = x / 64, shift = x % 64;
  uint64_t low = w < m->words ? row[w] >> shift : 0;
  return shift && w + 1 < m->words ? low | row[w + 1] << (64 - shift) : low;
}

/* 0: a stamp is free at (x, y); else how far to the right it may be, at least. */
static size_t blocked(const sheet *f, const stamp *p, size_t x, size_t y) {
  for (size_t r = 0; r < p->m.height && y + r < f->rows; r++)
    for (size_t w = 0; w < p->m.words; w++) {
      uint64_t hit = p->m.bit[r * p->m.words + w] & bits_at(&f->taken, y + r, x + 64 * w);
      if (!hit) continue;
      size_t last = 64 * w + 63 - (size_t)__builtin_clzll(hit);
      return p->solid[r] ? last - p->first[r] + 1 : 1;
    }
  return 0;
}

/* Lengths by less than an eighth are one class. */
static size_t class_of(size_t n) {
  size_t shift = 0;
  while (n >> shift >= 16) shift++;
  return n < 16 ? n : 8 * shift + (n >> shift);
}

static uint32_t *rows_full(sheet *f, const stamp *p) {
  return &f->full[(class_of(p->m.width) * 97 + class_of(p->m.height)) % CLASSES];
}

/* The first free place, row by row. False: the stamp is wider than the picture. */
static bool find(sheet *f, const stamp *p, size_t at[2]) {
  if (p->m.width > f->taken.width) return false;
  for (size_t y = *rows_full(f, p);; y++) {
    size_t x = 0, most = f->taken.width - p->m.width;
    while (x <= most) {
      size_t step = blocked(f, p, x, y);
      if (!step) {
        at[0] = x, at[1] = y;
        *rows_full(f, p) = (uint32_t)y;
        return true;
      }
      x += step;
    }
  }
}

static ylm_status reserve(sheet *f, size_t rows) {
  if (rows <= f->taken.height) return YLM_OK;
  size_t room = rows + rows / 2 + 64;
  uint64_t *bit = ylm_alloc_zero(room * f->taken.words, sizeof *bit);
  if (!bit) return YLM_ENOMEM;
  if (f->rows) memcpy(bit, f->taken.bit, f->rows * f->taken.words * sizeof *bit);
  ylm_free(f->taken.bit);
  f->taken.bit = bit;
  f->taken.height = room;
  return YLM_OK;
}

/* Takes the texels of a stamp, and those around it. */
static ylm_status take(sheet *f, const stamp *p, const size_t at[2]) {
  size_t g = f->gutter, below = at[1] + p->m.height + g;
  ylm_status s = reserve(f, below);
  if (s != YLM_OK) return s;
  for (size_t r = 0; r < p->m.height; r++)
    for (size_t x = 0; x < p->m.width; x++) {
      if (!unwrap_is_set(&p->m, x, r)) continue;
      size_t end = x;
      while (end + 1 < p->m.width && unwrap_is_set(&p->m, end + 1, r)) end++;
      size_t from = at[0] + x > g ? at[0] + x - g : 0, to = at[0] + end + g;
      if (to >= f->taken.width) to = f->taken.width - 1;
      for (size_t y = at[1] + r > g ? at[1] + r - g : 0; y <= at[1] + r + g; y++)
        ylm__unwrap_set(&f->taken, y, from, to);
      x = end;
    }
  if (f->rows < below) f->rows = below;
  if (f->columns < at[0] + p->m.width) f->columns = at[0] + p->m.width;
  return YLM_OK;
}

/* -- charts ------------------------------------------------------------------------------------------ */

typedef struct turn {
  size_t longest, texels;
  uint32_t chart;
} turn;

static int by_size(const void *a, const void *b) {
  const turn *p = a, *q = b;
  if (p->longest != q->longest) return p->longest > q->longest ? -1 : 1;
  if (p->texels != q->texels) return p->texels > q->texels ? -1 : 1;
  return p->chart < q->chart ? -1 : p->chart > q->chart;
}

static size_t side_of(const unwrap_chart *c, int a) {
  return (size_t)(c->scale[a] * c->size[a] + 0.5) + 1;
}

/* Lays one chart out, as it is or turned: where its last row is higher. */
static ylm_status lay(unwrap_chart *c, const stamp way[2], sheet *f) {
  size_t at[2][2], end[2] = {SIZE_MAX, SIZE_MAX};
  for (int k = 0; k < 2; k++)
    if (way[k].m.bit && find(f, &way[k], at[k])) end[k] = at[k][1] + way[k].m.height;
  c->turned = end[1] < end[0];
  memcpy(c->at, at[c->turned], sizeof c->at);
  return take(f, &way[c->turned], at[c->turned]);
}

/* Both ways of all charts, [charts][2]; a square has one. */
static ylm_status make_stamps(ylm_unwrap *u, stamp (*way)[2]) {
  ylm_status s = YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < u->charts; i++) {
    unwrap_chart *c = &u->chart[i];
    bool square = side_of(c, 0) == side_of(c, 1) && c->triangles <= 2;
    for (int k = 0; s == YLM_OK && k < (square ? 1 : 2); k++) {
      c->turned = k;
      s = make_stamp(u, c, &way[i][k]);
    }
  }
  return s;
}

/* All charts on a picture of this width; its columns and rows. */
static ylm_status lay_all(ylm_unwrap *u, const turn *order, stamp (*way)[2], size_t width,
                          int gutter, size_t used[2]) {
  sheet *f = ylm_alloc_zero(1, sizeof *f);
  if (!f) return YLM_ENOMEM;
  f->taken.width = width;
  f->taken.words = (width + 63) / 64;
  f->gutter = (size_t)gutter;
  ylm_status s = YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < u->charts; i++)
    s = lay(&u->chart[order[i].chart], way[order[i].chart], f);
  used[0] = f->columns;
  used[1] = f->rows - f->gutter;
  ylm_free(f->taken.bit);
  ylm_free(f);
  return s;
}

static size_t by_four(size_t n) { return (n + 3) / 4 * 4; }

typedef struct laid {
  size_t at[2];
  bool turned;
} laid;

/* The best of a few widths. */
static ylm_status try_widths(ylm_unwrap *u, const turn *order, stamp (*way)[2], double texels,
                             size_t least, int gutter, laid *best) {
  size_t least_area = SIZE_MAX, tries = sizeof width_factor / sizeof *width_factor;
  ylm_status s = YLM_OK;
  if (u->charts > WIDTHS_FEW) tries = 1;
  for (size_t k = 0; s == YLM_OK && k < tries; k++) {
    size_t used[2], width = by_four((size_t)(sqrt(texels) * width_factor[k]) + 1);
    if (width < least) width = least;
    if (width > YLM_UNWRAP_SIDE) width = YLM_UNWRAP_SIDE;
    s = lay_all(u, order, way, width, gutter, used);
    if (s != YLM_OK || by_four(used[0]) * by_four(used[1]) >= least_area) continue;
    u->width = by_four(used[0]);
    u->height = by_four(used[1]);
    least_area = u->width * u->height;
    for (size_t i = 0; i < u->charts; i++) {
      memcpy(best[i].at, u->chart[i].at, sizeof best[i].at);
      best[i].turned = u->chart[i].turned;
    }
  }
  return s;
}

/* Texels that charts are looked up from, and the mean density. */
static ylm_status measure(ylm_unwrap *u) {
  double texels = 0, area = 0;
  u->used = 0;
  for (size_t i = 0; i < u->charts; i++) {
    const unwrap_chart *c = &u->chart[i];
    unwrap_mask m;
    ylm_status s = ylm__unwrap_mask(u, c, &m);
    if (s != YLM_OK) return s;
    for (size_t k = 0; k < m.words * m.height; k++)
      u->used += (size_t)__builtin_popcountll(m.bit[k]);
    ylm_free(m.bit);
    area += c->area;
    texels += c->area * c->scale[0] * c->scale[1];
  }
  u->stats.width = u->width;
  u->stats.height = u->height;
  u->stats.share = (double)u->used / (double)(u->width * u->height);
  u->stats.density = sqrt(texels / area);
  return YLM_OK;
}

static ylm_status too_large(ylm_error *e) {
  return ylm_fail(e, YLM_ELIMIT,
                  "the charts need more than %d texels along a side: ask for fewer texels a unit",
                  YLM_UNWRAP_SIDE);
}

/* Scales all charts; the texels of their rectangles with gutters, and the least width that takes all. */
static ylm_status scale_all(ylm_unwrap *u, const double *density, double factor, int gutter,
                            double *texels, size_t *least, ylm_error *e) {
  *texels = 0;
  *least = 1;
  for (size_t i = 0; i < u->charts; i++) {
    unwrap_chart *c = &u->chart[i];
    double side[2];
    for (int a = 0; a < 2; a++) {
      side[a] = fmax(1, round(density[i] * factor * c->size[a]));
      if (!(side[a] < YLM_UNWRAP_SIDE)) return too_large(e);
      c->scale[a] = side[a] / c->size[a];
    }
    *texels += (side[0] + 1 + gutter) * (side[1] + 1 + gutter);
    *least = (size_t)fmax((double)*least, fmin(side[0], side[1]) + 1);
  }
  return *texels > (double)YLM_UNWRAP_SIDE * YLM_UNWRAP_SIDE ? too_large(e) : YLM_OK;
}

static ylm_status pack(ylm_unwrap *u, const double *density, double factor, int gutter,
                       ylm_error *e) {
  double texels;
  size_t least;
  ylm_status s = scale_all(u, density, factor, gutter, &texels, &least, e);
  if (s != YLM_OK) return s;
  turn *order = ylm_alloc(u->charts, sizeof *order);
  laid *best = ylm_alloc(u->charts, sizeof *best);
  stamp(*way)[2] = ylm_alloc_zero(u->charts, sizeof *way);
  s = order && best && way ? make_stamps(u, way) : ylm_no_memory(e);
  for (size_t i = 0; s == YLM_OK && i < u->charts; i++) {
    size_t w = side_of(&u->chart[i], 0), h = side_of(&u->chart[i], 1);
    order[i] = (turn){w > h ? w : h, w * h, (uint32_t)i};
  }
  if (s == YLM_OK) qsort(order, u->charts, sizeof *order, by_size);
  if (s == YLM_OK) s = try_widths(u, order, way, texels, least, gutter, best);
  for (size_t i = 0; s == YLM_OK && i < u->charts; i++) {
    memcpy(u->chart[i].at, best[i].at, sizeof best[i].at);
    u->chart[i].turned = best[i].turned;
  }
  for (size_t i = 0; way && i < 2 * u->charts; i++) free_stamp(&way[i / 2][i % 2]);
  ylm_free(order);
  ylm_free(best);
  ylm_free(way);
  if (s == YLM_OK && u->height > YLM_UNWRAP_SIDE) return too_large(e);
  return s;
}

static ylm_status check(const ylm_unwrap *u, const double *density, int gutter, ylm_error *e) {
  if (gutter < 0 || gutter > 64)
    return ylm_fail(e, YLM_ERANGE, "gutter must be from 0 to 64, got %d", gutter);
  for (size_t i = 0; i < u->charts; i++)
    if (!(density[i] > 0) || !isfinite(density[i]))
      return ylm_fail(e, YLM_ERANGE, "the density of chart %zu must be above 0, got %g", i + 1,
                      density[i]);
  return YLM_OK;
}

ylm_status ylm_unwrap_pack(ylm_unwrap *u, const double *density, int gutter, ylm_error *e) {
  ylm_status s = check(u, density, gutter, e);
  if (s == YLM_OK) s = pack(u, density, 1, gutter, e);
  return s == YLM_OK ? measure(u) : s;
}

/* The next factor to try between two: as areas grow with its square. */
static double next_factor(double f, double area, double texels, double low, double high) {
  double next = f * sqrt(texels / area) * (area > texels ? 0.993 : 1.0);
  if (next > low * 1.0005 && next < high * 0.9995) return next;
  return low > 0 && high < INFINITY ? sqrt(low * high) : next;
}

ylm_status ylm_unwrap_fit(ylm_unwrap *u, const double *density, int gutter, size_t texels,
                          double *factor, ylm_error *e) {
  double total = 0, low = 0, high = INFINITY, least = INFINITY;
  ylm_status s = check(u, density, gutter, e);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < u->charts; i++) total += u->chart[i].area * density[i] * density[i];
  double f = 0.85 * sqrt((double)texels / total), last = 0;
  int fits = u->charts > WIDTHS_FEW ? FITS_MANY : FITS;
  for (int k = 0; k < 2 * FITS && (k < fits || low == 0); k++) {
    s = pack(u, density, f, gutter, e);
    if (s != YLM_OK && s != YLM_ELIMIT) return s;
    double area = s == YLM_OK ? (double)(u->width * u->height) : 4 * (double)texels;
    last = f;
    least = fmin(least, area);
    if (area <= (double)texels) {
      low = fmax(low, f);
      if (area >= FIT_NEAR * (double)texels) break;
    } else
      high = fmin(high, f);
    f = next_factor(f, area, (double)texels, low, high);
  }
  if (low == 0)
    return ylm_fail(e, YLM_ELIMIT,
                    "%zu charts with gutters of %d do not fit into %zu texels, but into %.0f",
                    u->charts, gutter, texels, least);
  s = last == low ? YLM_OK : pack(u, density, low, gutter, e);
  if (factor) *factor = low;
  return s == YLM_OK ? measure(u) : s;
}
