/*
** memory.c - the device's memory: buffers are cut from blocks, long ones have their own.
**
** A driver may allow no more than 4096 allocations, and each is slow. Within a block the
** pieces in use stand in a list ordered by offset; the first gap that fits is taken.
*/
#include "../calibration.h"
#include "gpu.h"

typedef struct used {
  struct used *next;
  VkDeviceSize offset, bytes;
} used;

struct ylm__block {
  struct ylm__block *next;
  VkDeviceMemory memory;
  VkDeviceSize bytes;
  void *at; /* where the host sees it, or NULL */
  used *used;
};

uint32_t ylm__memory_type(const VkPhysicalDeviceMemoryProperties *m, uint32_t allowed,
                          VkMemoryPropertyFlags needed, VkMemoryPropertyFlags wanted) {
  uint32_t best = UINT32_MAX;
  int most = -1;
  for (uint32_t i = 0; i < m->memoryTypeCount; i++) {
    VkMemoryPropertyFlags have = m->memoryTypes[i].propertyFlags;
    if (!(allowed >> i & 1) || (have & needed) != needed) continue;
    int fit = __builtin_popcount(have & wanted);
    if (fit > most) most = fit, best = i;
  }
  return best;
}

VkDeviceMemory ylm__memory_of(const ylm__piece *p) { return p->block->memory; }

void *ylm__memory_at(const ylm__piece *p) {
  return p->block && p->block->at ? (char *)p->block->at + p->offset : NULL;
}

/* The place after which a gap of that size begins, or NULL; *offset is where it begins. */
static used **gap(struct ylm__block *b, const VkMemoryRequirements *need, VkDeviceSize *offset) {
  VkDeviceSize at = 0;
  for (used **u = &b->used;; u = &(*u)->next) {
    VkDeviceSize begin = (at + need->alignment - 1) / need->alignment * need->alignment;
    VkDeviceSize end = *u ? (*u)->offset : b->bytes;
    if (begin <= end && end - begin >= need->size) {
      *offset = begin;
      return u;
    }
    if (!*u) return NULL;
    at = (*u)->offset + (*u)->bytes;
  }
}

static ylm_status create_block(ylm_gpu *g, VkDeviceSize bytes, uint32_t type,
                               struct ylm__block **out, ylm_error *e) {
  struct ylm__block *b = ylm_alloc_zero(1, sizeof *b);
  if (!b) return ylm_no_memory(e);
  VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                               .allocationSize = bytes,
                               .memoryTypeIndex = type};
  b->bytes = bytes;
  VkResult r = g->vkAllocateMemory(g->device, &info, NULL, &b->memory);
  if (r == VK_SUCCESS && g->direct) {
    r = g->vkMapMemory(g->device, b->memory, 0, VK_WHOLE_SIZE, 0, &b->at);
    if (r != VK_SUCCESS) g->vkFreeMemory(g->device, b->memory, NULL);
  }
  if (r != VK_SUCCESS) {
    ylm_free(b);
    ylm_status s = ylm__gpu_fail(g, r, "no memory", e);
    if (s == YLM_ENOMEM)
      ylm_fail(e, s, "'%s' has no %.1f MiB of memory left: close arrays, lights or grids there",
               g->info.name, (double)bytes / 1048576);
    return s;
  }
  g->allocations++;
  b->next = g->blocks;
  g->blocks = b;
  *out = b;
  return YLM_OK;
}

ylm_status ylm__memory_take(ylm_gpu *g, const VkMemoryRequirements *need, ylm__piece *p,
                            ylm_error *e) {
  if (!(need->memoryTypeBits >> g->memory_type & 1))
    return ylm_fail(e, YLM_EDEVICE, "'%s' does not keep buffers in its own memory", g->info.name);
  used *mine = ylm_alloc(1, sizeof *mine), **place = NULL;
  if (!mine) return ylm_no_memory(e);
  struct ylm__block *b = NULL;
  bool own = need->size > GPU_BLOCK_BYTES / 4;
  if (!own)
    for (b = g->blocks; b && !place; b = place ? b : b->next) place = gap(b, need, &mine->offset);
  if (!place) {
    ylm_status s = create_block(g, own ? need->size : GPU_BLOCK_BYTES, g->memory_type, &b, e);
    if (s == YLM_ENOMEM && !own) s = create_block(g, need->size, g->memory_type, &b, e);
    if (s != YLM_OK) {
      ylm_free(mine);
      return s;
    }
    place = &b->used;
    mine->offset = 0;
  }
  mine->bytes = need->size;
  mine->next = *place;
  *place = mine;
  *p = (ylm__piece){b, mine->offset, need->size};
  return YLM_OK;
}

void ylm__memory_give(ylm_gpu *g, ylm__piece *p) {
  struct ylm__block *b = p->block;
  if (!b) return;
  for (used **u = &b->used; *u; u = &(*u)->next)
    if ((*u)->offset == p->offset) {
      used *gone = *u;
      *u = gone->next;
      ylm_free(gone);
      break;
    }
  p->block = NULL;
  if (b->used) return;
  struct ylm__block **link = &g->blocks;
  while (*link != b) link = &(*link)->next;
  *link = b->next;
  g->vkFreeMemory(g->device, b->memory, NULL);
  g->allocations--;
  ylm_free(b);
}
