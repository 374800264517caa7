/* incremental.c - shading by a dynamic grid, again and again: only what an update changed is sampled. */
#include <string.h>

#include "../calibration.h"
#include "../view.h"
#include "ylm_sh.h"

struct ylm_shade_memory {
  size_t points;
  ylm_grid_track *track;
};

/* -- the order of points ----------------------------------------------------------------------- */

/* The points of the pixels of a tile, row by row; returns how many. */
static size_t list_tile(const ylm_shade_view *v, int x, int y, uint32_t *out) {
  size_t n = 0;
  int right = x + SHADE_TILE < v->o.width ? x + SHADE_TILE : v->o.width;
  int bottom = y + SHADE_TILE < v->o.height ? y + SHADE_TILE : v->o.height;
  for (; y < bottom; y++) {
    const shade_pixel *row = v->pixel + (size_t)y * (size_t)v->o.width;
    for (size_t i = row[x].first; i < row[right].first; i++) out[n++] = (uint32_t)i;
  }
  return n;
}

/* The points of all pixels, tile by tile; NULL without memory. */
static uint32_t *list_tiles(const ylm_shade_view *v) {
  uint32_t *order = ylm_alloc(v->points, sizeof *order);
  size_t n = 0;
  for (int y = 0; order && y < v->o.height; y += SHADE_TILE)
    for (int x = 0; x < v->o.width; x += SHADE_TILE) n += list_tile(v, x, y, order + n);
  return order;
}

ylm_status ylm_shade_memory_create(const ylm_shade_view *v, ylm_shade_memory **memory) {
  ylm_shade_memory *m = *memory = ylm_alloc_zero(1, sizeof *m);
  uint32_t *order = m && !v->corner ? list_tiles(v) : NULL;
  ylm_status s = m && (order || v->corner) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    m->points = v->points;
    s = ylm_grid_track_create(v->points, v->position[0], v->world, order, &m->track);
  }
  ylm_free(order);
  if (s == YLM_OK) return s;
  ylm_shade_memory_free(m);
  *memory = NULL;
  return s;
}

void ylm_shade_memory_free(ylm_shade_memory *m) {
  if (!m) return;
  ylm_grid_track_free(m->track);
  ylm_free(m);
}

/* -- shading ----------------------------------------------------------------------------------- */

typedef struct again_job {
  const ylm_shade_view *view;
  const ylm_grid_form *form;
  ylm_shade_dot_fn *dot;
  float *out;
} again_job;

/* Transfer vectors of a voxel's points stand in as many places as it has rows of pixels: they are
   asked for before they are needed. */
static void fetch(void *user, size_t n, const uint32_t *point) {
  const again_job *j = user;
  size_t row = ylm_sh_count(j->view->o.lmax);
  for (size_t i = 0; i < n; i++) {
    const float *T = j->view->transfer + row * point[i];
    for (size_t k = 0; k < row; k += 16) __builtin_prefetch(T + k, 0, 2);
    __builtin_prefetch(T + row - 1, 0, 2);
    __builtin_prefetch(j->out + 3 * point[i], 1, 2);
  }
}

static void shade(void *user, size_t n, const uint32_t *point, size_t row, const float *value) {
  const again_job *j = user;
  shade_light x = {j->form->channels, j->form->lmax, YLM_FLOAT, value};
  ylm__shade_some(j->view, j->dot, n, point, &x, row, j->out);
}

ylm_status ylm_shade_grid_again(const ylm_shade_view *v, ylm_shade_memory *m, const ylm_grid *grid,
                                ylm_grid_interpolation how, int threads,
                                const ylm_progress *progress, float *out, ylm_grid_report *report,
                                uint64_t *fresh, ylm_error *e) {
  if (m->points != v->points) return YLM_ESHAPE;
  if (!v->transfer || v->gloss) {
    *fresh = v->points;
    return ylm_shade_grid(v, grid, YLM_SHADE_TRANSFER, how, NULL, threads, progress, out, report,
                          e);
  }
  again_job j = {v, &ylm_grid_look(grid)->form, ylm__shade_kernels().dot, out};
  ylm_status s = ylm_grid_track_sample(m->track, grid, how, threads, progress,
                                       &(ylm_grid_taker){fetch, shade, &j}, fresh, report);
  if (s != YLM_EINVAL) return s;
  *fresh = v->points;
  return ylm_shade_grid(v, grid, YLM_SHADE_TRANSFER, how, NULL, threads, progress, out, report, e);
}
