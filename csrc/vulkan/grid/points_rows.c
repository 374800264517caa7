/* points_rows.c - rows of points between the device and the host. */
#include "../calibration.h"
#include "points.h"

#include <string.h>

ylm_status ylm__points_download(gpu_points *p, float *data) {
  uint64_t row = 16 * (uint64_t)p->stride, n = p->points - p->first;
  ylm_status s = YLM_OK;
  double start = ylm_seconds();
  for (uint64_t at = 0, rows; s == YLM_OK && at < n; at += rows) {
    rows = n - at < p->part_rows ? n - at : p->part_rows;
    s = ylm_gpu_download(p->data[at / p->part_rows], 0, rows * row,
                         data + (p->first + at) * 4 * p->stride, p->e);
  }
  points_copied(p, "download", start);
  return s;
}

ylm_status ylm__points_extra(gpu_points *p, uint32_t first, uint32_t n, float *lambda, float *norm,
                             uint8_t *flags) {
  enum { PART = 4096 };
  float(*extra)[3] = ylm_alloc(n < PART ? n : PART, sizeof *extra);
  ylm_status s = extra ? YLM_OK : ylm_no_memory(p->e);
  double start = ylm_seconds();
  for (uint32_t at = 0, now; s == YLM_OK && at < n; at += now) {
    now = n - at < PART ? n - at : PART;
    s = ylm_gpu_download(p->extra, 12 * ((uint64_t)first + at), 12 * (uint64_t)now, extra, p->e);
    for (uint32_t i = 0; s == YLM_OK && i < now; i++) {
      lambda[at + i] = extra[i][0];
      norm[at + i] = extra[i][1];
      if (extra[i][2] > 0) flags[at + i] |= YLM_GRID_POINT_INVALID;
    }
  }
  points_copied(p, "download", start);
  if (s == YLM_OK) ylm_light_saturate(YLM_FLOAT, n, lambda);
  if (s == YLM_OK) ylm_light_saturate(YLM_FLOAT, n, norm);
  ylm_free(extra);
  return s;
}

/* One dispatch of grid_row.comp: rows of n points to p->packed, or from there. */
static ylm_status move(gpu_points *p, uint32_t n, const uint32_t *point, bool put) {
  ylm_status s = ylm_gpu_upload(p->item, 0, 4 * (uint64_t)n, point, p->e);
  if (s != YLM_OK) return s;
  step_kernel k = {"grid_row", 4, {put, 0, 0, (uint32_t)p->parts}, 0};
  uint32_t push[] = {n, p->stride, (uint32_t)p->part_rows};
  ylm_gpu_buffer *bind[GRID_PARTS + 2] = {[GRID_PARTS] = p->item, p->packed};
  points_bind(p, bind);
  p->q.stage = "points";
  p->q.status = YLM_OK;
  ylm__steps_dispatch(&p->q, &k, 4 * (uint64_t)n * p->stride, 3, push, GRID_PARTS + 2, bind);
  return ylm__steps_run(&p->q);
}

static ylm_status move_all(gpu_points *p, size_t n, const uint32_t *point, float *to,
                           const float *from) {
  uint64_t row = 16 * (uint64_t)p->stride, most = ylm_gpu_about(p->g)->bind_bytes;
  uint64_t some = (most < POINTS_PACKED_BYTES ? most : POINTS_PACKED_BYTES) / row;
  if (some > n) some = n;
  if (!n) return YLM_OK;
  ylm_status s = ylm__steps_reserve(p->g, &p->item, 4 * some, p->e);
  if (s == YLM_OK) s = ylm__steps_reserve(p->g, &p->packed, some * row, p->e);
  double start = ylm_seconds();
  for (size_t at = 0, now; s == YLM_OK && at < n; at += now) {
    now = n - at < some ? n - at : (size_t)some;
    size_t k = at * 4 * p->stride;
    if (from) s = ylm_gpu_upload(p->packed, 0, now * row, from + k, p->e);
    if (s == YLM_OK) s = move(p, (uint32_t)now, point + at, from != NULL);
    if (s == YLM_OK && to) s = ylm_gpu_download(p->packed, 0, now * row, to + k, p->e);
  }
  points_copied(p, to ? "download" : "upload", start);
  return s;
}

ylm_status ylm__points_take(gpu_points *p, size_t n, const uint32_t *point, float *rows) {
  return move_all(p, n, point, rows, NULL);
}

ylm_status ylm__points_put(gpu_points *p, size_t n, const uint32_t *point, const float *rows) {
  return move_all(p, n, point, NULL, rows);
}
