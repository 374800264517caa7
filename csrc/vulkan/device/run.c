/*
** run.c - work in slices: none long enough for a desktop's watchdog to notice.
**
** A kernel's rate, in seconds per unit of cost, is learnt from its dispatches: the first has one group. Small ones make the
** rate look worse than it is, so that later slices are cut too short rather than too long. Slices of several steps share a
** submission as long as they are foreseen to take GPU_SUBMISSION seconds together.
*/
#include "../calibration.h"
#include "gpu.h"

#include <math.h>
#include <string.h>

/* A slice that has been recorded. */
typedef struct slice {
  const ylm_gpu_work *work;
  uint64_t groups;
} slice;

typedef struct runner {
  ylm_gpu *g;
  const ylm_gpu_work *work;
  size_t n, at;           /* the step to go on with */
  uint64_t done;          /* groups of it that have been recorded */
  double total, finished; /* cost of everything, of what is done */
  slice slices[YLM__SETS];
  uint32_t count;
  ylm_gpu_times *times;
} runner;

static double cost_of(const ylm_gpu_work *w) {
  return w->cost > 0 && isfinite(w->cost) ? w->cost : 1;
}

/* -- checking -------------------------------------------------------------------- */

static uint64_t bytes_of(const ylm_gpu_bind *b) {
  return b->bytes ? b->bytes : b->buffer->bytes - b->offset;
}

static ylm_status check_bind(const ylm_gpu *g, const ylm_gpu_work *w, const ylm_gpu_bind *b,
                             ylm_error *e) {
  if (!b->buffer || b->buffer->gpu != g)
    return ylm_fail(e, YLM_EINVAL, "%s: a buffer is missing, or another device's", w->stage);
  if (b->offset > b->buffer->bytes || b->bytes > b->buffer->bytes - b->offset)
    return ylm_fail(e, YLM_EOVERFLOW, "%s: outside of a buffer", w->stage);
  bool words = w->verb != YLM_GPU_DISPATCH;
  if (b->offset % (words ? 4 : 256) || (words && bytes_of(b) % 4))
    return ylm_fail(e, YLM_EINVAL, "%s: a misaligned part of a buffer", w->stage);
  if (!words && bytes_of(b) > g->info.bind_bytes)
    return ylm_fail(e, YLM_ELIMIT, "%s: a kernel of '%s' sees %llu bytes of a buffer at most",
                    w->stage, g->info.name, (unsigned long long)g->info.bind_bytes);
  return YLM_OK;
}

static ylm_status check_work(const ylm_gpu *g, const ylm_gpu_work *w, ylm_error *e) {
  int binds = w->verb == YLM_GPU_DISPATCH ? (w->kernel ? w->kernel->binds : -1)
              : w->verb == YLM_GPU_FILL   ? 1
                                          : 2;
  if (binds != w->binds)
    return ylm_fail(e, YLM_EINVAL, "%s: %d buffers, not %d", w->stage, binds, w->binds);
  if (w->push_bytes % 4 || w->push_bytes > YLM_GPU_PUSH_BYTES)
    return ylm_fail(e, YLM_EINVAL, "%s: push constants of %zu bytes", w->stage, w->push_bytes);
  if (w->verb == YLM_GPU_DISPATCH && w->groups > UINT32_MAX / (uint64_t)w->kernel->constant[0])
    return ylm_fail(e, YLM_ELIMIT, "%s: more than 2^32 items", w->stage);
  for (int i = 0; i < binds; i++) {
    ylm_status s = check_bind(g, w, &w->bind[i], e);
    if (s != YLM_OK) return s;
  }
  if (w->verb == YLM_GPU_COPY &&
      bytes_of(&w->bind[0]) > w->bind[1].buffer->bytes - w->bind[1].offset)
    return ylm_fail(e, YLM_EOVERFLOW, "%s: outside of a buffer", w->stage);
  return YLM_OK;
}

/* -- recording ------------------------------------------------------------------- */

static ylm_status record_dispatch(runner *r, const ylm_gpu_work *w, uint32_t groups, ylm_error *e) {
  ylm_gpu *g = r->g;
  ylm_gpu_kernel *k = w->kernel;
  VkDescriptorSet set;
  VkDescriptorSetAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                      .descriptorPool = g->sets,
                                      .descriptorSetCount = 1,
                                      .pSetLayouts = &k->set};
  VkResult result = g->vkAllocateDescriptorSets(g->device, &info, &set);
  if (result != VK_SUCCESS) return ylm__gpu_fail(g, result, "no descriptor set", e);
  VkDescriptorBufferInfo buffer[YLM_GPU_BINDS];
  VkWriteDescriptorSet write[YLM_GPU_BINDS];
  for (int i = 0; i < w->binds; i++) {
    const ylm_gpu_bind *b = &w->bind[i];
    uint64_t bytes = bytes_of(b);
    /* An empty buffer has a word behind it. */
    buffer[i] = (VkDescriptorBufferInfo){b->buffer->buffer, bytes ? b->offset : 0,
                                         bytes ? (bytes + 3) / 4 * 4 : VK_WHOLE_SIZE};
    write[i] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                      .dstSet = set,
                                      .dstBinding = (uint32_t)i,
                                      .descriptorCount = 1,
                                      .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                      .pBufferInfo = &buffer[i]};
  }
  g->vkUpdateDescriptorSets(g->device, (uint32_t)w->binds, write, 0, NULL);
  uint32_t push[1 + YLM_GPU_PUSH_BYTES / 4] = {(uint32_t)r->done};
  ylm_copy(push + 1, w->push, w->push_bytes);
  g->vkCmdBindPipeline(g->command, VK_PIPELINE_BIND_POINT_COMPUTE, k->pipeline);
  g->vkCmdBindDescriptorSets(g->command, VK_PIPELINE_BIND_POINT_COMPUTE, k->layout, 0, 1, &set, 0,
                             NULL);
  g->vkCmdPushConstants(g->command, k->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, push);
  g->vkCmdDispatch(g->command, groups, 1, 1);
  g->use.dispatches++;
  return YLM_OK;
}

static ylm_status record(runner *r, const ylm_gpu_work *w, uint32_t groups, ylm_error *e) {
  ylm_gpu *g = r->g;
  const ylm_gpu_bind *b = w->bind;
  ylm_status s = YLM_OK;
  if (r->count) ylm__gpu_barrier(g);
  if (g->queries)
    g->vkCmdWriteTimestamp(g->command, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, g->queries,
                           2 * r->count);
  if (w->verb == YLM_GPU_DISPATCH)
    s = record_dispatch(r, w, groups, e);
  else if (w->verb == YLM_GPU_FILL)
    g->vkCmdFillBuffer(g->command, b->buffer->buffer, b->offset, bytes_of(b), w->value);
  else {
    VkBufferCopy region = {b[0].offset, b[1].offset, bytes_of(b)};
    g->vkCmdCopyBuffer(g->command, b[0].buffer->buffer, b[1].buffer->buffer, 1, &region);
  }
  if (g->queries)
    g->vkCmdWriteTimestamp(g->command, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, g->queries,
                           2 * r->count + 1);
  r->slices[r->count++] = (slice){w, groups};
  return s;
}

/* How many of `left` groups are foreseen to take `room` seconds; *seconds is what they take. */
static uint32_t slice_of(const ylm_gpu *g, const ylm_gpu_work *w, uint64_t left, double room,
                         double *seconds) {
  const ylm_gpu_kernel *k = w->kernel;
  double one = k->rate * cost_of(w), groups = one > 0 ? room / one : 1;
  if (groups < 1) groups = 1;
  if (groups > (double)left) groups = (double)left;
  if (groups > (double)g->info.groups) groups = (double)g->info.groups;
  *seconds = one * groups;
  return (uint32_t)groups;
}

/* Records what goes into one submission. */
static ylm_status fill_submission(runner *r, ylm_error *e) {
  double room = GPU_SUBMISSION;
  ylm_status s = YLM_OK;
  r->count = 0;
  while (s == YLM_OK && r->at < r->n && r->count < YLM__SETS) {
    const ylm_gpu_work *w = &r->work[r->at];
    bool known = true;
    if (w->verb != YLM_GPU_DISPATCH) {
      if (bytes_of(&w->bind[0])) s = record(r, w, 1, e);
    } else if (w->groups > r->done) {
      double seconds;
      known = w->kernel->rate > 0;
      uint32_t groups = slice_of(r->g, w, w->groups - r->done, room, &seconds);
      if (r->count && seconds > room) break;
      s = record(r, w, groups, e);
      r->done += groups;
      room -= seconds;
    }
    if (w->verb != YLM_GPU_DISPATCH || r->done >= w->groups) r->at++, r->done = 0;
    if (!known || room <= 0) break;
  }
  return s;
}

/* -- learning ---------------------------------------------------------------------- */

static void add_time(ylm_gpu_times *t, const char *name, double seconds) {
  if (!t) return;
  int i = 0;
  if (!name) name = "";
  while (i < t->stages && strcmp(t->stage[i].name, name) != 0) i++;
  if (i == YLM_GPU_STAGES)
    i--;
  else if (i == t->stages)
    t->stage[t->stages++] = (struct ylm_gpu_stage){name, 0, 0, 0};
  t->stage[i].seconds += seconds;
  if (seconds > t->stage[i].longest) t->stage[i].longest = seconds;
  t->stage[i].dispatches++;
}

/* The rate from a dispatch that took that long. The first is not to be trusted: the driver
   may have compiled the kernel. */
static void learn(ylm_gpu_kernel *k, double seconds, double cost) {
  double rate = seconds / cost;
  if (!(rate > 1e-15)) rate = 1e-15;
  if (!k->warm)
    k->warm = true;
  else
    k->rate = rate > k->rate / 2 ? rate : k->rate / 2;
}

static ylm_status read_times(runner *r, double wall, ylm_error *e) {
  ylm_gpu *g = r->g;
  uint64_t ticks[2 * YLM__SETS];
  if (g->queries && r->count) {
    VkResult result = g->vkGetQueryPoolResults(g->device, g->queries, 0, 2 * r->count,
                                               2 * r->count * sizeof *ticks, ticks, sizeof *ticks,
                                               VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    if (result != VK_SUCCESS) return ylm__gpu_fail(g, result, "no timestamps", e);
  }
  for (uint32_t i = 0; i < r->count; i++) {
    const ylm_gpu_work *w = r->slices[i].work;
    double seconds = wall / r->count;
    if (g->queries) seconds = (double)((ticks[2 * i + 1] - ticks[2 * i]) & g->tick_mask) * g->tick;
    add_time(r->times, w->stage, seconds);
    if (w->verb != YLM_GPU_DISPATCH) continue;
    double cost = cost_of(w) * (double)r->slices[i].groups;
    learn(w->kernel, seconds, cost);
    r->finished += cost;
  }
  return YLM_OK;
}

/* -- running ----------------------------------------------------------------------- */

static ylm_status submission(runner *r, ylm_error *e) {
  ylm_gpu *g = r->g;
  VkResult result = g->vkResetDescriptorPool(g->device, g->sets, 0);
  if (result != VK_SUCCESS) return ylm__gpu_fail(g, result, "no descriptor sets", e);
  ylm_status s = ylm__gpu_begin(g, e);
  if (s != YLM_OK) return s;
  if (g->queries) g->vkCmdResetQueryPool(g->command, g->queries, 0, 2 * YLM__SETS);
  s = fill_submission(r, e);
  double start = ylm_seconds();
  if (s == YLM_OK) s = ylm__gpu_submit(g, e);
  if (s == YLM_OK) s = read_times(r, ylm_seconds() - start, e);
  return s;
}

ylm_status ylm_gpu_run(ylm_gpu *g, size_t n, const ylm_gpu_work *work, ylm_gpu_times *times,
                       const ylm_progress *progress, ylm_error *e) {
  runner r = {.g = g, .work = work, .n = n, .times = times};
  double start = ylm_seconds(), told = start;
  ylm_status s = ylm_gpu_state(g, e);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    s = check_work(g, &work[i], e);
    if (work[i].verb == YLM_GPU_DISPATCH) r.total += cost_of(&work[i]) * (double)work[i].groups;
  }
  g->running++;
  while (s == YLM_OK && r.at < n) {
    const char *stage = work[r.at].stage;
    s = submission(&r, e);
    double now = ylm_seconds();
    if (s == YLM_OK && progress && (now - told > 0.1 || r.at == n)) {
      told = now;
      double part = r.at < n ? r.finished / r.total : 1;
      s = ylm_report(progress, (uint64_t)(part * 10000), 10000, stage ? stage : "");
    }
  }
  g->running--;
  g->use.run += ylm_seconds() - start;
  return s;
}
