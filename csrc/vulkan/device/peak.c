/* peak.c - what the device computes and moves at best, measured. */
#include "../calibration.h"
#include "ylm_vulkan.h"

enum { GROUP = 64, TRIES = 200 };

/* Operations per second of the best; `amount` of them are in one run. */
static ylm_status best(ylm_gpu *g, const ylm_gpu_work *w, double amount, double *rate,
                       ylm_error *e) {
  double start = ylm_seconds();
  *rate = 0;
  for (int i = 0; i < TRIES && (i < 4 || ylm_seconds() - start < GPU_PEAK_SECONDS); i++) {
    ylm_gpu_times t = {0};
    ylm_status s = ylm_gpu_run(g, 1, w, &t, NULL, e);
    if (s != YLM_OK) return s;
    double now = t.stage[0].seconds > 0 ? amount / t.stage[0].seconds : 0;
    if (i == 0 || now <= *rate) continue; /* the first learns and compiles */
    if (now > 1.02 * *rate) start = ylm_seconds();
    *rate = now;
  }
  return YLM_OK;
}

static ylm_status fma_peak(ylm_gpu *g, size_t items, uint32_t steps, double *flops, ylm_error *e) {
  struct {
    uint32_t n, steps;
    float a, b;
  } push = {(uint32_t)items, steps, 0.999f, 0.001f};
  ylm_gpu_buffer *out;
  ylm_gpu_work w = {.verb = YLM_GPU_DISPATCH,
                    .stage = "fma",
                    .groups = (items + GROUP - 1) / GROUP,
                    .cost = steps,
                    .push = &push,
                    .push_bytes = sizeof push,
                    .binds = 1};
  ylm_status s = ylm_gpu_kernel_get(g, "peak_fma", 1, (uint32_t[]){GROUP}, &w.kernel, e);
  if (s != YLM_OK) return s;
  s = ylm_gpu_buffer_create(g, items * 4, &out, e);
  w.bind[0].buffer = out;
  if (s == YLM_OK) s = best(g, &w, (double)items * steps * 32, flops, e);
  ylm_gpu_buffer_free(out);
  return s;
}

static ylm_status copy_peak(ylm_gpu *g, size_t items, double *bytes, ylm_error *e) {
  uint32_t n = (uint32_t)items;
  ylm_gpu_buffer *from = NULL, *to = NULL;
  ylm_gpu_work w = {.verb = YLM_GPU_DISPATCH,
                    .stage = "copy",
                    .groups = (items + GROUP - 1) / GROUP,
                    .push = &n,
                    .push_bytes = sizeof n,
                    .binds = 2};
  ylm_status s = ylm_gpu_kernel_get(g, "peak_copy", 1, (uint32_t[]){GROUP}, &w.kernel, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(g, items * 16, &from, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(g, items * 16, &to, e);
  if (s == YLM_OK) {
    ylm_gpu_work fill = {.verb = YLM_GPU_FILL, .stage = "fill", .binds = 1, .bind[0].buffer = from};
    s = ylm_gpu_run(g, 1, &fill, NULL, NULL, e);
  }
  w.bind[0].buffer = from;
  w.bind[1].buffer = to;
  if (s == YLM_OK) s = best(g, &w, (double)items * 32, bytes, e);
  ylm_gpu_buffer_free(from);
  ylm_gpu_buffer_free(to);
  return s;
}

ylm_status ylm_gpu_peak(ylm_gpu *g, double *flops, double *bytes, ylm_error *e) {
  bool software = ylm_gpu_about(g)->type == YLM_GPU_CPU;
  ylm_status s = fma_peak(g, software ? 1 << 14 : 1 << 20, 1024, flops, e);
  size_t items = software ? 1 << 20 : 1 << 22; /* 16, 64 MiB: more than caches hold */
  return s == YLM_OK ? copy_peak(g, items, bytes, e) : s;
}
