/* buffer.c - buffers, and copies between them and the host. */
#include "gpu.h"

#include <string.h>

#define STORAGE                                                                                    \
  (VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |                         \
   VK_BUFFER_USAGE_TRANSFER_DST_BIT)

static VkResult create(ylm_gpu *g, VkDeviceSize bytes, VkBufferUsageFlags usage, VkBuffer *b,
                       VkMemoryRequirements *need) {
  VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                             .size = bytes,
                             .usage = usage,
                             .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
  VkResult r = g->vkCreateBuffer(g->device, &info, NULL, b);
  if (r == VK_SUCCESS) g->vkGetBufferMemoryRequirements(g->device, *b, need);
  return r;
}

ylm_status ylm_gpu_buffer_create(ylm_gpu *g, uint64_t bytes, ylm_gpu_buffer **out, ylm_error *e) {
  VkMemoryRequirements need;
  *out = NULL;
  ylm_status s = ylm_gpu_state(g, e);
  if (s != YLM_OK) return s;
  if (bytes > g->info.memory_bytes)
    return ylm_fail(e, YLM_ENOMEM, "'%s' has %.0f MiB of memory, %.0f are needed", g->info.name,
                    (double)g->info.memory_bytes / 1048576, (double)bytes / 1048576);
  if (g->quota && bytes > g->quota - (g->use.bytes < g->quota ? g->use.bytes : g->quota))
    return ylm_fail(e, YLM_ENOMEM,
                    "'%s' has no %.1f MiB of memory left: close arrays, lights or grids there",
                    g->info.name, (double)bytes / 1048576);
  if (bytes > g->info.allocation_bytes)
    return ylm_fail(e, YLM_ELIMIT, "a buffer of '%s' has %.0f MiB at most, %.0f are needed",
                    g->info.name, (double)g->info.allocation_bytes / 1048576,
                    (double)bytes / 1048576);
  ylm_gpu_buffer *b = ylm_alloc_zero(1, sizeof *b);
  if (!b) return ylm_no_memory(e);
  /* Vulkan knows no empty buffers, and fills in words. */
  VkResult r = create(g, bytes ? (bytes + 3) / 4 * 4 : 4, STORAGE, &b->buffer, &need);
  if (r != VK_SUCCESS) {
    ylm_free(b);
    return ylm__gpu_fail(g, r, "no buffer", e);
  }
  s = ylm__memory_take(g, &need, &b->piece, e);
  if (s == YLM_OK) {
    r = g->vkBindBufferMemory(g->device, b->buffer, ylm__memory_of(&b->piece), b->piece.offset);
    if (r != VK_SUCCESS) s = ylm__gpu_fail(g, r, "no buffer", e);
  }
  if (s != YLM_OK) {
    g->vkDestroyBuffer(g->device, b->buffer, NULL);
    ylm__memory_give(g, &b->piece);
    ylm_free(b);
    return s;
  }
  b->gpu = ylm_gpu_share(g);
  b->bytes = bytes;
  b->next = g->buffers;
  b->link = &g->buffers;
  if (b->next) b->next->link = &b->next;
  g->buffers = b;
  g->use.buffers++;
  g->use.bytes += bytes;
  *out = b;
  return YLM_OK;
}

void ylm__buffer_drop(ylm_gpu_buffer *b) {
  ylm_gpu *g = b->gpu;
  if (!b->buffer) return;
  g->vkDestroyBuffer(g->device, b->buffer, NULL);
  b->buffer = VK_NULL_HANDLE;
  ylm__memory_give(g, &b->piece);
  *b->link = b->next;
  if (b->next) b->next->link = b->link;
  g->use.buffers--;
  g->use.bytes -= b->bytes;
}

void ylm_gpu_buffer_free(ylm_gpu_buffer *b) {
  if (!b) return;
  ylm__buffer_drop(b);
  ylm_gpu_free(b->gpu);
  ylm_free(b);
}

uint64_t ylm_gpu_buffer_bytes(const ylm_gpu_buffer *b) { return b->bytes; }

ylm_gpu *ylm_gpu_buffer_device(const ylm_gpu_buffer *b) { return b->gpu; }

/* -- copies ---------------------------------------------------------------------- */

void ylm__staging_drop(ylm_gpu *g) {
  ylm__staging *s = &g->staging;
  if (s->buffer) g->vkDestroyBuffer(g->device, s->buffer, NULL);
  if (s->memory) g->vkFreeMemory(g->device, s->memory, NULL);
  *s = (ylm__staging){0};
}

static ylm_status create_staging(ylm_gpu *g, ylm_error *e) {
  ylm__staging *s = &g->staging;
  VkMemoryRequirements need;
  if (s->at) return YLM_OK;
  VkResult r = create(g, YLM__STAGING_BYTES,
                      VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                      &s->buffer, &need);
  if (r == VK_SUCCESS) {
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                 .allocationSize = need.size,
                                 .memoryTypeIndex = g->staging_type};
    r = g->vkAllocateMemory(g->device, &info, NULL, &s->memory);
  }
  if (r == VK_SUCCESS) r = g->vkBindBufferMemory(g->device, s->buffer, s->memory, 0);
  if (r == VK_SUCCESS) r = g->vkMapMemory(g->device, s->memory, 0, VK_WHOLE_SIZE, 0, &s->at);
  if (r == VK_SUCCESS) return YLM_OK;
  ylm__staging_drop(g);
  return ylm__gpu_fail(g, r, "no memory for copies", e);
}

/* Copies within the device's reach, by one submission. */
static ylm_status copy(ylm_gpu *g, VkBuffer from, VkDeviceSize at, VkBuffer to, VkDeviceSize to_at,
                       VkDeviceSize bytes, ylm_error *e) {
  ylm_status s = ylm__gpu_begin(g, e);
  if (s != YLM_OK) return s;
  VkBufferCopy region = {at, to_at, bytes};
  g->vkCmdCopyBuffer(g->command, from, to, 1, &region);
  return ylm__gpu_submit(g, e);
}

static ylm_status check(const ylm_gpu_buffer *b, uint64_t offset, uint64_t bytes, ylm_error *e) {
  ylm_status s = ylm_gpu_state(b->gpu, e);
  if (s == YLM_OK && (offset > b->bytes || bytes > b->bytes - offset))
    s = ylm_fail(e, YLM_EOVERFLOW, "bytes %llu to %llu of a buffer of %llu",
                 (unsigned long long)offset, (unsigned long long)(offset + bytes),
                 (unsigned long long)b->bytes);
  return s;
}

ylm_status ylm_gpu_upload(ylm_gpu_buffer *b, uint64_t offset, uint64_t bytes, const void *data,
                          ylm_error *e) {
  ylm_gpu *g = b->gpu;
  double start = ylm_seconds();
  ylm_status s = check(b, offset, bytes, e);
  if (s != YLM_OK || bytes == 0) return s;
  char *seen = ylm__memory_at(&b->piece);
  if (seen)
    memcpy(seen + offset, data, bytes);
  else
    s = create_staging(g, e);
  for (uint64_t at = 0, part; !seen && s == YLM_OK && at < bytes; at += part) {
    part = bytes - at < YLM__STAGING_BYTES ? bytes - at : YLM__STAGING_BYTES;
    memcpy(g->staging.at, (const char *)data + at, part);
    s = copy(g, g->staging.buffer, 0, b->buffer, offset + at, part, e);
  }
  if (s == YLM_OK) g->use.uploaded += bytes;
  g->use.upload += ylm_seconds() - start;
  return s;
}

ylm_status ylm_gpu_download(const ylm_gpu_buffer *b, uint64_t offset, uint64_t bytes, void *data,
                            ylm_error *e) {
  ylm_gpu *g = b->gpu;
  double start = ylm_seconds();
  ylm_status s = check(b, offset, bytes, e);
  if (s != YLM_OK || bytes == 0) return s;
  const char *seen = ylm__memory_at(&b->piece);
  if (seen)
    memcpy(data, seen + offset, bytes);
  else
    s = create_staging(g, e);
  for (uint64_t at = 0, part; !seen && s == YLM_OK && at < bytes; at += part) {
    part = bytes - at < YLM__STAGING_BYTES ? bytes - at : YLM__STAGING_BYTES;
    s = copy(g, b->buffer, offset + at, g->staging.buffer, 0, part, e);
    if (s == YLM_OK) memcpy((char *)data + at, g->staging.at, part);
  }
  if (s == YLM_OK) g->use.downloaded += bytes;
  g->use.download += ylm_seconds() - start;
  return s;
}

ylm_status ylm_gpu_buffer_from(ylm_gpu *g, uint64_t bytes, const void *data, ylm_gpu_buffer **b,
                               ylm_error *e) {
  ylm_status s = ylm_gpu_buffer_create(g, bytes, b, e);
  if (s == YLM_OK) s = ylm_gpu_upload(*b, 0, bytes, data, e);
  if (s != YLM_OK) {
    ylm_gpu_buffer_free(*b);
    *b = NULL;
  }
  return s;
}

size_t ylm_gpu_rows(const ylm_gpu *g, size_t n, size_t row_bytes, size_t sum_bytes,
                    uint64_t bytes) {
  uint64_t rows = n, most = row_bytes ? g->info.bind_bytes / row_bytes : n;
  if (sum_bytes && rows > bytes / sum_bytes) rows = bytes / sum_bytes;
  if (rows < 64) rows = 64; /* the caller's wish, not the device's limit */
  if (rows > most) rows = most;
  if (rows >= n) return n;
  return (size_t)(rows / 64 * 64);
}
