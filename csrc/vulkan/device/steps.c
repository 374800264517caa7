/* steps.c - lists of work, built step by step, and prefix sums. */
#include "steps.h"

#include <string.h>

#include "../gen/layout.h"
#include "ylm_list.h"

#define SCAN_BLOCK ((uint32_t)YLM_GPU_SCAN_EACH * YLM_GPU_SCAN_LANES)

void ylm__steps_free(step_queue *q) {
  ylm_gpu_buffer_free(q->blocks[0]);
  ylm_gpu_buffer_free(q->blocks[1]);
  ylm_free(q->work);
  ylm_free(q->push);
}

/* Room for one more step; NULL after a failure. */
static ylm_gpu_work *next_step(step_queue *q) {
  if (q->status != YLM_OK) return NULL;
  if (q->n == q->room) {
    size_t room = ylm_list_room(q->room, q->n + 1);
    if (!ylm_list_resize(&q->work, q->n, room, sizeof *q->work) ||
        !ylm_list_resize(&q->push, q->n, room, sizeof *q->push)) {
      q->status = ylm_no_memory(q->e);
      return NULL;
    }
    q->room = room;
  }
  ylm_gpu_work *w = &q->work[q->n++];
  *w = (ylm_gpu_work){.stage = q->stage};
  return w;
}

void ylm__steps_dispatch(step_queue *q, const step_kernel *k, uint64_t items, int words,
                         const uint32_t *push, int binds, ylm_gpu_buffer *const *buffer) {
  uint32_t constant[5] = {STEP_GROUP};
  memcpy(constant + 1, k->constant, sizeof k->constant);
  ylm_gpu_kernel *kernel = NULL;
  if (q->status != YLM_OK || !items) return;
  q->status = ylm_gpu_kernel_get(q->g, k->name, 1 + k->constants, constant, &kernel, q->e);
  ylm_gpu_work *w = next_step(q);
  if (!w) return;
  w->kernel = kernel;
  w->groups = (items + STEP_GROUP - 1) / STEP_GROUP;
  w->cost = k->cost;
  w->push_bytes = (size_t)words * 4;
  memcpy(q->push[q->n - 1], push, w->push_bytes);
  w->binds = binds;
  for (int i = 0; i < binds; i++) w->bind[i].buffer = buffer[i];
}

void ylm__steps_part(step_queue *q, int bind, uint64_t offset, uint64_t bytes) {
  if (q->status != YLM_OK) return;
  q->work[q->n - 1].bind[bind].offset = offset;
  q->work[q->n - 1].bind[bind].bytes = bytes;
}

void ylm__steps_work(step_queue *q, const ylm_gpu_work *from) {
  ylm_gpu_work *w = next_step(q);
  if (!w) return;
  const char *stage = w->stage;
  *w = *from;
  w->stage = stage;
  ylm_copy(q->push[q->n - 1], from->push, from->push_bytes);
}

void ylm__steps_fill(step_queue *q, ylm_gpu_buffer *b, uint32_t value) {
  ylm_gpu_work *w = next_step(q);
  if (!w) return;
  w->verb = YLM_GPU_FILL;
  w->binds = 1;
  w->bind[0].buffer = b;
  w->value = value;
}

void ylm__steps_copy(step_queue *q, ylm_gpu_buffer *from, uint64_t bytes, ylm_gpu_buffer *to) {
  ylm_gpu_work *w = bytes ? next_step(q) : NULL;
  if (!w) return;
  w->verb = YLM_GPU_COPY;
  w->binds = 2;
  w->bind[0] = (ylm_gpu_bind){from, 0, bytes};
  w->bind[1] = (ylm_gpu_bind){to, 0, 0};
}

/* One phase; blocks NULL: there is one block. */
static void scan_phase(step_queue *q, int kind, uint32_t phase, const uint32_t push[4],
                       ylm_gpu_buffer *x, ylm_gpu_buffer *before, ylm_gpu_buffer *blocks,
                       ylm_gpu_buffer *counts) {
  step_kernel k = {"octree_scan", 2, {(uint32_t)kind, phase}, 0};
  ylm_gpu_buffer *buffer[] = {x, before, blocks ? blocks : counts, counts};
  ylm__steps_dispatch(q, &k, (uint64_t)push[2] * STEP_GROUP, 4, push, 4, buffer);
}

/* Sums blocks into room of depth `deep`, scans that in place, adds up. */
static void scan(step_queue *q, int kind, uint32_t mask, ylm_gpu_buffer *x, uint32_t n,
                 ylm_gpu_buffer *before, ylm_gpu_buffer *counts, uint32_t slot, int deep) {
  uint32_t blocks = (n + SCAN_BLOCK - 1) / SCAN_BLOCK, push[] = {n, mask, blocks, slot};
  ylm_gpu_buffer *room = NULL;
  if (blocks > 1) {
    room = q->blocks[deep];
    scan_phase(q, kind, 0, push, x, before, room, counts);
    scan(q, SCAN_PLAIN, 0, room, blocks, room, counts, SCAN_NO_SUM, deep + 1);
  }
  scan_phase(q, kind, 1, push, x, before, room, counts);
}

void ylm__steps_scan(step_queue *q, int kind, uint32_t mask, ylm_gpu_buffer *x, uint32_t n,
                     ylm_gpu_buffer *before, ylm_gpu_buffer *counts, uint32_t slot) {
  uint64_t blocks = (n + SCAN_BLOCK - 1) / SCAN_BLOCK, above = blocks / SCAN_BLOCK + 1;
  if (q->status != YLM_OK || !n) return;
  if (above > SCAN_BLOCK) { /* two rooms are enough for 2^30 numbers */
    q->status = ylm_fail(q->e, YLM_ELIMIT, "%s: more than 2^30 numbers", q->stage);
    return;
  }
  /* Steps that wait may use the rooms there are: they are not replaced but by a run. */
  for (int i = 0; i < 2 && q->status == YLM_OK; i++) {
    uint64_t bytes = 4 * (i ? above : blocks);
    bool fits = q->blocks[i] && ylm_gpu_buffer_bytes(q->blocks[i]) >= bytes;
    if (!fits && q->n) q->status = ylm__steps_run(q);
    if (!fits && q->status == YLM_OK)
      q->status = ylm__steps_reserve(q->g, &q->blocks[i], bytes, q->e);
  }
  scan(q, kind, mask, x, n, before, counts, slot, 0);
}

ylm_status ylm__steps_run(step_queue *q) {
  for (size_t i = 0; i < q->n; i++) q->work[i].push = q->push[i];
  if (q->status == YLM_OK && q->n)
    q->status = ylm_gpu_run(q->g, q->n, q->work, q->times, q->progress, q->e);
  q->n = 0;
  return q->status;
}

ylm_status ylm__steps_counts(step_queue *q, ylm_gpu_buffer *counts, int n, uint32_t *count) {
  ylm_status s = ylm__steps_run(q);
  if (s == YLM_OK) s = ylm_gpu_download(counts, 0, 4 * (uint64_t)n, count, q->e);
  ylm__steps_fill(q, counts, 0);
  return s;
}

ylm_status ylm__steps_reserve(ylm_gpu *g, ylm_gpu_buffer **b, uint64_t bytes, ylm_error *e) {
  if (*b && ylm_gpu_buffer_bytes(*b) >= bytes) return YLM_OK;
  ylm_gpu_buffer_free(*b);
  *b = NULL;
  return ylm_gpu_buffer_create(g, bytes, b, e);
}

void ylm__steps_copied(ylm_gpu_times *t, const char *stage, double start) {
  if (!t) return;
  int i = 0;
  while (i < t->stages && strcmp(t->stage[i].name, stage) != 0) i++;
  if (i == YLM_GPU_STAGES) return;
  if (i == t->stages) t->stage[t->stages++] = (struct ylm_gpu_stage){stage, 0, 0, 0};
  t->stage[i].seconds += ylm_seconds() - start;
}
