/* sh.c - spherical harmonics on the device: low degrees unrolled, higher ones by recurrences. */
#include "calibration.h"
#include "ylm_sh.h"
#include "ylm_vulkan.h"

enum { UNROLLED_LMAX = 4, FLOAT_LMAX = 128, GROUP = 64 };
#define STAGE "spherical harmonics"

typedef struct job {
  ylm_gpu *g;
  int lmax, order;
  bool solid;
  ylm_dtype t;
  size_t count, rows;              /* coefficients; points of a pass */
  ylm_gpu_buffer *points, *out[3]; /* of one pass */
  ylm_gpu_buffer *none, *table;
  ylm_gpu_kernel *kernel;
} job;

static const size_t width[3] = {1, 3, 6};

static void clear(job *j) {
  ylm_gpu_buffer_free(j->points);
  for (int k = 0; k < 3; k++) ylm_gpu_buffer_free(j->out[k]);
  ylm_gpu_buffer_free(j->none);
  ylm_gpu_buffer_free(j->table);
}

static ylm_status choose_kernel(job *j, ylm_error *e) {
  bool low = j->lmax <= UNROLLED_LMAX;
  const char *name = low                  ? j->t == YLM_DOUBLE ? "sh_double" : "sh_float"
                     : j->t == YLM_DOUBLE ? "sh_recurrence_double"
                                          : "sh_recurrence_float";
  uint32_t unrolled[] = {GROUP, (uint32_t)j->lmax, (uint32_t)j->order, j->solid};
  uint32_t recurrence[] = {GROUP, (uint32_t)j->order, j->solid};
  return ylm_gpu_kernel_get(j->g, name, low ? 4 : 3, low ? unrolled : recurrence, &j->kernel, e);
}

/* The table of the recurrences, degrees 1 .. lmax. */
static ylm_status create_table(job *j, ylm_error *e) {
  size_t n = (size_t)j->lmax * ((size_t)j->lmax + 3) / 2 * 7, size = ylm_dtype_size(j->t);
  void *table = ylm_alloc(n, size);
  double k[7], *d = table;
  float *f = table;
  if (!table) return ylm_no_memory(e);
  for (int l = 1; l <= j->lmax; l++)
    for (int q = 0; q <= l; q++) {
      ylm_sh_coefficients(l, q, k);
      for (int i = 0; i < 7; i++)
        if (j->t == YLM_DOUBLE)
          *d++ = k[i];
        else
          *f++ = (float)k[i];
    }
  ylm_status s = ylm_gpu_buffer_from(j->g, n * size, table, &j->table, e);
  ylm_free(table);
  return s;
}

/* Buffers of one pass. */
static ylm_status prepare(job *j, size_t n, ylm_error *e) {
  size_t size = ylm_dtype_size(j->t), row = width[j->order] * j->count * size, sum = 3 * size;
  for (int k = 0; k <= j->order; k++) sum += width[k] * j->count * size;
  uint64_t bind = ylm_gpu_about(j->g)->bind_bytes;
  if (row > bind)
    return ylm_fail(e, YLM_ELIMIT, "the device sees too little of a buffer for lmax %d", j->lmax);
  j->rows = n;
  if (j->rows > SH_PASS_BYTES / sum) j->rows = SH_PASS_BYTES / sum;
  if (j->rows > bind / row) j->rows = bind / row;
  if (j->rows < 1) j->rows = 1;
  ylm_status s = choose_kernel(j, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(j->g, j->rows * 3 * size, &j->points, e);
  for (int k = 0; s == YLM_OK && k <= j->order; k++)
    s = ylm_gpu_buffer_create(j->g, j->rows * width[k] * j->count * size, &j->out[k], e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(j->g, 0, &j->none, e);
  return s == YLM_OK && j->lmax > UNROLLED_LMAX ? create_table(j, e) : s;
}

static ylm_status pass(job *j, size_t at, size_t n, const void *p, void *const out[3],
                       ylm_gpu_times *times, const ylm_progress *progress, ylm_error *e) {
  size_t size = ylm_dtype_size(j->t);
  uint32_t push[2] = {(uint32_t)n, (uint32_t)j->lmax};
  ylm_gpu_work w = {.verb = YLM_GPU_DISPATCH,
                    .stage = STAGE,
                    .kernel = j->kernel,
                    .groups = (n + GROUP - 1) / GROUP,
                    .cost = (double)j->count,
                    .push = push,
                    .push_bytes = j->table ? 8 : 4,
                    .binds = j->table ? 5 : 4,
                    .bind = {{.buffer = j->points}, [4] = {.buffer = j->table}}};
  for (int k = 0; k < 3; k++) w.bind[1 + k].buffer = k <= j->order ? j->out[k] : j->none;
  ylm_status s = ylm_gpu_upload(j->points, 0, n * 3 * size, (const char *)p + at * 3 * size, e);
  if (s == YLM_OK) s = ylm_gpu_run(j->g, 1, &w, times, progress, e);
  for (int k = 0; s == YLM_OK && k <= j->order; k++) {
    size_t row = width[k] * j->count * size;
    if (out[k]) s = ylm_gpu_download(j->out[k], 0, n * row, (char *)out[k] + at * row, e);
  }
  return s;
}

ylm_status ylm_gpu_sh_eval(ylm_gpu *g, int lmax, int derivatives, bool solid, ylm_dtype t, size_t n,
                           const void *p, void *y, void *dy, void *ddy, ylm_gpu_times *times,
                           const ylm_progress *progress, ylm_error *e) {
  job j = {.g = g, .lmax = lmax, .order = derivatives, .solid = solid, .t = t};
  void *const out[3] = {y, dy, ddy};
  ylm_status s = ylm_gpu_state(g, e);
  if (s != YLM_OK) return s;
  if (lmax < 0 || lmax > YLM_LMAX || derivatives < 0 || derivatives > 2)
    return ylm_fail_plain(e, YLM_ERANGE);
  if (t == YLM_FLOAT && lmax > FLOAT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "float on a device goes to lmax %d: ask for double", FLOAT_LMAX);
  ylm_sh_how how = {.derivatives = derivatives, .solid = solid, .isa = -1};
  s = ylm_sh_check_points(&how, lmax, t, n, p, e);
  if (s != YLM_OK || n == 0) return s;
  j.count = ylm_sh_count(lmax);
  s = prepare(&j, n, e);
  for (size_t at = 0, rows; s == YLM_OK && at < n; at += rows) {
    rows = n - at < j.rows ? n - at : j.rows;
    ylm_progress_part part;
    s = pass(&j, at, rows, p, out, times, ylm_progress_part_of(&part, progress, NULL, at, rows, n),
             e);
  }
  clear(&j);
  return s;
}
