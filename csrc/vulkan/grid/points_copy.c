/* points_copy.c - the grid's copy of rows that are on the device since they were evaluated. */
#include <string.h>

#include "points.h"

/* Parts as long as the finished grid's rows; those there are are kept. */
static ylm_status fit_parts(gpu_points *p, uint64_t rows) {
  uint64_t row = 16 * (uint64_t)p->stride;
  ylm_status s = YLM_OK;
  for (uint64_t at = 0, k = 0; s == YLM_OK && at < rows; at += p->part_rows, k++) {
    uint64_t wanted = rows - at < p->part_rows ? rows - at : p->part_rows;
    uint64_t used = p->points > at ? p->points - at : 0;
    if (p->data[k] && ylm_gpu_buffer_bytes(p->data[k]) == wanted * row) continue;
    s = ylm__points_grow(p, &p->data[k], (used < wanted ? used : wanted) * row, wanted * row);
    p->parts = (int)k + 1;
  }
  return s;
}

/* Points in lights were filled by the host. */
static ylm_status put_filled(gpu_points *p, const ylm_grid_contents *v) {
  size_t n = 0, row = 4 * v->stride;
  for (size_t i = 0; i < v->evaluated; i++) n += (v->flags[i] & YLM_GRID_POINT_INVALID) != 0;
  if (!n) return YLM_OK;
  uint32_t *point = ylm_alloc(n, sizeof *point);
  float *rows = ylm_alloc(n * row, sizeof *rows);
  ylm_status s = point && rows ? YLM_OK : ylm_no_memory(p->e);
  for (size_t i = 0, k = 0; s == YLM_OK && i < v->evaluated; i++) {
    if (!(v->flags[i] & YLM_GRID_POINT_INVALID)) continue;
    memcpy(rows + k * row, v->data + i * row, row * sizeof *rows);
    point[k++] = (uint32_t)i;
  }
  if (s == YLM_OK) s = ylm__points_put(p, n, point, rows);
  ylm_free(point);
  ylm_free(rows);
  return s;
}

/* -- points that only continuity needs -------------------------------------------------------- */

/* shaders/grid_birth.comp */
typedef struct gpu_birth {
  uint32_t cell, place, row;
} gpu_birth;

/* Births by the level of their cells; first[k] is where those of level k begin. */
static ylm_status sort_births(gpu_points *p, const ylm_grid_contents *v,
                              uint32_t first[YLM_GRID_MAX_DEPTH + 2], ylm_gpu_buffer **births) {
  uint32_t n = (uint32_t)(v->points - v->evaluated), next[YLM_GRID_MAX_DEPTH + 2];
  gpu_birth *list = ylm_alloc(n, sizeof *list);
  if (!list) return ylm_no_memory(p->e);
  memset(first, 0, (YLM_GRID_MAX_DEPTH + 2) * sizeof *first);
  for (uint32_t i = 0; i < n; i++) first[v->cell[v->birth[i].cell].level + 1]++;
  for (int k = 0; k <= YLM_GRID_MAX_DEPTH; k++) first[k + 1] += first[k];
  memcpy(next, first, sizeof next);
  for (uint32_t i = 0; i < n; i++) {
    const ylm_grid_birth *b = &v->birth[i];
    list[next[v->cell[b->cell].level]++] =
        (gpu_birth){b->cell, b->place, (uint32_t)v->evaluated + i};
  }
  double start = ylm_seconds();
  ylm_status s = ylm_gpu_buffer_from(p->g, n * sizeof *list, list, births, p->e);
  points_copied(p, "upload", start);
  ylm_free(list);
  return s;
}

/* Corners of a cell were born of coarser cells, so levels follow one another. */
static ylm_status give_birth(gpu_points *p, const ylm_grid_contents *v, ylm_gpu_buffer *cells) {
  uint32_t first[YLM_GRID_MAX_DEPTH + 2];
  ylm_gpu_buffer *births = NULL, *bind[GRID_PARTS + 2];
  if (v->points == v->evaluated) return YLM_OK;
  ylm_status s = sort_births(p, v, first, &births);
  points_bind(p, bind);
  bind[GRID_PARTS] = cells;
  bind[GRID_PARTS + 1] = births;
  p->q.stage = "continuity";
  p->q.status = YLM_OK;
  for (int k = 0; s == YLM_OK && k <= YLM_GRID_MAX_DEPTH; k++) {
    uint32_t n = first[k + 1] - first[k];
    step_kernel birth = {"grid_birth", 4, {0, 0, 0, (uint32_t)p->parts}, (double)p->stride};
    uint32_t push[7] = {n, first[k], p->stride, (uint32_t)p->part_rows};
    ylm__points_unit(p, push + 4);
    ylm__steps_dispatch(&p->q, &birth, 8 * (uint64_t)n, 7, push, GRID_PARTS + 2, bind);
  }
  if (s == YLM_OK) s = ylm__steps_run(&p->q);
  ylm_gpu_buffer_free(births);
  return s;
}

/* -- the copy ---------------------------------------------------------------------------------- */

static ylm_status make_copy(gpu_points *p, const ylm_grid_contents *v, ylm_gpu_grid *k) {
  ylm_status s = fit_parts(p, v->points);
  if (s == YLM_OK) s = put_filled(p, v);
  return s == YLM_OK ? give_birth(p, v, k->cells) : s;
}

ylm_status ylm__points_copy(gpu_points *p, ylm_gpu_grid **copy) {
  const ylm_grid_contents *v = ylm_grid_look(p->grid);
  uint64_t bytes = 16 * (uint64_t)p->stride * v->points;
  ylm_gpu_grid *k = NULL;
  *copy = NULL;
  if (p->first || p->points != v->evaluated || bytes > ylm__points_most_bytes(p)) return YLM_OK;
  double start = ylm_seconds();
  ylm_status s = ylm__gpu_grid_begin(p->g, p->grid, false, &k, p->e);
  points_copied(p, "upload", start);
  if (s == YLM_OK) s = make_copy(p, v, k);
  if (s == YLM_OK) {
    k->parts = p->parts;
    k->part_rows = (size_t)p->part_rows;
    memcpy(k->data, p->data, sizeof k->data);
    memset(p->data, 0, sizeof p->data);
    *copy = k;
    return YLM_OK;
  }
  ylm_gpu_grid_free(k);
  /* The grid is there without: it is copied when it is first sampled. */
  return s == YLM_ENOMEM || s == YLM_ELIMIT ? YLM_OK : s;
}
