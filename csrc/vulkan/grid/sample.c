/*
** sample.c - sampling and shading with a grid in the device's memory.
**
** Points are sorted by the cell whose corners they need, by counting: located and counted, the
** counts summed, scattered. Groups of neighbours in that order then read a cell's data once.
** Points in leaves without data that evaluated points touch, and in voxels of a uniform grid that
** have none, are left to the host: they are few, and far from shading points.
*/
#include <string.h>

#include "../calibration.h"
#include "copy.h"
#include "ylm_material.h"

enum { CHUNK = 64 }; /* points of a group of grid_sample.comp, grid_shade.comp */
#define ROW (YLM_MATERIAL_ROW * sizeof(float))

typedef struct sampling {
  ylm_gpu_grid *k;
  const ylm_grid *grid;
  const ylm_grid_query *q;
  ylm_gpu_input points, transfer, material; /* transfer: [n][row]; value is then radiance [n][3] */
  ylm_gpu_output value, gradient;
  bool shade;
  size_t row;
  void *scratch; /* places and points of a pass */
  ylm_gpu_times *times;
  ylm_grid_report *report;
} sampling;

/* -- arrays of a pass ------------------------------------------------------------------- */

static size_t point_bytes(const sampling *m) { return 3 * ylm_dtype_size(m->q->point_dtype); }

/* Are the caller's doubles rounded before they go to a device without doubles? */
static bool narrows(const sampling *m) {
  return !m->k->wide && m->q->point_dtype == YLM_DOUBLE && !m->points.there;
}

/* Numbers of a result at each point. */
static size_t width_of(const sampling *m) { return m->shade ? 3 : m->k->width; }

/* Copies rows at .. at+n-1 of an array of the host's to a buffer; others are used where they
   are. */
static ylm_status bring(const sampling *m, const ylm_gpu_input *in, size_t at, size_t n,
                        size_t bytes, ylm_gpu_buffer **room, ylm_error *e) {
  if (!in->host) return YLM_OK;
  double start = ylm_seconds();
  ylm_status s = ylm__steps_reserve(m->k->g, room, n * bytes, e);
  if (s == YLM_OK) s = ylm_gpu_upload(*room, 0, n * bytes, (const char *)in->host + at * bytes, e);
  ylm__steps_copied(m->times, "upload", start);
  return s;
}

static ylm_status bring_points(const sampling *m, size_t at, size_t n, ylm_error *e) {
  if (!narrows(m)) return bring(m, &m->points, at, n, point_bytes(m), &m->k->points, e);
  const double *from = (const double *)m->points.host + 3 * at;
  float *to = m->scratch;
  for (size_t i = 0; i < 3 * n; i++) to[i] = (float)from[i];
  ylm_gpu_input rounded = {.host = to};
  return bring(m, &rounded, 0, n, 12, &m->k->points, e);
}

static ylm_status fetch(const sampling *m, const ylm_gpu_output *out, size_t at, size_t n,
                        size_t bytes, const ylm_gpu_buffer *from, ylm_error *e) {
  if (!out->host) return YLM_OK;
  double start = ylm_seconds();
  ylm_status s = ylm_gpu_download(from, 0, n * bytes, (char *)out->host + at * bytes, e);
  ylm__steps_copied(m->times, "download", start);
  return s;
}

/* Rows at .. at+n-1 of the caller's buffer, or of the pass's own. */
static ylm_gpu_bind rows_of(ylm_gpu_buffer *theirs, ylm_gpu_buffer *own, size_t at, size_t n,
                            size_t bytes) {
  return theirs ? (ylm_gpu_bind){theirs, at * bytes, n * bytes} : (ylm_gpu_bind){own, 0, 0};
}

/* Room for a pass of n points. */
static ylm_status reserve(const sampling *m, size_t n, bool sorted, ylm_error *e) {
  ylm_gpu_grid *k = m->k;
  size_t value = width_of(m) * sizeof(float);
  ylm_status s = ylm__steps_reserve(k->g, &k->places, n * 16, e);
  if (s == YLM_OK && sorted) s = ylm__steps_reserve(k->g, &k->order, n * 4, e);
  if (s == YLM_OK && sorted) s = ylm__steps_reserve(k->g, &k->tally, (k->cell_count + 1) * 4, e);
  if (s == YLM_OK && m->value.host) s = ylm__steps_reserve(k->g, &k->value, n * value, e);
  if (s == YLM_OK && m->gradient.host) s = ylm__steps_reserve(k->g, &k->gradient, 3 * n * value, e);
  return s;
}

/* -- kernels ------------------------------------------------------------------------------ */

/* Coefficients of a channel that both the grid and the transfer vectors have. */
static size_t common(const sampling *m) {
  size_t given = m->k->width / (size_t)m->k->form.channels;
  return m->row < given ? m->row : given;
}

/* A kernel with its constants behind the group's size, for n points in groups of CHUNK. */
static ylm_gpu_work work_of(const sampling *m, const char *name, int constants,
                            const uint32_t *constant, size_t n, ylm_status *s, ylm_error *e) {
  ylm_gpu_work w = {.verb = YLM_GPU_DISPATCH, .groups = (n + CHUNK - 1) / CHUNK};
  if (*s == YLM_OK) *s = ylm_gpu_kernel_get(m->k->g, name, constants, constant, &w.kernel, e);
  return w;
}

static void locate(const sampling *m, size_t at, size_t n, bool sorted, ylm_error *e) {
  ylm_gpu_grid *k = m->k;
  step_queue *q = &k->queue;
  bool doubles = m->q->point_dtype == YLM_DOUBLE && !narrows(m);
  uint32_t constant[] = {CHUNK, doubles, sorted};
  uint32_t push[] = {
      (uint32_t)n,      (uint32_t)k->form.depth, k->form.kind == YLM_GRID_UNIFORM, k->resolution[0],
      k->resolution[1], k->resolution[2],        (uint32_t)k->cell_count};
  q->stage = "locate";
  ylm__steps_fill(q, k->counts, 0);
  if (sorted) ylm__steps_fill(q, k->tally, 0);
  ylm_gpu_work w = work_of(m, k->wide ? "grid_locate_double" : "grid_locate_float", 3, constant, n,
                           &q->status, e);
  w.push = push;
  w.push_bytes = sizeof push;
  w.binds = 7;
  w.bind[0].buffer = k->cells;
  w.bind[1].buffer = k->table;
  w.bind[2].buffer = k->bounds;
  w.bind[3] = rows_of(m->points.there, k->points, at, n, point_bytes(m));
  w.bind[4].buffer = k->places;
  w.bind[5].buffer = k->counts;
  w.bind[6].buffer = sorted ? k->tally : k->counts;
  ylm__steps_work(q, &w);
  if (!sorted) return;
  uint32_t groups[] = {CHUNK}, items[] = {(uint32_t)n, (uint32_t)k->cell_count};
  q->stage = "sort";
  ylm__steps_scan(q, SCAN_PLAIN, 0, k->tally, (uint32_t)k->cell_count + 1, k->tally, k->counts,
                  SCAN_NO_SUM);
  w = work_of(m, "grid_order", 1, groups, n, &q->status, e);
  w.push = items;
  w.push_bytes = sizeof items;
  w.binds = 3;
  w.bind[0].buffer = k->places;
  w.bind[1].buffer = k->tally;
  w.bind[2].buffer = k->order;
  ylm__steps_work(q, &w);
}

/* The push constants of shaders/grid_data.glsl. */
static void bind_data(const sampling *m, ylm_gpu_work *w, bool sorted) {
  ylm_gpu_grid *k = m->k;
  for (int i = 0; i < GRID_PARTS; i++) w->bind[i].buffer = k->data[i < k->parts ? i : 0];
  w->bind[4].buffer = k->cells;
  w->bind[5].buffer = k->places;
  w->bind[6].buffer = sorted ? k->order : k->counts;
  w->cost = (double)k->width;
}

#define STRIPS 256u /* grid_data.glsl: reversed bits are a byte */

/* The groups of a strip, where points are sorted: chunk() of grid_data.glsl; `groups` then makes
   whole strips. */
static uint32_t spread(ylm_gpu_work *w, bool sorted) {
  if (!sorted || w->groups < STRIPS) return 0;
  uint32_t each = (uint32_t)((w->groups + STRIPS - 1) / STRIPS);
  w->groups = (uint64_t)each * STRIPS;
  return each;
}

static void unit_of(const sampling *m, float unit[3]) {
  const double *b = m->k->form.bounds;
  for (int a = 0; a < 3; a++) unit[a] = (float)((b[3 + a] - b[a]) / m->k->resolution[a]);
}

static void sample(const sampling *m, size_t at, size_t n, bool sorted, ylm_error *e) {
  ylm_gpu_grid *k = m->k;
  bool gradient = m->gradient.host || m->gradient.there;
  uint32_t constant[] = {
      CHUNK, (uint32_t)m->q->interpolation, gradient, sorted, (uint32_t)k->parts, 0, k->packed};
  struct {
    uint32_t n, spread, stride, part_rows, width, nan_outside;
    float unit[3];
  } push = {(uint32_t)n,       0,  (uint32_t)k->stride, (uint32_t)k->part_rows, (uint32_t)k->width,
            m->q->nan_outside, {0}};
  size_t value = k->width * sizeof(float);
  unit_of(m, push.unit);
  ylm_gpu_work w = work_of(m, "grid_sample", 7, constant, n, &k->queue.status, e);
  push.spread = spread(&w, sorted);
  w.push = &push;
  w.push_bytes = sizeof push;
  w.binds = 9;
  bind_data(m, &w, sorted);
  w.bind[7] = rows_of(m->value.there, k->value, at, n, value);
  w.bind[8] = gradient ? rows_of(m->gradient.there, k->gradient, at, n, 3 * value) : w.bind[7];
  k->queue.stage = "sample";
  ylm__steps_work(&k->queue, &w);
}

static void shade(const sampling *m, size_t at, size_t n, bool sorted, ylm_error *e) {
  ylm_gpu_grid *k = m->k;
  bool material = m->material.host || m->material.there;
  uint32_t channels = (uint32_t)k->form.channels;
  uint32_t constant[] = {
      CHUNK,    (uint32_t)m->q->interpolation, channels, sorted, (uint32_t)k->parts, material,
      k->packed};
  struct {
    uint32_t n, spread, stride, part_rows, given, row, count;
    float unit[3];
  } push = {(uint32_t)n,
            0,
            (uint32_t)k->stride,
            (uint32_t)k->part_rows,
            (uint32_t)k->width / channels,
            (uint32_t)m->row,
            (uint32_t)common(m),
            {0}};
  unit_of(m, push.unit);
  ylm_gpu_work w = work_of(m, "grid_shade", 7, constant, n, &k->queue.status, e);
  push.spread = spread(&w, sorted);
  w.push = &push;
  w.push_bytes = sizeof push;
  w.binds = 10;
  bind_data(m, &w, sorted);
  w.bind[7] = rows_of(m->transfer.there, k->transfer, at, n, m->row * sizeof(float));
  w.bind[8] = material ? rows_of(m->material.there, k->material, at, n, ROW) : w.bind[7];
  w.bind[9] = rows_of(m->value.there, k->value, at, n, 12);
  k->queue.stage = "shade";
  ylm__steps_work(&k->queue, &w);
}

/* -- what the device leaves to the host ------------------------------------------------------ */

/* Rows at .. at+n-1 of an input, from the device where they are there; the caller frees *own. */
static const void *here(const ylm_gpu_input *in, size_t at, size_t n, size_t bytes, void **own,
                        ylm_status *s, ylm_error *e) {
  *own = NULL;
  if (*s != YLM_OK) return NULL;
  if (in->host) return (const char *)in->host + at * bytes;
  if (!in->there) return NULL;
  *own = ylm_alloc(n, bytes);
  *s = *own ? ylm_gpu_download(in->there, at * bytes, n * bytes, *own, e) : ylm_no_memory(e);
  return *own;
}

/* Writes rows to an output, wherever it is. */
static ylm_status put(const ylm_gpu_output *out, size_t at, size_t n, size_t bytes,
                      const void *rows, ylm_error *e) {
  if (out->host) memcpy((char *)out->host + at * bytes, rows, n * bytes);
  return out->there ? ylm_gpu_upload(out->there, at * bytes, n * bytes, rows, e) : YLM_OK;
}

/* Radiance of point i from its coefficients. */
static void dot(const sampling *m, const float *L, const float *T, const float *material,
                float *radiance) {
  size_t channels = (size_t)m->k->form.channels, given = m->k->width / channels;
  for (size_t c = 0; c < 3; c++) {
    const float *x = L + (channels == 3 ? c * given : 0);
    float sum = 0;
    for (size_t j = 0; j < common(m); j++) sum += T[j] * x[j];
    radiance[c] = sum;
  }
  if (material) ylm_material_row_radiance(material, radiance);
}

/* Samples points at .. at+n-1 on the host. */
static ylm_status run_host(const sampling *m, size_t at, size_t n, ylm_grid_report *r,
                           ylm_error *e) {
  ylm_grid_query q = *m->q;
  ylm_status s = YLM_OK;
  size_t w = m->k->width, wide = (m->gradient.host || m->gradient.there ? 4 : 1) * w;
  void *own[3];
  q.dtype = YLM_FLOAT;
  q.progress = NULL;
  const void *points = here(&m->points, at, n, point_bytes(m), &own[0], &s, e);
  const float *T = here(&m->transfer, at, n, m->row * sizeof *T, &own[1], &s, e);
  const float *material = here(&m->material, at, n, ROW, &own[2], &s, e);
  float *L = ylm_alloc(n * (wide + 3), sizeof *L), *out = L ? L + n * wide : NULL;
  if (!L) s = ylm_no_memory(e);
  if (s == YLM_OK)
    s = ylm_grid_sample(m->grid, &q, n, points, L, wide > w ? L + n * w : NULL, r, e);
  for (size_t i = 0; s == YLM_OK && m->shade && i < n; i++)
    dot(m, L + i * w, T + i * m->row, material ? material + YLM_MATERIAL_ROW * i : NULL,
        out + 3 * i);
  if (s == YLM_OK && m->shade) s = put(&m->value, at, n, 3 * sizeof *out, out, e);
  if (s == YLM_OK && !m->shade) s = put(&m->value, at, n, w * sizeof *L, L, e);
  if (s == YLM_OK && wide > w) s = put(&m->gradient, at, n, 3 * w * sizeof *L, L + n * w, e);
  for (int i = 0; i < 3; i++) ylm_free(own[i]);
  ylm_free(L);
  return s;
}

static ylm_status patch(const sampling *m, size_t at, size_t n, ylm_error *e) {
  uint32_t(*place)[4] = m->scratch;
  ylm_status s = ylm_gpu_download(m->k->places, 0, n * sizeof *place, place, e);
  for (size_t i = 0, end; s == YLM_OK && i < n; i = end) {
    ylm_grid_report r;
    end = i + 1;
    if (place[i][0] != YLM_GPU_NONE) continue;
    while (end < n && place[end][0] == YLM_GPU_NONE) end++;
    s = run_host(m, at + i, end - i, &r, e);
    if (s != YLM_OK) break;
    m->report->outside += r.outside;
    m->report->unbaked += r.unbaked;
  }
  return s;
}

/* -- passes ----------------------------------------------------------------------------------- */

static ylm_status pass(const sampling *m, size_t at, size_t n, ylm_error *e) {
  ylm_gpu_grid *k = m->k;
  /* Summing the counts of all cells has to pay. */
  bool sorted = n >= k->cell_count / 64;
  uint32_t counts[3];
  size_t w = width_of(m) * sizeof(float);
  ylm_status s = reserve(m, n, sorted, e);
  if (s == YLM_OK) s = bring_points(m, at, n, e);
  if (s == YLM_OK) s = bring(m, &m->transfer, at, n, m->row * sizeof(float), &k->transfer, e);
  if (s == YLM_OK) s = bring(m, &m->material, at, n, ROW, &k->material, e);
  if (s != YLM_OK) return s;
  k->queue.g = k->g;
  k->queue.times = m->times;
  k->queue.status = YLM_OK;
  k->queue.e = e;
  locate(m, at, n, sorted, e);
  (m->shade ? shade : sample)(m, at, n, sorted, e);
  s = ylm__steps_run(&k->queue);
  if (s == YLM_OK) s = ylm_gpu_download(k->counts, 0, sizeof counts, counts, e);
  if (s == YLM_OK) s = fetch(m, &m->value, at, n, w, k->value, e);
  if (s == YLM_OK) s = fetch(m, &m->gradient, at, n, 3 * w, k->gradient, e);
  if (s != YLM_OK) return s;
  m->report->outside += counts[0];
  m->report->unbaked += counts[1];
  return counts[2] ? patch(m, at, n, e) : YLM_OK;
}

static ylm_status check(const sampling *m, ylm_error *e) {
  const ylm_gpu_grid *k = m->k;
  const ylm_gpu_buffer *there[] = {m->points.there, m->transfer.there, m->material.there,
                                   m->value.there, m->gradient.there};
  ylm_status s = ylm_gpu_state(k->g, e);
  if (s != YLM_OK) return s;
  if (m->q->origin)
    return ylm_fail(e, YLM_EINVAL, "a device takes points that are relative to no origin");
  if (k->busy)
    return ylm_fail(e, YLM_EBUSY, "the grid's copy is in use by a call that has not returned");
  if (!ylm_gpu_grid_current(k, m->grid))
    return ylm_fail(e, YLM_EINVAL,
                    "the grid was updated since it was copied to the device: copy it again");
  for (int i = 0; i < 5; i++)
    if (there[i] && ylm_gpu_buffer_device(there[i]) != k->g)
      return ylm_fail(e, YLM_EINVAL, "an array is in the memory of another device");
  if (m->points.there && m->q->point_dtype == YLM_DOUBLE && !k->wide)
    return ylm_fail(e, YLM_EMISSING, "'%s' does not read points in double",
                    ylm_gpu_about(k->g)->name);
  return YLM_OK;
}

/* All passes over n points. */
static ylm_status passes(sampling *m, size_t n, ylm_grid_report *report, ylm_error *e) {
  double start = ylm_seconds();
  size_t value = width_of(m) * sizeof(float), own = 16 + 4 + point_bytes(m), widest = 24, rows;
  size_t gradient = m->gradient.host || m->gradient.there ? 3 * value : 0;
  size_t row[] = {value, gradient, m->row * sizeof(float)};
  ylm_grid_report r = {0};
  m->report = &r;
  ylm_status s = check(m, e);
  if (s != YLM_OK) return s;
  for (int i = 0; i < 3; i++) widest = row[i] > widest ? row[i] : widest;
  own += (m->value.host ? value : 0) + (m->gradient.host ? gradient : 0) +
         (m->transfer.host ? row[2] : 0);
  rows = ylm_gpu_rows(m->k->g, n, widest, own, SAMPLE_PASS_BYTES);
  if (!rows && n) return ylm_fail(e, YLM_ELIMIT, "the device has too little memory for 64 points");
  m->scratch = ylm_alloc(rows, 24);
  if (!m->scratch) return ylm_no_memory(e);
  m->k->busy = true;
  for (size_t at = 0, now; s == YLM_OK && at < n; at += now) {
    now = n - at < rows ? n - at : rows;
    s = pass(m, at, now, e);
    if (s == YLM_OK) s = ylm_report(m->q->progress, at + now, n, m->shade ? "shading" : "sampling");
  }
  m->k->busy = false;
  ylm_free(m->scratch);
  r.seconds = ylm_seconds() - start;
  if (report) *report = r;
  return s;
}

ylm_status ylm_gpu_grid_sample(ylm_gpu_grid *k, const ylm_grid *grid, const ylm_grid_query *q,
                               size_t n, ylm_gpu_input points, ylm_gpu_output value,
                               ylm_gpu_output gradient, ylm_grid_report *report,
                               ylm_gpu_times *times, ylm_error *e) {
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
                              size_t n, ylm_gpu_input points, size_t row, ylm_gpu_input transfer,
                              ylm_gpu_input material, ylm_gpu_output radiance,
                              ylm_grid_report *report, ylm_gpu_times *times, ylm_error *e) {
  sampling m = {.k = k,
                .grid = grid,
                .q = q,
                .points = points,
                .transfer = transfer,
                .material = material,
                .value = radiance,
                .shade = true,
                .row = row,
                .times = times};
  return passes(&m, n, report, e);
}
