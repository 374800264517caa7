/* points_probe.c - interpolants compared with values, on the device: shaders/grid_probe.comp. */
#include "../calibration.h"
#include "points.h"

#include <string.h>

/* One dispatch: the item buffer has n probes, then distances. */
static ylm_status dispatch(gpu_points *p, uint32_t n, bool held, ylm_gpu_buffer *distance) {
  step_kernel k = {"grid_probe", 4, {0, held, 0, (uint32_t)p->parts}, (double)p->width};
  uint32_t push[7] = {n, p->stride, (uint32_t)p->part_rows, p->width};
  ylm_gpu_buffer *bind[GRID_PARTS + 3];
  ylm__points_unit(p, push + 4);
  points_bind(p, bind);
  bind[GRID_PARTS] = p->item;
  bind[GRID_PARTS + 1] = held ? p->value : p->item;
  bind[GRID_PARTS + 2] = distance;
  p->q.stage = "residuals";
  p->q.status = YLM_OK;
  ylm__steps_dispatch(&p->q, &k, 8 * (uint64_t)n, 7, push, GRID_PARTS + 3, bind);
  return ylm__steps_run(&p->q);
}

ylm_status ylm__points_probe(gpu_points *p, size_t n, const ylm_grid_probe *probe, bool held,
                             float *distance) {
  uint64_t bind = ylm_gpu_about(p->g)->bind_bytes / sizeof *probe;
  size_t some = n < POINTS_PROBES ? n : POINTS_PROBES;
  if (some > bind) some = (size_t)bind;
  ylm_status s = ylm__steps_reserve(p->g, &p->item, some * sizeof *probe, p->e);
  if (s == YLM_OK) s = ylm__steps_reserve(p->g, &p->packed, some * sizeof *distance, p->e);
  for (size_t at = 0, now; s == YLM_OK && at < n; at += now) {
    now = n - at < some ? n - at : some;
    double start = ylm_seconds();
    s = ylm_gpu_upload(p->item, 0, now * sizeof *probe, probe + at, p->e);
    points_copied(p, "upload", start);
    if (s == YLM_OK) s = dispatch(p, (uint32_t)now, held, p->packed);
    start = ylm_seconds();
    if (s == YLM_OK)
      s = ylm_gpu_download(p->packed, 0, now * sizeof *distance, distance + at, p->e);
    points_copied(p, "download", start);
  }
  return s;
}

/* Values at n places, which become rows `at` .. of p->value. */
static ylm_status pass(gpu_points *p, const sum_plan *plan, const ylm_field_query *q,
                       const sum_reach *reach, size_t at, uint32_t n, const float *places,
                       uint8_t *inside, const ylm_progress *progress) {
  ylm_gpu_buffer **scratch = p->l->scratch;
  uint64_t row = 4 * (uint64_t)p->width;
  double start = ylm_seconds();
  ylm_status s = ylm__lights_scratch(p->l, BUFFER_POINTS, 12 * reach->places, p->e);
  if (s == YLM_OK)
    s = ylm_gpu_upload(scratch[BUFFER_POINTS], 0, 12 * (uint64_t)n, places + 3 * at, p->e);
  points_copied(p, "upload", start);
  if (s == YLM_OK) s = ylm__sum_run(p->l, plan, q, n, reach->at_once, progress, p->e);
  uint32_t *flags = ylm_alloc(n, sizeof *flags);
  if (s == YLM_OK && !flags) s = ylm_no_memory(p->e);
  if (s == YLM_OK) s = ylm_gpu_download(scratch[BUFFER_INSIDE], 0, 4 * (uint64_t)n, flags, p->e);
  for (uint32_t i = 0; s == YLM_OK && i < n; i++) inside[at + i] = flags[i] != 0;
  ylm_free(flags);
  ylm_gpu_work copy = {.verb = YLM_GPU_COPY,
                       .binds = 2,
                       .bind = {{scratch[BUFFER_VALUE], 0, n * row}, {p->value, at * row, 0}}};
  p->q.stage = "points";
  p->q.status = YLM_OK;
  if (s == YLM_OK) ylm__steps_work(&p->q, &copy);
  return s == YLM_OK ? ylm__steps_run(&p->q) : s;
}

ylm_status ylm__points_values(gpu_points *p, size_t n, const float *places, uint8_t *inside,
                              const ylm_progress *progress) {
  const ylm_grid_form *f = &ylm_grid_look(p->grid)->form;
  ylm_field_query q = {.lmax = f->lmax,
                       .channels = f->channels,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT};
  const sum_plan *plan;
  sum_reach reach;
  if (!n) return YLM_OK;
  ylm_status s = ylm__sum_plan_get(p->l, &q, &plan, p->e);
  if (s == YLM_OK) s = ylm__lights_reach(p->l, plan, &q, n, 0, &reach, p->e);
  if (s == YLM_OK) s = ylm__steps_reserve(p->g, &p->value, n * 4 * (uint64_t)p->width, p->e);
  for (size_t at = 0, now; s == YLM_OK && at < n; at += now) {
    ylm_progress_part part;
    now = n - at < reach.rows ? n - at : reach.rows;
    s = pass(p, plan, &q, &reach, at, (uint32_t)now, places, inside,
             ylm_progress_part_of(&part, progress, NULL, at, now, n));
  }
  return s;
}
