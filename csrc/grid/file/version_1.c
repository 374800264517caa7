/*
** version_1.c - grids from files of version 1, which ylm reads and does not write.
**
** Such a file is, in the byte order of its writer and without padding:
**   magic 8 bytes, u32 0x01020304 (tells the byte order), u32 version, u64 size of the file,
**   form, counts, stats; then array after array: cells, points; last a CRC-64/XZ of all before.
** Interpolated points have rows in it, and no births: those are found again.
*/
#include "file.h"

#include <string.h>

/* A cursor: numbers are copied out of the file, never from outside of it. */
typedef struct stream {
  const unsigned char *data;
  size_t at, size;
  bool swap, failed;
} stream;

/* `n` numbers of `size` bytes to x, from the file's byte order. */
static void numbers(stream *s, void *x, size_t n, size_t size) {
  size_t bytes;
  if (s->failed || __builtin_mul_overflow(n, size, &bytes) || bytes > s->size - s->at) {
    s->failed = true;
    return;
  }
  unsigned char *q = x;
  ylm_copy(q, s->data + s->at, bytes);
  s->at += bytes;
  if (s->swap)
    for (size_t i = 0; i < n; i++)
      for (size_t a = i * size, b = a + size - 1; a < b; a++, b--) {
        unsigned char t = q[a];
        q[a] = q[b];
        q[b] = t;
      }
}

static uint32_t number32(stream *s) {
  uint32_t x = 0;
  numbers(s, &x, 1, sizeof x);
  return x;
}

static uint64_t number64(stream *s) {
  uint64_t x = 0;
  numbers(s, &x, 1, sizeof x);
  return x;
}

/* Form, and how many cells and points there are. */
static void header(stream *s, ylm_grid_form *f, uint64_t counts[4]) {
  f->kind = (ylm_grid_kind)number32(s);
  f->lmax = (int)number32(s);
  f->channels = (int)number32(s);
  f->metric_channels = (int)number32(s);
  f->depth = (int)number32(s);
  f->metric = (ylm_grid_metric)number32(s);
  f->continuous = number32(s) != 0;
  numbers(s, f->cells, 3, sizeof *f->cells);
  numbers(s, f->bounds, 6, sizeof *f->bounds);
  numbers(s, &f->threshold, 1, sizeof f->threshold);
  numbers(s, &f->tolerance, 1, sizeof f->tolerance);
  numbers(s, counts, 4, sizeof *counts);
}

/* Numbers of the stats that the grid itself lacks. */
static void history(stream *s, ylm_grid_stats *t) {
  double seconds[3];
  t->pairs = number64(s);
  t->outside = number64(s);
  t->verified = number64(s);
  t->rounds = number64(s);
  numbers(s, seconds, 3, sizeof *seconds); /* of the bake: a loaded grid has none */
  numbers(s, &t->error, 1, sizeof t->error);
  numbers(s, &t->largest_error, 1, sizeof t->largest_error);
  t->met = number32(s) != 0;
  t->limited = number32(s) != 0;
  ylm__grid_file_forget_times(t);
}

static void cells(stream *s, ylm_grid *g) {
  for (size_t i = 0; i < g->cells; i++) {
    ylm_grid_cell *c = &g->cell[i];
    numbers(s, c->origin, 3, sizeof *c->origin);
    numbers(s, &c->child, 1, sizeof c->child);
    numbers(s, c->corner, 8, sizeof *c->corner);
    numbers(s, &c->error, 1, sizeof c->error);
    numbers(s, &c->residual, 1, sizeof c->residual);
    numbers(s, &c->level, 1, 1);
    numbers(s, &c->flags, 1, 1);
    numbers(s, &c->detail, 1, sizeof c->detail);
  }
}

static void points(stream *s, ylm_grid *g) {
  numbers(s, g->lattice, 3 * g->points, sizeof *g->lattice);
  numbers(s, g->lambda, g->points, sizeof *g->lambda);
  numbers(s, g->norm, g->points, sizeof *g->norm);
  numbers(s, g->flags, g->points, 1);
  for (size_t r = 0; r < 4 * g->points; r++)
    numbers(s, g->data + r * g->stride, g->width, sizeof *g->data);
}

#define CELL_BYTES (4 * 14 + 4)
#define POINT_BYTES(width) (4 * 5 + 1 + 16 * (size_t)(width))

/* True if the size and the checksum are those of the file. */
static bool sum_holds(const stream *s) {
  stream tail = *s;
  tail.at = s->size - 8;
  return number64(&tail) == ylm_crc64(0, s->data, s->size - 8);
}

/* True if the counts can be, given what is left of the file. */
static bool counts_hold(const stream *s, const ylm_grid *g, const uint64_t counts[4]) {
  size_t left = s->size - s->at;
  if (counts[0] < 1 || counts[0] > left / CELL_BYTES || counts[1] > counts[0] || !counts[1])
    return false;
  left -= counts[0] * CELL_BYTES;
  if (counts[3] > counts[2] || counts[2] > left / POINT_BYTES(g->width)) return false;
  if (left != counts[2] * POINT_BYTES(g->width)) return false;
  return counts[0] < YLM_GRID_NONE && counts[2] < YLM_GRID_NONE;
}

/* The error in the numbers of a grid that was read, or NULL. */
static const char *check_numbers(const ylm_grid *g) {
  bool metric = g->contents.form.metric_channels != 0;
  for (size_t i = 0; i < g->points; i++)
    if (metric && (isnan(g->lambda[i]) || isnan(g->norm[i]))) return "a point's metric";
  if (!ylm_all_finite(YLM_FLOAT, g->data, 4 * g->points * g->stride, NULL)) return "coefficients";
  return ylm__grid_file_check_points(g);
}

/* Cells and points of a grid whose form and counts are known. */
static ylm_status read_body(stream *s, ylm_grid *g, const uint64_t counts[4], const char *name,
                            ylm_error *e) {
  ylm_status status = ylm__grid_reserve_cells(g, counts[0]);
  if (status == YLM_OK) status = ylm__grid_reserve_points(g, counts[2]);
  if (status != YLM_OK) return ylm_fail(e, status, "%s: the grid does not fit into memory", name);
  ylm_zero(g->cell, counts[0] * sizeof *g->cell);
  ylm_zero(g->data, counts[2] * 4 * g->stride * sizeof *g->data);
  g->cells = counts[0];
  g->contents.octree_cells = counts[1];
  g->points = counts[2];
  g->evaluated = counts[3];
  cells(s, g);
  points(s, g);
  if (s->failed || s->at != s->size) return ylm__grid_file_bad(name, "its length", e);
  const char *what = check_numbers(g);
  if (what) return ylm__grid_file_bad(name, what, e);
  status = ylm__grid_file_check_cells(g, name, e);
  if (status != YLM_OK) return status;
  status = ylm__grid_file_find_births(g);
  if (status == YLM_OK) status = ylm__grid_file_finish(g);
  return status == YLM_OK ? YLM_OK : ylm_fail(e, status, "%s: memory ran out", name);
}

ylm_status ylm__grid_file_read_1(const char *name, const unsigned char *data, size_t size,
                                 bool swapped, ylm_grid **out, ylm_error *e) {
  stream s = {.data = data, .size = size, .at = 24, .swap = swapped}; /* behind the size */
  uint64_t counts[4] = {0};
  ylm_grid_form form = {0};
  ylm_grid_stats stats = {0};
  ylm_error why = {0};
  if (!sum_holds(&s))
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is damaged (checksum)", name);
  s.size -= 8;
  header(&s, &form, counts);
  history(&s, &stats);
  if (s.failed) return ylm__grid_file_bad(name, "its length", e);
  if (ylm__grid_check_form(&form, &why) != YLM_OK) return ylm__grid_file_bad(name, why.text, e);
  ylm_grid *g = ylm__grid_new(&form);
  if (!g) return ylm_no_memory_for(e, name);
  g->stats = stats;
  ylm_status status;
  if (!counts_hold(&s, g, counts))
    status = ylm__grid_file_bad(name, "its counts", e);
  else if (!ylm__grid_file_table_holds(g, counts[0]))
    status = ylm__grid_file_bad(name, "too sparse a lattice", e);
  else
    status = read_body(&s, g, counts, name, e);
  if (status == YLM_OK)
    *out = g;
  else
    ylm_grid_free(g);
  return status;
}
