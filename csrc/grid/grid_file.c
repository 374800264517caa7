/*
** grid_file.c - grids as bytes.
**
** A file is, in the byte order of its writer (docs/grids.md has the table):
**   magic 8 bytes, u32 0x01020304 (tells the byte order), u32 version, u64 size of the file,
**   form, counts, stats; then array after array: cells, points; last a CRC-64/XZ of all before.
** Every length is checked against the size before memory is asked for; everything that sampling
** relies on is checked after the checksum, so that a forged file is refused too.
*/
#include "grid.h"

#include <math.h>
#include <string.h>

#define ORDER 0x01020304u
#define VERSION 1u
#define MAX_LIMIT ((size_t)64 << 30)

/* -- one description for both ways --------------------------------------------------------- */

/* A cursor: writing copies numbers out, reading copies them in; neither leaves the buffer. */
typedef struct stream {
  unsigned char *data; /* NULL: only counts */
  size_t at, size;
  bool reading, swap, failed;
} stream;

/* `n` numbers of `size` bytes at x, in the file's byte order. */
static void numbers(stream *s, void *x, size_t n, size_t size) {
  size_t bytes;
  if (s->failed || __builtin_mul_overflow(n, size, &bytes) || bytes > s->size - s->at) {
    s->failed = true;
    return;
  }
  unsigned char *p = s->data ? s->data + s->at : NULL;
  s->at += bytes;
  if (!p || !bytes) return;
  if (s->reading)
    memcpy(x, p, bytes);
  else
    memcpy(p, x, bytes);
  unsigned char *q = s->reading ? x : p;
  if (s->swap)
    for (size_t i = 0; i < n; i++)
      for (size_t a = i * size, b = a + size - 1; a < b; a++, b--) {
        unsigned char t = q[a];
        q[a] = q[b];
        q[b] = t;
      }
}

static uint32_t number32(stream *s, uint32_t x) {
  numbers(s, &x, 1, sizeof x);
  return x;
}

static uint64_t number64(stream *s, uint64_t x) {
  numbers(s, &x, 1, sizeof x);
  return x;
}

/* Form, and how many cells and points there are. */
static void header(stream *s, ylm_grid_form *f, uint64_t counts[4]) {
  f->kind = (ylm_grid_kind)number32(s, (uint32_t)f->kind);
  f->lmax = (int)number32(s, (uint32_t)f->lmax);
  f->channels = (int)number32(s, (uint32_t)f->channels);
  f->metric_channels = (int)number32(s, (uint32_t)f->metric_channels);
  f->depth = (int)number32(s, (uint32_t)f->depth);
  f->metric = (ylm_grid_metric)number32(s, (uint32_t)f->metric);
  f->continuous = number32(s, f->continuous) != 0;
  numbers(s, f->cells, 3, sizeof *f->cells);
  numbers(s, f->bounds, 6, sizeof *f->bounds);
  numbers(s, &f->threshold, 1, sizeof f->threshold);
  numbers(s, &f->tolerance, 1, sizeof f->tolerance);
  numbers(s, counts, 4, sizeof *counts);
}

/* What the stats say and the grid itself does not. */
static void history(stream *s, ylm_grid_stats *t) {
  t->pairs = number64(s, t->pairs);
  t->outside = number64(s, t->outside);
  t->verified = number64(s, t->verified);
  t->rounds = number64(s, t->rounds);
  numbers(s, &t->seconds, 1, sizeof t->seconds);
  numbers(s, &t->field_seconds, 1, sizeof t->field_seconds);
  numbers(s, &t->verify_seconds, 1, sizeof t->verify_seconds);
  numbers(s, &t->error, 1, sizeof t->error);
  numbers(s, &t->largest_error, 1, sizeof t->largest_error);
  t->met = number32(s, t->met) != 0;
  t->limited = number32(s, t->limited) != 0;
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

/* -- writing ---------------------------------------------------------------------------------- */

static void write_all(stream *s, const ylm_grid *grid, size_t size) {
  ylm_grid g = *grid;
  ylm_grid_form form = g.view.form;
  ylm_grid_stats stats = g.stats;
  char magic[] = YLM_GRID_MAGIC;
  uint64_t counts[4] = {g.cells, g.view.octree_cells, g.points, g.evaluated};
  numbers(s, magic, 8, 1);
  number32(s, ORDER);
  number32(s, VERSION);
  number64(s, size);
  header(s, &form, counts);
  history(s, &stats);
  cells(s, &g);
  points(s, &g);
}

ylm_status ylm_grid_encode(const ylm_grid *g, bool swapped, unsigned char **data, size_t *size,
                           ylm_error *e) {
  stream s = {.size = SIZE_MAX, .swap = swapped};
  write_all(&s, g, 0);
  *size = s.at + 8;
  *data = ylm_alloc(*size, 1);
  if (!*data) return ylm_fail(e, YLM_ENOMEM, "no memory for a file of %zu bytes", *size);
  s = (stream){.data = *data, .size = *size, .swap = swapped};
  write_all(&s, g, *size);
  number64(&s, ylm_crc64(0, *data, s.at));
  return YLM_OK;
}

ylm_status ylm_grid_write(const ylm_grid *g, const char *path, bool swapped, ylm_error *e) {
  unsigned char *data;
  size_t size;
  ylm_status s = ylm_grid_encode(g, swapped, &data, &size, e);
  if (s != YLM_OK) return s;
  s = ylm_file_save(path, data, size, e);
  ylm_free(data);
  return s;
}

/* -- reading ----------------------------------------------------------------------------------- */

static ylm_status bad(const char *name, const char *what, ylm_error *e) {
  return ylm_fail(e, YLM_EFORMAT, "%s: not a valid grid: %s", name, what);
}

/* Magic, byte order, size, checksum, version. */
static ylm_status open_stream(stream *s, const char *name, ylm_error *e) {
  if (s->size < 8 || memcmp(s->data, YLM_GRID_MAGIC, 8) != 0)
    return ylm_fail(e, YLM_EFORMAT, "%s: not a grid file of ylm", name);
  if (s->size < 32) return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is cut off", name);
  s->at = 8;
  uint32_t order = number32(s, 0);
  s->swap = order == __builtin_bswap32(ORDER);
  if (order != ORDER && !s->swap)
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is damaged (byte order)", name);
  uint32_t version = number32(s, 0);
  uint64_t size = number64(s, 0);
  if (size != s->size)
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is damaged: %zu bytes, should be %llu",
                    name, s->size, (unsigned long long)size);
  stream tail = *s;
  tail.at = s->size - 8;
  if (number64(&tail, 0) != ylm_crc64(0, s->data, s->size - 8))
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is damaged (checksum)", name);
  if (version != VERSION)
    return ylm_fail(e, YLM_EVERSION, "%s: grid file of version %u, this is ylm with version %u",
                    name, version, VERSION);
  s->size -= 8;
  return YLM_OK;
}

/* The flags of a cell and its place among the octree's cells, so that descents end. */
static bool links_hold(const ylm_grid *g, size_t i) {
  const ylm_grid_cell *c = &g->cell[i];
  size_t octree = g->view.octree_cells;
  if (c->child && (c->child <= i || c->child > g->cells - 8 || g->cells < 8)) return false;
  if (i >= octree) return c->flags & YLM_GRID_ADDED && !(c->flags & YLM_GRID_LEAF);
  if (c->flags & YLM_GRID_ADDED) return false;
  if (c->flags & YLM_GRID_LEAF) return !c->child || c->child >= octree;
  return c->child && c->child + 8 <= octree;
}

/* Corners are points, and where they should be. */
static bool corners_hold(const ylm_grid *g, const ylm_grid_cell *c) {
  uint32_t edge = ylm__grid_edge(g, c);
  for (int k = 0; k < 8; k++) {
    if (c->corner[k] == YLM_GRID_NONE) continue;
    if (c->corner[k] >= g->points) return false;
    for (int a = 0; a < 3; a++)
      if (g->lattice[3 * (size_t)c->corner[k] + (size_t)a] !=
          c->origin[a] + (k >> a & 1 ? edge : 0))
        return false;
  }
  return true;
}

static bool is_complete(const ylm_grid_cell *c) {
  for (int k = 0; k < 8; k++)
    if (c->corner[k] == YLM_GRID_NONE) return false;
  return true;
}

/* Every cell is the root or the child of one parent, in its place. */
static const char *check_octree(const ylm_grid *g, uint8_t *seen) {
  seen[0] = 1;
  const ylm_grid_cell *root = &g->cell[0];
  if (root->level || root->origin[0] || root->origin[1] || root->origin[2]) return "the root";
  if (!is_complete(root)) return "the root's corners";
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (!seen[i]) return "a cell without parent";
    if (!links_hold(g, i)) return "a cell's children";
    if (!corners_hold(g, c)) return "a cell's corners";
    if (c->detail && (c->detail > g->view.form.depth || c->detail < c->level))
      return "a cell's detail";
    if (!c->child) continue;
    if (c->detail || c->level >= g->view.form.depth) return "a cell's level";
    uint32_t half = ylm__grid_edge(g, c) / 2;
    for (uint32_t k = 0; k < 8; k++) {
      const ylm_grid_cell *d = &g->cell[c->child + k];
      if (seen[c->child + k]++ || d->level != c->level + 1) return "a cell with two parents";
      for (int a = 0; a < 3; a++)
        if (d->origin[a] != c->origin[a] + (k >> a & 1 ? half : 0)) return "a cell's origin";
    }
  }
  return NULL;
}

static const char *check_lattice(const ylm_grid *g) {
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    for (int a = 0; a < 3; a++)
      if (c->origin[a] >= g->view.resolution[a]) return "a voxel's origin";
    if (c->level || c->child || c->detail || !is_complete(c) || !corners_hold(g, c))
      return "a voxel";
    if (c->flags & YLM_GRID_ADDED || !(c->flags & YLM_GRID_LEAF)) return "a voxel's flags";
  }
  return NULL;
}

/* What is wrong with a grid that was read, or NULL. */
static const char *check_grid(const ylm_grid *g) {
  bool metric = g->view.form.metric_channels != 0;
  for (size_t i = 0; i < g->points; i++)
    if (metric && (isnan(g->lambda[i]) || isnan(g->norm[i]))) return "a point's metric";
  if (!ylm_all_finite(YLM_FLOAT, g->data, 4 * g->points * g->stride, NULL)) return "coefficients";
  if (g->view.form.kind == YLM_GRID_UNIFORM) return check_lattice(g);
  uint8_t *seen = ylm_alloc_zero(g->cells, 1);
  const char *what = seen ? check_octree(g, seen) : "too large for this machine's memory";
  ylm_free(seen);
  return what;
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

/* A uniform grid's table must be in proportion to what the file holds. */
static bool table_holds(const ylm_grid *g, uint64_t n) {
  const uint32_t *r = g->view.resolution;
  return g->view.form.kind != YLM_GRID_UNIFORM ||
         (uint64_t)r[0] * r[1] * r[2] <= 4096 * n + (1u << 20);
}

/* The hash of the evaluated points, which voxels without data are sampled with. */
static ylm_status index_points(ylm_grid *g) {
  if (g->view.form.kind == YLM_GRID_UNIFORM || !g->view.form.continuous) return YLM_OK;
  ylm_status s = lattice_hash_reserve(&g->hash, g->evaluated);
  for (size_t i = 0; s == YLM_OK && i < g->evaluated; i++)
    *lattice_hash_at(&g->hash, lattice_key(g->lattice + 3 * i)) = (uint32_t)i;
  return s;
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
  g->view.octree_cells = counts[1];
  g->points = counts[2];
  g->evaluated = counts[3];
  cells(s, g);
  points(s, g);
  if (s->failed || s->at != s->size) return bad(name, "its length", e);
  const char *what = check_grid(g);
  if (what) return bad(name, what, e);
  status = index_points(g);
  if (status == YLM_OK) status = ylm__grid_finish(g);
  return status == YLM_OK ? YLM_OK : ylm_fail(e, status, "%s: memory ran out", name);
}

ylm_status ylm_grid_decode(const unsigned char *data, size_t size, const char *name, ylm_grid **out,
                           ylm_error *e) {
  stream s = {.data = (unsigned char *)(uintptr_t)data, .size = size, .reading = true};
  uint64_t counts[4] = {0};
  ylm_grid_form form = {0};
  ylm_grid_stats stats = {0};
  ylm_error why = {0};
  *out = NULL;
  ylm_status status = open_stream(&s, name, e);
  if (status != YLM_OK) return status;
  header(&s, &form, counts);
  history(&s, &stats);
  if (s.failed) return bad(name, "its length", e);
  if (ylm__grid_check_form(&form, &why) != YLM_OK) return bad(name, why.text, e);
  ylm_grid *g = ylm__grid_new(&form);
  if (!g) return ylm_fail(e, YLM_ENOMEM, "%s: memory ran out", name);
  g->stats = stats;
  if (!counts_hold(&s, g, counts))
    status = bad(name, "its counts", e);
  else if (!table_holds(g, counts[0]))
    status = bad(name, "too sparse a lattice", e);
  else
    status = read_body(&s, g, counts, name, e);
  if (status != YLM_OK) {
    ylm_grid_free(g);
    return status;
  }
  *out = g;
  return YLM_OK;
}

ylm_status ylm_grid_read(const char *path, ylm_grid **g, ylm_error *e) {
  unsigned char *data;
  size_t size;
  *g = NULL;
  ylm_status s = ylm_file_read(path, MAX_LIMIT, &data, &size, e);
  if (s != YLM_OK) return s;
  s = ylm_grid_decode(data, size, path, g, e);
  ylm_free(data);
  return s;
}
