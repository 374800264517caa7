/*
** grid.c - a grid in the device's memory, and sampling there.
**
** Points in leaves without data that evaluated points touch, and in voxels of a uniform grid that
** have none, are left to the host: they are where nobody was meant to look, and few.
*/
#include "ylm_grid.h"
#include "ylm_vulkan.h"

#include <string.h>

enum { GROUP = 64, POINTS = 8 }; /* points of a group of grid_sample.comp */
#define PASS_BYTES ((uint64_t)64 << 20)

/* shaders/grid.glsl */
typedef struct gpu_cell {
  uint32_t corner[8], origin[3], edge, child, source, info, unused;
} gpu_cell;
enum { HAS_DATA = 0x100, ELSEWHERE = 0x200 };
#define NONE 0x3fffffffu

struct ylm_gpu_grid {
  ylm_gpu *g;
  ylm_grid_form form;
  uint64_t updates; /* of the grid, when it was copied */
  uint32_t resolution[3];
  size_t width, stride;
  bool wide; /* points are located in double */
  ylm_gpu_buffer *cells, *table, *data, *bounds, *counts;
  /* Of a pass, kept for the next. */
  size_t rows;
  bool busy; /* a call has not returned: its progress function runs */
  ylm_gpu_buffer *points, *places, *value, *gradient, *transfer;
};

/* -- copying ------------------------------------------------------------------------ */

static void fill_cell(const ylm_grid_view *v, size_t i, gpu_cell *out) {
  const ylm_grid_cell *c = &v->cell[i];
  for (int k = 0; k < 8; k++) out->corner[k] = c->corner[k] == YLM_GRID_NONE ? 0 : c->corner[k];
  memcpy(out->origin, c->origin, sizeof out->origin);
  out->edge = v->form.kind == YLM_GRID_UNIFORM ? 1 : 1u << (v->form.depth - c->level);
  out->child = c->child;
  out->source = c->source;
  out->info = c->level | (c->flags & (YLM_GRID_BAKED | YLM_GRID_ADDED) ? HAS_DATA : 0) |
              (c->detail ? ELSEWHERE : 0);
  out->unused = 0;
}

static ylm_status copy_cells(ylm_gpu_grid *k, const ylm_grid_view *v, ylm_error *e) {
  gpu_cell *cell = ylm_alloc(v->cells, sizeof *cell);
  if (!cell) return ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  for (size_t i = 0; i < v->cells; i++) fill_cell(v, i, &cell[i]);
  ylm_status s = ylm_gpu_buffer_from(k->g, v->cells * sizeof *cell, cell, &k->cells, e);
  ylm_free(cell);
  return s;
}

/* Uniform grids: the cell at each lattice place. */
static ylm_status copy_table(ylm_gpu_grid *k, const ylm_grid_view *v, ylm_error *e) {
  const uint32_t *r = v->resolution;
  if (v->form.kind != YLM_GRID_UNIFORM) return ylm_gpu_buffer_create(k->g, 0, &k->table, e);
  size_t n = (size_t)r[0] * r[1] * r[2];
  uint32_t *table = ylm_alloc(n, sizeof *table);
  if (!table) return ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  for (size_t i = 0; i < n; i++) table[i] = NONE;
  for (size_t i = 0; i < v->cells; i++) {
    const uint32_t *o = v->cell[i].origin;
    table[((size_t)o[2] * r[1] + o[1]) * r[0] + o[0]] = (uint32_t)i;
  }
  ylm_status s = ylm_gpu_buffer_from(k->g, n * sizeof *table, table, &k->table, e);
  ylm_free(table);
  return s;
}

static ylm_status copy_bounds(ylm_gpu_grid *k, const ylm_grid_view *v, ylm_error *e) {
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

ylm_status ylm_gpu_grid_create(ylm_gpu *g, const ylm_grid *grid, ylm_gpu_grid **out, ylm_error *e) {
  const ylm_grid_view *v = ylm_grid_look(grid);
  *out = NULL;
  ylm_status s = ylm_gpu_state(g, e);
  if (s != YLM_OK) return s;
  uint64_t bytes = (uint64_t)v->points * 4 * v->stride * sizeof(float);
  if (bytes > ylm_gpu_about(g)->bind_bytes || v->cells >= NONE)
    return ylm_fail(e, YLM_ELIMIT, "the grid has %.0f MiB of data, a kernel of '%s' sees %.0f",
                    (double)bytes / 1048576, ylm_gpu_about(g)->name,
                    (double)ylm_gpu_about(g)->bind_bytes / 1048576);
  ylm_gpu_grid *k = ylm_alloc_zero(1, sizeof *k);
  if (!k) return ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  k->g = ylm_gpu_share(g);
  k->form = v->form;
  k->updates = v->stats->update.updates;
  memcpy(k->resolution, v->resolution, sizeof k->resolution);
  k->width = (size_t)v->form.channels * (size_t)v->count;
  k->stride = v->stride;
  k->wide = ylm_gpu_about(g)->float64;
  s = copy_cells(k, v, e);
  if (s == YLM_OK) s = copy_table(k, v, e);
  if (s == YLM_OK) s = copy_bounds(k, v, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(g, bytes, v->data, &k->data, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(g, 12, &k->counts, e);
  if (s != YLM_OK) {
    ylm_gpu_grid_free(k);
    return s;
  }
  *out = k;
  return YLM_OK;
}

static void free_pass(ylm_gpu_grid *k) {
  ylm_gpu_buffer **of_pass[] = {&k->points, &k->places, &k->value, &k->gradient, &k->transfer};
  for (int i = 0; i < 5; i++) {
    ylm_gpu_buffer_free(*of_pass[i]);
    *of_pass[i] = NULL;
  }
  k->rows = 0;
}

void ylm_gpu_grid_free(ylm_gpu_grid *k) {
  if (!k) return;
  free_pass(k);
  ylm_gpu_buffer_free(k->cells);
  ylm_gpu_buffer_free(k->table);
  ylm_gpu_buffer_free(k->data);
  ylm_gpu_buffer_free(k->bounds);
  ylm_gpu_buffer_free(k->counts);
  ylm_gpu_free(k->g);
  ylm_free(k);
}

ylm_gpu *ylm_gpu_grid_device(const ylm_gpu_grid *k) { return k->g; }

uint64_t ylm_gpu_grid_bytes(const ylm_gpu_grid *k) {
  return ylm_gpu_buffer_bytes(k->cells) + ylm_gpu_buffer_bytes(k->table) +
         ylm_gpu_buffer_bytes(k->data);
}

/* -- sampling ------------------------------------------------------------------------- */

typedef struct sampling {
  ylm_gpu_grid *k;
  const ylm_grid *grid;
  const ylm_grid_query *q;
  const char *points;
  float *value, *gradient;
  const float *transfer; /* [n][row]: value is then radiance [n][3] */
  size_t row;
  void *scratch; /* points of a pass in the type they are located in, places */
  ylm_gpu_times *times;
  ylm_grid_report *report;
} sampling;

/* Buffers for passes of up to `rows` points. */
static ylm_status reserve(const sampling *m, size_t rows, ylm_error *e) {
  ylm_gpu_grid *k = m->k;
  bool gradient = m->gradient != NULL;
  size_t value = (k->width > 3 ? k->width : 3) * sizeof(float),
         transfer = rows * m->row * sizeof(float);
  bool seen = !m->transfer || (k->transfer && ylm_gpu_buffer_bytes(k->transfer) >= transfer);
  if (rows <= k->rows && (k->gradient || !gradient) && seen) return YLM_OK;
  free_pass(k);
  ylm_status s = ylm_gpu_buffer_create(k->g, rows * (k->wide ? 24 : 12), &k->points, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(k->g, rows * 16, &k->places, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(k->g, rows * value, &k->value, e);
  if (s == YLM_OK && gradient) s = ylm_gpu_buffer_create(k->g, rows * 3 * value, &k->gradient, e);
  if (s == YLM_OK && m->transfer) s = ylm_gpu_buffer_create(k->g, transfer, &k->transfer, e);
  if (s == YLM_OK) k->rows = rows;
  return s;
}

static ylm_status upload_points(const sampling *m, size_t at, size_t n, ylm_error *e) {
  ylm_dtype from = m->q->point_dtype, to = m->k->wide ? YLM_DOUBLE : YLM_FLOAT;
  size_t size = 3 * ylm_dtype_size(to);
  const void *points = m->points + at * 3 * ylm_dtype_size(from);
  if (from == to) return ylm_gpu_upload(m->k->points, 0, n * size, points, e);
  for (size_t i = 0; i < 3 * n; i++) {
    if (to == YLM_DOUBLE)
      ((double *)m->scratch)[i] = (double)((const float *)points)[i];
    else
      ((float *)m->scratch)[i] = (float)((const double *)points)[i];
  }
  return ylm_gpu_upload(m->k->points, 0, n * size, m->scratch, e);
}

/* Coefficients of a channel that both the grid and the transfer vectors have. */
static size_t common(const sampling *m) {
  size_t given = m->k->width / (size_t)m->k->form.channels;
  return m->row < given ? m->row : given;
}

static ylm_status dispatch(const sampling *m, size_t n, ylm_error *e) {
  ylm_gpu_grid *k = m->k;
  const ylm_grid_view *v = ylm_grid_look(m->grid);
  struct {
    uint32_t n, depth, uniform, resolution[3];
  } where = {(uint32_t)n, (uint32_t)k->form.depth, k->form.kind == YLM_GRID_UNIFORM, {0}};
  struct {
    uint32_t n, width, stride, nan_outside;
    float unit[3];
  } what = {(uint32_t)n, (uint32_t)k->width, (uint32_t)k->stride, m->q->nan_outside, {0}};
  for (int a = 0; a < 3; a++) {
    where.resolution[a] = k->resolution[a];
    what.unit[a] = (float)((v->form.bounds[3 + a] - v->form.bounds[a]) / k->resolution[a]);
  }
  struct {
    uint32_t n, stride, given, row, count;
    float unit[3];
  } shade = {(uint32_t)n,      (uint32_t)k->stride, (uint32_t)(k->width / (size_t)k->form.channels),
             (uint32_t)m->row, (uint32_t)common(m), {what.unit[0], what.unit[1], what.unit[2]}};
  ylm_gpu_work w[] = {
      {.verb = YLM_GPU_FILL, .stage = "locate", .binds = 1, .bind = {{.buffer = k->counts}}},
      {.verb = YLM_GPU_DISPATCH,
       .stage = "locate",
       .groups = (n + GROUP - 1) / GROUP,
       .push = &where,
       .push_bytes = sizeof where,
       .binds = 6,
       .bind = {{.buffer = k->cells},
                {.buffer = k->table},
                {.buffer = k->bounds},
                {.buffer = k->points},
                {.buffer = k->places},
                {.buffer = k->counts}}},
      {.verb = YLM_GPU_DISPATCH,
       .stage = "sample",
       .groups = (n + POINTS - 1) / POINTS,
       .cost = (double)k->width,
       .push = &what,
       .push_bytes = sizeof what,
       .binds = 5,
       .bind = {{.buffer = k->cells},
                {.buffer = k->data},
                {.buffer = k->places},
                {.buffer = k->value},
                {.buffer = m->gradient ? k->gradient : k->counts}}}};
  uint32_t constant[] = {GROUP, (uint32_t)m->q->interpolation, m->gradient != NULL};
  if (m->transfer) {
    w[2].stage = "shade";
    w[2].push = &shade;
    w[2].push_bytes = sizeof shade;
    w[2].bind[3].buffer = k->transfer;
    w[2].bind[4].buffer = k->value;
    constant[2] = (uint32_t)k->form.channels;
  }
  ylm_status s = ylm_gpu_kernel_get(k->g, k->wide ? "grid_locate_double" : "grid_locate_float", 1,
                                    constant, &w[1].kernel, e);
  if (s == YLM_OK)
    s = ylm_gpu_kernel_get(k->g, m->transfer ? "grid_shade" : "grid_sample", 3, constant,
                           &w[2].kernel, e);
  return s == YLM_OK ? ylm_gpu_run(k->g, 3, w, m->times, NULL, e) : s;
}

/* Radiance of points that the host has sampled. */
static ylm_status shade_host(const sampling *m, size_t at, size_t n, const ylm_grid_query *q,
                             ylm_grid_report *r, ylm_error *e) {
  size_t w = m->k->width, channels = (size_t)m->k->form.channels, given = w / channels;
  float *L = ylm_alloc(n * w, sizeof *L);
  if (!L) return ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  const void *points = m->points + at * 3 * ylm_dtype_size(q->point_dtype);
  ylm_status s = ylm_grid_sample(m->grid, q, n, points, L, NULL, r, e);
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    for (size_t c = 0; c < 3; c++) {
      const float *T = m->transfer + (at + i) * m->row;
      const float *x = L + i * w + (channels == 3 ? c * given : 0);
      float sum = 0;
      for (size_t j = 0; j < common(m); j++) sum += T[j] * x[j];
      m->value[3 * (at + i) + c] = sum;
    }
  ylm_free(L);
  return s;
}

/* Samples on the host what the device left. */
static ylm_status patch(const sampling *m, size_t at, size_t n, ylm_error *e) {
  ylm_grid_query q = *m->q;
  uint32_t(*place)[4] = m->scratch;
  size_t size = 3 * ylm_dtype_size(q.point_dtype), w = m->k->width;
  ylm_grid_report r;
  q.dtype = YLM_FLOAT;
  q.progress = NULL;
  ylm_status s = ylm_gpu_download(m->k->places, 0, n * sizeof *place, place, e);
  for (size_t i = 0, end; s == YLM_OK && i < n; i = end) {
    end = i + 1;
    if (place[i][0] != NONE) continue;
    while (end < n && place[end][0] == NONE) end++;
    if (m->transfer)
      s = shade_host(m, at + i, end - i, &q, &r, e);
    else
      s = ylm_grid_sample(m->grid, &q, end - i, m->points + (at + i) * size,
                          m->value + (at + i) * w,
                          m->gradient ? m->gradient + (at + i) * 3 * w : NULL, &r, e);
    if (s != YLM_OK) break;
    m->report->outside += r.outside;
    m->report->unbaked += r.unbaked;
  }
  return s;
}

static ylm_status pass(const sampling *m, size_t at, size_t n, ylm_error *e) {
  size_t w = m->transfer ? 3 : m->k->width;
  uint32_t counts[3];
  ylm_status s = upload_points(m, at, n, e);
  if (s == YLM_OK && m->transfer)
    s = ylm_gpu_upload(m->k->transfer, 0, n * m->row * 4, m->transfer + at * m->row, e);
  if (s == YLM_OK) s = dispatch(m, n, e);
  if (s == YLM_OK) s = ylm_gpu_download(m->k->counts, 0, sizeof counts, counts, e);
  if (s == YLM_OK) s = ylm_gpu_download(m->k->value, 0, n * w * 4, m->value + at * w, e);
  if (s == YLM_OK && m->gradient)
    s = ylm_gpu_download(m->k->gradient, 0, n * w * 12, m->gradient + at * 3 * w, e);
  if (s != YLM_OK) return s;
  m->report->outside += counts[0];
  m->report->unbaked += counts[1];
  return counts[2] ? patch(m, at, n, e) : YLM_OK;
}

/* All passes over n points. */
static ylm_status passes(sampling *m, size_t n, ylm_grid_report *report, ylm_error *e) {
  double start = ylm_seconds();
  ylm_gpu_grid *k = m->k;
  size_t wide = k->width * (m->gradient ? 3 : 1), rows = n;
  size_t row = (wide > m->row ? wide : m->row) * sizeof(float);
  const ylm_grid *grid = m->grid;
  ylm_grid_report r = {0};
  m->report = &r;
  ylm_status s = ylm_gpu_state(k->g, e);
  if (s == YLM_OK && k->busy)
    s = ylm_fail(e, YLM_EBUSY, "the grid's copy is in use by a call that has not returned");
  if (s == YLM_OK && ylm_grid_look(grid)->stats->update.updates != k->updates)
    s = ylm_fail(e, YLM_EINVAL,
                 "the grid was updated since it was copied to the device: copy it again");
  if (s != YLM_OK) return s;
  if (rows > PASS_BYTES / row) rows = PASS_BYTES / row;
  if (rows > ylm_gpu_about(k->g)->bind_bytes / row) rows = ylm_gpu_about(k->g)->bind_bytes / row;
  if (rows < 1) rows = 1;
  m->scratch = ylm_alloc(rows, 24);
  s = m->scratch ? reserve(m, rows, e) : ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  k->busy = true;
  for (size_t at = 0, now; s == YLM_OK && at < n; at += now) {
    now = n - at < rows ? n - at : rows;
    s = pass(m, at, now, e);
    if (s == YLM_OK)
      s = ylm_report(m->q->progress, at + now, n, m->transfer ? "shading" : "sampling");
  }
  k->busy = false;
  ylm_free(m->scratch);
  r.seconds = ylm_seconds() - start;
  if (report) *report = r;
  return s;
}

ylm_status ylm_gpu_grid_sample(ylm_gpu_grid *k, const ylm_grid *grid, const ylm_grid_query *q,
                               size_t n, const void *points, float *value, float *gradient,
                               ylm_grid_report *report, ylm_gpu_times *times, ylm_error *e) {
  sampling m = {.k = k,
                .grid = grid,
                .q = q,
                .points = points,
                .value = value,
                .gradient = gradient,
                .times = times};
  return passes(&m, n, report, e);
}

ylm_status ylm_gpu_grid_shade(ylm_gpu_grid *k, const ylm_grid *grid, const ylm_grid_query *q,
                              size_t n, const float *points, size_t row, const float *transfer,
                              float *radiance, ylm_grid_report *report, ylm_gpu_times *times,
                              ylm_error *e) {
  sampling m = {.k = k,
                .grid = grid,
                .q = q,
                .points = (const char *)points,
                .value = radiance,
                .transfer = transfer,
                .row = row,
                .times = times};
  return passes(&m, n, report, e);
}
