/* copy.c - a grid's cells, coefficients and gradients in the device's memory. */
#include <string.h>

#include "copy.h"

/* shaders/grid.glsl */
typedef struct gpu_cell {
  uint32_t corner[8], origin[3], edge, child, source, info, unused;
} gpu_cell;

static void fill_cell(const ylm_grid_contents *v, size_t i, gpu_cell *out) {
  const ylm_grid_cell *c = &v->cell[i];
  for (int k = 0; k < 8; k++) out->corner[k] = c->corner[k] == YLM_GRID_NONE ? 0 : c->corner[k];
  memcpy(out->origin, c->origin, sizeof out->origin);
  out->edge = v->form.kind == YLM_GRID_UNIFORM ? 1 : 1u << (v->form.depth - c->level);
  out->child = c->child;
  out->source = c->source;
  out->info = c->level | (c->flags & (YLM_GRID_BAKED | YLM_GRID_ADDED) ? YLM_GPU_HAS_DATA : 0) |
              (c->detail ? YLM_GPU_ELSEWHERE : 0);
  out->unused = 0;
}

static ylm_status copy_cells(ylm_gpu_grid *k, const ylm_grid_contents *v, ylm_error *e) {
  gpu_cell *cell = ylm_alloc(v->cells, sizeof *cell);
  if (!cell) return ylm_no_memory(e);
  for (size_t i = 0; i < v->cells; i++) fill_cell(v, i, &cell[i]);
  ylm_status s = ylm_gpu_buffer_from(k->g, v->cells * sizeof *cell, cell, &k->cells, e);
  ylm_free(cell);
  return s;
}

/* Uniform grids: the cell at each lattice place. */
static ylm_status copy_table(ylm_gpu_grid *k, const ylm_grid_contents *v, ylm_error *e) {
  const uint32_t *r = v->resolution;
  if (v->form.kind != YLM_GRID_UNIFORM) return ylm_gpu_buffer_create(k->g, 0, &k->table, e);
  size_t n = (size_t)r[0] * r[1] * r[2];
  uint32_t *table = ylm_alloc(n, sizeof *table);
  if (!table) return ylm_no_memory(e);
  for (size_t i = 0; i < n; i++) table[i] = YLM_GPU_NONE;
  for (size_t i = 0; i < v->cells; i++) {
    const uint32_t *o = v->cell[i].origin;
    table[((size_t)o[2] * r[1] + o[1]) * r[0] + o[0]] = (uint32_t)i;
  }
  ylm_status s = ylm_gpu_buffer_from(k->g, n * sizeof *table, table, &k->table, e);
  ylm_free(table);
  return s;
}

static ylm_status copy_bounds(ylm_gpu_grid *k, const ylm_grid_contents *v, ylm_error *e) {
  double b[9];
  float f[9];
  for (int a = 0; a < 3; a++) {
    b[a] = v->form.bounds[a];
    b[3 + a] = v->form.bounds[3 + a];
    b[6 + a] = v->resolution[a] / (b[3 + a] - b[a]);
  }
  for (int i = 0; i < 9; i++) f[i] = (float)b[i];
  return k->wide ? ylm_gpu_buffer_from(k->g, sizeof b, b, &k->bounds, e)
                 : ylm_gpu_buffer_from(k->g, sizeof f, f, &k->bounds, e);
}

/* Numbers of a point's row. */
static size_t row_of(const ylm_gpu_grid *k) { return k->packed ? k->stride : 4 * k->stride; }

/* As few parts as there can be. */
static ylm_status copy_rows(ylm_gpu_grid *k, size_t n, const void *data, ylm_error *e) {
  size_t row = row_of(k);
  ylm_status s = YLM_OK;
  for (size_t at = 0; s == YLM_OK && (at < n || !k->parts); at += k->part_rows) {
    size_t rows = n - at < k->part_rows ? n - at : k->part_rows;
    s = ylm_gpu_buffer_from(k->g, rows * row * sizeof(float), (const float *)data + at * row,
                            &k->data[k->parts++], e);
  }
  return s;
}

static ylm_status copy_data(ylm_gpu_grid *k, const ylm_grid *grid, ylm_error *e) {
  const ylm_grid_contents *v = ylm_grid_look(grid);
  if (!k->packed) return copy_rows(k, v->points, v->data, e);
  uint32_t *word = ylm_alloc(v->points * k->stride + 1, sizeof *word);
  if (!word) return ylm_no_memory(e);
  ylm_status s = ylm_grid_pack(grid, 0, word, &k->packing, e);
  if (s == YLM_OK) s = copy_rows(k, v->points, word, e);
  ylm_free(word);
  return s;
}

ylm_status ylm__gpu_grid_begin(ylm_gpu *g, const ylm_grid *grid, bool packed, ylm_gpu_grid **out,
                               ylm_error *e) {
  const ylm_grid_contents *v = ylm_grid_look(grid);
  *out = NULL;
  if (v->form.sides)
    return ylm_fail(e, YLM_EINVAL, "device: it knows no sides of walls, which this grid has");
  ylm_status s = ylm_gpu_state(g, e);
  if (s != YLM_OK) return s;
  size_t width = (size_t)v->form.channels * (size_t)v->count;
  uint64_t most = ylm_gpu_about(g)->bind_bytes;
  uint64_t row = (packed ? width + 2 : 4 * v->stride) * sizeof(float);
  uint64_t rows = most / row, bytes = (uint64_t)v->points * row;
  if (v->cells >= YLM_GPU_NONE || v->cells > most / sizeof(gpu_cell) ||
      (v->points && (v->points - 1) / GRID_PARTS >= rows))
    return ylm_fail(e, YLM_ELIMIT,
                    "the grid has %.0f MiB of data and %.0f of cells, kernels of '%s' see %.0f and "
                    "%.0f",
                    (double)bytes / 1048576, (double)v->cells * sizeof(gpu_cell) / 1048576,
                    ylm_gpu_about(g)->name, (double)(GRID_PARTS * most) / 1048576,
                    (double)most / 1048576);
  ylm_gpu_grid *k = ylm_alloc_zero(1, sizeof *k);
  if (!k) return ylm_no_memory(e);
  k->g = ylm_gpu_share(g);
  k->form = v->form;
  k->updates = v->stats->update.updates;
  memcpy(k->resolution, v->resolution, sizeof k->resolution);
  k->width = width;
  k->stride = packed ? width + 2 : v->stride;
  k->packed = packed;
  k->cell_count = v->cells;
  k->part_rows = (size_t)rows;
  k->wide = ylm_gpu_about(g)->float64;
  s = copy_cells(k, v, e);
  if (s == YLM_OK) s = copy_table(k, v, e);
  if (s == YLM_OK) s = copy_bounds(k, v, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(g, 12, &k->counts, e);
  if (s == YLM_OK)
    *out = k;
  else
    ylm_gpu_grid_free(k);
  return s;
}

ylm_status ylm_gpu_grid_create(ylm_gpu *g, const ylm_grid *grid, bool packed, ylm_gpu_grid **out,
                               ylm_error *e) {
  ylm_status s = ylm__gpu_grid_begin(g, grid, packed, out, e);
  if (s != YLM_OK) return s;
  s = copy_data(*out, grid, e);
  if (s == YLM_OK) return s;
  ylm_gpu_grid_free(*out);
  *out = NULL;
  return s;
}

void ylm_gpu_grid_free(ylm_gpu_grid *k) {
  if (!k) return;
  ylm_gpu_buffer *all[] = {k->cells, k->table, k->bounds, k->counts,   k->points,   k->places,
                           k->order, k->tally, k->value,  k->gradient, k->transfer, k->material};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) ylm_gpu_buffer_free(all[i]);
  for (int i = 0; i < GRID_PARTS; i++) ylm_gpu_buffer_free(k->data[i]);
  ylm__steps_free(&k->queue);
  ylm_gpu_free(k->g);
  ylm_free(k);
}

bool ylm_gpu_grid_current(const ylm_gpu_grid *k, const ylm_grid *grid) {
  return ylm_grid_look(grid)->stats->update.updates == k->updates;
}

ylm_gpu *ylm_gpu_grid_device(const ylm_gpu_grid *k) { return k->g; }

uint64_t ylm_gpu_grid_bytes(const ylm_gpu_grid *k) {
  uint64_t bytes = ylm_gpu_buffer_bytes(k->cells) + ylm_gpu_buffer_bytes(k->table);
  for (int i = 0; i < k->parts; i++) bytes += ylm_gpu_buffer_bytes(k->data[i]);
  return bytes;
}

bool ylm_gpu_grid_packed(const ylm_gpu_grid *k, ylm_grid_packing *report) {
  if (report) *report = k->packing;
  return k->packed;
}
