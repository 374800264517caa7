/*
** lamps.c - lamps over a picture: which tiles of it they touch is found here, the rest on
** the device.
*/
#include "../gen/layout.h"
#include "picture.h"

#define TILE ((uint32_t)YLM_GPU_PIXEL_TILE)

/* picture_lamps.real.comp */
typedef struct gpu_tile {
  uint32_t x, y, begin, end;
} gpu_tile;

/* The tiles of all discs: `count` of each, then where the next entry of its list goes. */
typedef struct tiling {
  uint32_t across, down;
  uint32_t *at; /* [across * down + 1] */
  uint32_t *list;
  gpu_tile *tile;
  size_t tiles, entries;
} tiling;

/* Columns and rows of tiles that a disc's box touches: x0, x1, y0, y1. False: none. */
static bool touched(const ylm_gpu_picture *k, const double *disc, uint32_t t[4]) {
  double side[] = {k->width, k->width, k->height, k->height};
  for (int i = 0; i < 4; i++) {
    double x = disc[8 + i];
    if (!(x > 0)) x = 0;
    if (x > side[i]) x = side[i];
    t[i] = i % 2 ? ((uint32_t)x + TILE - 1) / TILE : (uint32_t)x / TILE;
  }
  return t[0] < t[1] && t[2] < t[3];
}

/* Counts, or with `list` enters, each disc in its tiles; in the order of the discs. */
static void enter(const ylm_gpu_picture *k, tiling *t, size_t n, const double *disc) {
  for (size_t i = 0; i < n; i++) {
    uint32_t b[4];
    if (!touched(k, disc + YLM_GPU_DISC * i, b)) continue;
    for (uint32_t y = b[2]; y < b[3]; y++)
      for (uint32_t x = b[0]; x < b[1]; x++) {
        uint32_t *at = &t->at[y * t->across + x];
        if (t->list) t->list[*at] = (uint32_t)i;
        ++*at;
      }
  }
}

/* Counts to beginnings; notes the tiles that have any. */
static void number(tiling *t) {
  uint32_t sum = 0;
  for (uint32_t i = 0; i < t->across * t->down; i++) {
    uint32_t count = t->at[i];
    t->at[i] = sum;
    sum += count;
    if (count && t->tile)
      t->tile[t->tiles++] =
          (gpu_tile){i % t->across * TILE, i / t->across * TILE, sum - count, sum};
  }
}

/* How many entries all lists have together, up to 2^32. */
static uint64_t total(const ylm_gpu_picture *k, size_t n, const double *disc) {
  uint64_t sum = 0;
  for (size_t i = 0; i < n && sum <= UINT32_MAX; i++) {
    uint32_t b[4];
    if (touched(k, disc + YLM_GPU_DISC * i, b)) sum += (uint64_t)(b[1] - b[0]) * (b[3] - b[2]);
  }
  return sum;
}

static ylm_status tile_discs(const ylm_gpu_picture *k, size_t n, const double *disc, tiling *t,
                             ylm_error *e) {
  uint64_t entries = total(k, n, disc);
  *t = (tiling){.across = (k->width + TILE - 1) / TILE, .down = (k->height + TILE - 1) / TILE};
  size_t tiles = (size_t)t->across * t->down;
  if (4 * entries > ylm_gpu_about(k->g)->bind_bytes)
    return ylm_fail(e, YLM_ELIMIT, "%zu lamps touch %.0f million tiles of the picture", n,
                    (double)entries / 1e6);
  t->at = ylm_alloc_zero(tiles + 1, sizeof *t->at);
  uint32_t *list = ylm_alloc((size_t)entries + 1, sizeof *list);
  t->tile = ylm_alloc(tiles < entries ? tiles : (size_t)entries + 1, sizeof *t->tile);
  t->entries = (size_t)entries;
  if (t->at && list && t->tile) {
    enter(k, t, n, disc);
    number(t);
    t->list = list;
    enter(k, t, n, disc);
    return YLM_OK;
  }
  ylm_free(list);
  return ylm_no_memory(e);
}

static ylm_status upload(ylm_gpu_picture *k, size_t n, const double *disc, const tiling *t,
                         ylm_error *e) {
  ylm_gpu *g = k->g;
  size_t tiles = t->tiles * sizeof *t->tile, list = t->entries * sizeof *t->list;
  ylm_status s = ylm__picture_reals(k, disc, n * YLM_GPU_DISC, &k->disc, e);
  if (s == YLM_OK) s = ylm__steps_reserve(g, &k->tile, tiles, e);
  if (s == YLM_OK) s = ylm__steps_reserve(g, &k->list, list, e);
  if (s == YLM_OK) s = ylm_gpu_upload(k->tile, 0, tiles, t->tile, e);
  return s == YLM_OK ? ylm_gpu_upload(k->list, 0, list, t->list, e) : s;
}

static void dispatch(ylm_gpu_picture *k, const tiling *t, ylm_gpu_buffer *image, ylm_error *e) {
  uint32_t constant[] = {TILE * TILE}, push[] = {k->width, k->height};
  ylm_gpu_work w = {.verb = YLM_GPU_DISPATCH,
                    .groups = t->tiles,
                    .cost = (double)t->entries / (double)t->tiles,
                    .push = push,
                    .push_bytes = sizeof push,
                    .binds = 8};
  ylm_gpu_buffer *buffer[] = {k->first, k->weight, k->depth, k->camera,
                              k->disc,  k->tile,   k->list,  image};
  for (int i = 0; i < 8; i++) w.bind[i].buffer = buffer[i];
  k->queue.status = ylm_gpu_kernel_get(
      k->g, k->wide ? "picture_lamps_double" : "picture_lamps_float", 1, constant, &w.kernel, e);
  k->queue.stage = "lamps";
  ylm__steps_work(&k->queue, &w);
}

void ylm__picture_lamps(ylm_gpu_picture *k, size_t n, const double *disc, ylm_gpu_buffer *image,
                        ylm_gpu_times *times, ylm_error *e) {
  tiling t = {0};
  if (k->queue.status != YLM_OK) return;
  double start = ylm_seconds();
  ylm_status s = tile_discs(k, n, disc, &t, e);
  if (s == YLM_OK && t.tiles) s = upload(k, n, disc, &t, e);
  ylm__steps_copied(times, "upload", start);
  k->queue.status = s;
  if (s == YLM_OK && t.tiles) dispatch(k, &t, image, e);
  ylm_free(t.at);
  ylm_free(t.list);
  ylm_free(t.tile);
}
