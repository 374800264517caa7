/* device.c - listing, opening and closing devices; one submission at a time. */
#include "gpu.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#define LEAST_BINDS 4

const char *ylm_gpu_type_name(ylm_gpu_type t) {
  static const char *const names[] = {"other", "integrated", "discrete", "virtual", "cpu"};
  return (int)t >= 0 && t <= YLM_GPU_CPU ? names[t] : "other";
}

/* -- what there is ------------------------------------------------------------- */

/* The queue family to compute on: UINT32_MAX if there is none. */
static uint32_t family_of(const ylm__vk *vk, VkPhysicalDevice d, uint32_t *timestamp_bits) {
  VkQueueFamilyProperties list[32];
  uint32_t n = 32;
  vk->vkGetPhysicalDeviceQueueFamilyProperties(d, &n, list);
  uint32_t best = UINT32_MAX;
  for (uint32_t i = 0; i < n; i++) {
    if (!(list[i].queueFlags & VK_QUEUE_COMPUTE_BIT) || list[i].queueCount == 0) continue;
    if (best == UINT32_MAX || (!list[best].timestampValidBits && list[i].timestampValidBits))
      best = i;
  }
  *timestamp_bits = best == UINT32_MAX ? 0 : list[best].timestampValidBits;
  return best;
}

static ylm_gpu_type type_of(VkPhysicalDeviceType t) {
  switch (t) {
  case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return YLM_GPU_INTEGRATED;
  case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return YLM_GPU_DISCRETE;
  case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return YLM_GPU_VIRTUAL;
  case VK_PHYSICAL_DEVICE_TYPE_CPU: return YLM_GPU_CPU;
  default: return YLM_GPU_OTHER;
  }
}

static void fill_info(const ylm__vk *vk, VkPhysicalDevice d, ylm_gpu_info *info) {
  VkPhysicalDeviceProperties p;
  VkPhysicalDeviceFeatures f;
  VkPhysicalDeviceMemoryProperties m;
  uint32_t bits;
  memset(info, 0, sizeof *info);
  vk->vkGetPhysicalDeviceProperties(d, &p);
  vk->vkGetPhysicalDeviceFeatures(d, &f);
  vk->vkGetPhysicalDeviceMemoryProperties(d, &m);
  snprintf(info->name, sizeof info->name, "%s", p.deviceName);
  info->type = type_of(p.deviceType);
  info->vulkan[0] = VK_API_VERSION_MAJOR(p.apiVersion);
  info->vulkan[1] = VK_API_VERSION_MINOR(p.apiVersion);
  info->vulkan[2] = VK_API_VERSION_PATCH(p.apiVersion);
  info->usable = family_of(vk, d, &bits) != UINT32_MAX && p.apiVersion >= VK_API_VERSION_1_2;
  info->float64 = f.shaderFloat64;
  info->int64 = f.shaderInt64;
  info->timestamps = bits > 0 && p.limits.timestampPeriod > 0;
  info->binds = p.limits.maxPerStageDescriptorStorageBuffers;
  if (info->binds > p.limits.maxDescriptorSetStorageBuffers)
    info->binds = p.limits.maxDescriptorSetStorageBuffers;
  if (info->binds > YLM_GPU_BINDS) info->binds = YLM_GPU_BINDS;
  info->group_size = p.limits.maxComputeWorkGroupInvocations;
  if (info->group_size > p.limits.maxComputeWorkGroupSize[0])
    info->group_size = p.limits.maxComputeWorkGroupSize[0];
  info->groups = p.limits.maxComputeWorkGroupCount[0];
  info->shared_bytes = p.limits.maxComputeSharedMemorySize;
  info->bind_bytes = p.limits.maxStorageBufferRange / 256 * 256;
  for (uint32_t i = 0; i < m.memoryHeapCount; i++)
    if (m.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT &&
        m.memoryHeaps[i].size > info->memory_bytes)
      info->memory_bytes = m.memoryHeaps[i].size;
  info->allocation_bytes = info->memory_bytes;
  if (!info->usable) return;
  VkPhysicalDeviceDriverProperties driver = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceMaintenance3Properties three = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES, .pNext = &driver};
  VkPhysicalDeviceSubgroupProperties subgroup = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES, .pNext = &three};
  VkPhysicalDeviceProperties2 two = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                     .pNext = &subgroup};
  vk->vkGetPhysicalDeviceProperties2(d, &two);
  info->subgroup = subgroup.subgroupSize;
  if (info->allocation_bytes > three.maxMemoryAllocationSize)
    info->allocation_bytes = three.maxMemoryAllocationSize;
  snprintf(info->driver, sizeof info->driver, "%.120s %.120s", driver.driverName,
           driver.driverInfo);
}

ylm_status ylm_gpu_list(ylm_gpu_info **list, size_t *n, ylm_error *e) {
  ylm__vk vk;
  VkPhysicalDevice *devices = NULL;
  uint32_t count = 0;
  *list = NULL;
  *n = 0;
  ylm_status s = ylm__vk_open(&vk, false, e);
  if (s != YLM_OK) return s;
  s = ylm__vk_devices(&vk, &devices, &count, e);
  if (s == YLM_OK) *list = ylm_alloc(count, sizeof **list);
  if (s == YLM_OK && !*list) s = ylm_no_memory(e);
  for (uint32_t i = 0; s == YLM_OK && i < count; i++) fill_info(&vk, devices[i], &(*list)[i]);
  if (s == YLM_OK) *n = count;
  ylm_free(devices);
  ylm__vk_close(&vk);
  return s;
}

/* -- choosing one -------------------------------------------------------------- */

static bool holds(const char *text, const char *part) {
  size_t n = strlen(part);
  for (; *text; text++) {
    size_t i = 0;
    while (i < n && tolower((unsigned char)text[i]) == tolower((unsigned char)part[i])) i++;
    if (i == n) return true;
  }
  return n == 0;
}

static int rank(ylm_gpu_type t) {
  static const int ranks[] = {1, 3, 4, 2, 0};
  return ranks[t];
}

/* The device that the options name, or the best that is usable. */
static ylm_status choose(ylm_gpu *g, const ylm_gpu_options *o, ylm_error *e) {
  VkPhysicalDevice *list = NULL;
  uint32_t n = 0;
  ylm_gpu_info info;
  char names[200] = "";
  ylm_status s = ylm__vk_devices(&g->vk, &list, &n, e);
  if (s != YLM_OK) return s;
  if (o->index < -1 || (o->index >= 0 && (uint32_t)o->index >= n))
    s = ylm_fail(e, YLM_ERANGE, "there are %u devices, no number %lld", n, o->index + 1ll);
  for (uint32_t i = 0; s == YLM_OK && i < n; i++) {
    if (o->index >= 0 && (uint32_t)o->index != i) continue;
    fill_info(&g->vk, list[i], &info);
    size_t used = strlen(names);
    snprintf(names + used, sizeof names - used, "%s'%.80s'", used ? ", " : "", info.name);
    if (o->index < 0 && o->name && !holds(info.name, o->name)) continue;
    if (o->index < 0 && !info.usable) continue;
    if (g->physical && rank(info.type) <= rank(g->info.type)) continue;
    g->physical = list[i];
    g->info = info;
  }
  ylm_free(list);
  if (s != YLM_OK) return s;
  if (!g->physical)
    return ylm_fail(e, YLM_EMISSING, "no usable Vulkan device%s%s; there is %s",
                    o->name ? " is called " : "", o->name ? o->name : "", names);
  if (!g->info.usable || g->info.binds < LEAST_BINDS)
    return ylm_fail(e, YLM_EMISSING,
                    "'%s' has Vulkan %u.%u, or no queue that computes: 1.2 is needed", g->info.name,
                    g->info.vulkan[0], g->info.vulkan[1]);
  return YLM_OK;
}

/* -- opening ------------------------------------------------------------------- */

static ylm_status create_device(ylm_gpu *g, ylm_error *e) {
  VkPhysicalDeviceProperties p;
  uint32_t bits;
  g->vk.vkGetPhysicalDeviceProperties(g->physical, &p);
  g->vk.vkGetPhysicalDeviceMemoryProperties(g->physical, &g->memory);
  g->limits = p.limits;
  g->family = family_of(&g->vk, g->physical, &bits);
  g->tick = (double)p.limits.timestampPeriod * 1e-9;
  g->tick_mask = bits >= 64 ? UINT64_MAX : ((uint64_t)1 << bits) - 1;
  float priority = 1;
  VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                   .queueFamilyIndex = g->family,
                                   .queueCount = 1,
                                   .pQueuePriorities = &priority};
  VkPhysicalDeviceFeatures features = {.shaderFloat64 = g->info.float64,
                                       .shaderInt64 = g->info.int64};
  VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                             .queueCreateInfoCount = 1,
                             .pQueueCreateInfos = &queue,
                             .pEnabledFeatures = &features};
  VkResult r = g->vk.vkCreateDevice(g->physical, &info, NULL, &g->device);
  if (r != VK_SUCCESS) return ylm__vk_fail(r, "the device does not open", e);
#define X(name)                                                                                    \
  g->name = (PFN_##name)g->vk.vkGetDeviceProcAddr(g->device, #name);                               \
  if (!g->name) return ylm_fail(e, YLM_EMISSING, "the Vulkan driver has no %s", #name);
  YLM_VK_DEVICE(X)
#undef X
  g->vkGetDeviceQueue(g->device, g->family, 0, &g->queue);
  return YLM_OK;
}

/* Command buffer, fence, timestamps, descriptor sets, pipeline cache. */
static ylm_status create_parts(ylm_gpu *g, ylm_error *e) {
  VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                  .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                  .queueFamilyIndex = g->family};
  VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkPipelineCacheCreateInfo cache = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, YLM__SETS * YLM_GPU_BINDS};
  VkDescriptorPoolCreateInfo sets = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                     .maxSets = YLM__SETS,
                                     .poolSizeCount = 1,
                                     .pPoolSizes = &size};
  VkQueryPoolCreateInfo queries = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                   .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                   .queryCount = 2 * YLM__SETS};
  VkResult r = g->vkCreateCommandPool(g->device, &pool, NULL, &g->commands);
  if (r == VK_SUCCESS) r = g->vkCreateFence(g->device, &fence, NULL, &g->fence);
  if (r == VK_SUCCESS) r = g->vkCreatePipelineCache(g->device, &cache, NULL, &g->cache);
  if (r == VK_SUCCESS) r = g->vkCreateDescriptorPool(g->device, &sets, NULL, &g->sets);
  if (r == VK_SUCCESS && g->info.timestamps)
    r = g->vkCreateQueryPool(g->device, &queries, NULL, &g->queries);
  if (r != VK_SUCCESS) return ylm__vk_fail(r, "the device does not open", e);
  VkCommandBufferAllocateInfo command = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                         .commandPool = g->commands,
                                         .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                         .commandBufferCount = 1};
  r = g->vkAllocateCommandBuffers(g->device, &command, &g->command);
  return r == VK_SUCCESS ? YLM_OK : ylm__vk_fail(r, "the device does not open", e);
}

/* Which memory buffers live in, and whether the host works in it without staging. */
static ylm_status choose_memory(ylm_gpu *g, bool staging, ylm_error *e) {
  const VkMemoryPropertyFlags seen =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  const VkMemoryPropertyFlags cached = seen | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  const VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  bool shared = g->info.type == YLM_GPU_CPU || g->info.type == YLM_GPU_INTEGRATED;
  g->staging_type = ylm__memory_type(&g->memory, UINT32_MAX, seen, cached);
  g->memory_type = ylm__memory_type(&g->memory, UINT32_MAX, 0, shared ? cached | local : local);
  if (g->staging_type == UINT32_MAX || g->memory_type == UINT32_MAX)
    return ylm_fail(e, YLM_EMISSING, "'%s' has no memory that can be used", g->info.name);
  VkMemoryPropertyFlags have = g->memory.memoryTypes[g->memory_type].propertyFlags;
  g->direct = shared && !staging && (have & cached) == cached;
  return YLM_OK;
}

static bool asked_to_validate(const ylm_gpu_options *o) {
  const char *word = getenv("YLM_VULKAN_VALIDATION");
  return o->validate || (word && strcmp(word, "1") == 0);
}

ylm_status ylm_gpu_open(const ylm_gpu_options *o, ylm_gpu **out, ylm_error *e) {
  *out = NULL;
  ylm_gpu *g = ylm_alloc_zero(1, sizeof *g);
  if (!g) return ylm_no_memory(e);
  g->users = 1;
  ylm_status s = ylm__vk_open(&g->vk, asked_to_validate(o), e);
  if (s == YLM_OK) s = choose(g, o, e);
  if (s == YLM_OK) s = create_device(g, e);
  if (s == YLM_OK) s = create_parts(g, e);
  if (s == YLM_OK) s = choose_memory(g, o->staging, e);
  if (s != YLM_OK) {
    ylm_gpu_free(g);
    return s;
  }
  *out = g;
  return YLM_OK;
}

/* -- closing ------------------------------------------------------------------- */

static void drop_parts(ylm_gpu *g) {
  while (g->buffers) ylm__buffer_drop(g->buffers);
  ylm__kernels_drop(g);
  ylm__staging_drop(g);
  if (g->queries) g->vkDestroyQueryPool(g->device, g->queries, NULL);
  if (g->sets) g->vkDestroyDescriptorPool(g->device, g->sets, NULL);
  if (g->cache) g->vkDestroyPipelineCache(g->device, g->cache, NULL);
  if (g->fence) g->vkDestroyFence(g->device, g->fence, NULL);
  if (g->commands) g->vkDestroyCommandPool(g->device, g->commands, NULL);
}

ylm_status ylm_gpu_close(ylm_gpu *g) {
  if (!g || g->closed) return YLM_OK;
  if (g->running) return YLM_EBUSY;
  g->closed = true;
  if (g->device) {
    /* A driver without even this one was refused when the device was opened. */
    PFN_vkDestroyDevice destroy =
        (PFN_vkDestroyDevice)g->vk.vkGetDeviceProcAddr(g->device, "vkDestroyDevice");
    if (g->vkWaitForFences) { /* all functions were found */
      g->vkDeviceWaitIdle(g->device);
      drop_parts(g);
    }
    if (destroy) destroy(g->device, NULL);
    g->device = NULL;
  }
  ylm__vk_close(&g->vk);
  return YLM_OK;
}

ylm_gpu *ylm_gpu_share(ylm_gpu *g) {
  g->users++;
  return g;
}

void ylm_gpu_free(ylm_gpu *g) {
  if (!g || --g->users > 0) return;
  ylm_gpu_close(g);
  ylm_free(g);
}

const ylm_gpu_info *ylm_gpu_about(const ylm_gpu *g) { return &g->info; }

ylm_status ylm_gpu_state(const ylm_gpu *g, ylm_error *e) {
  if (g->closed) return ylm_fail(e, YLM_ECLOSED, "the device has been closed");
  if (g->lost)
    return ylm_fail(e, YLM_EDEVICE, "the device '%s' was lost; open it again", g->info.name);
  return YLM_OK;
}

void ylm_gpu_lose(ylm_gpu *g) { g->lost = true; }

void ylm_gpu_shrink(ylm_gpu *g, uint64_t memory_bytes, uint64_t bind_bytes, uint32_t binds,
                    bool narrow) {
  if (memory_bytes) g->info.memory_bytes = g->quota = memory_bytes;
  if (bind_bytes) g->info.bind_bytes = bind_bytes / 256 * 256;
  if (binds) g->info.binds = binds;
  if (narrow) g->info.float64 = false;
}

void ylm_gpu_blunder(ylm_gpu *g) {
  if (ylm_gpu_state(g, NULL) == YLM_OK && g->vk.messenger) ylm__gpu_barrier(g); /* not recording */
}

size_t ylm_gpu_messages(const ylm_gpu *g, const char **first) {
  if (first) *first = g->vk.first;
  return g->vk.messages;
}

ylm_gpu_use ylm_gpu_used(const ylm_gpu *g) { return g->use; }

/* -- submissions ----------------------------------------------------------------- */

ylm_status ylm__gpu_fail(ylm_gpu *g, VkResult r, const char *what, ylm_error *e) {
  if (r == VK_ERROR_DEVICE_LOST) {
    g->lost = true;
    return ylm_gpu_state(g, e);
  }
  return ylm__vk_fail(r, what, e);
}

void ylm__gpu_barrier(ylm_gpu *g) {
  const VkPipelineStageFlags all = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT |
                                   VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_HOST_BIT;
  VkMemoryBarrier b = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                       .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                       .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT};
  g->vkCmdPipelineBarrier(g->command, all, all, 0, 1, &b, 0, NULL, 0, NULL);
}

ylm_status ylm__gpu_begin(ylm_gpu *g, ylm_error *e) {
  VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                    .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  VkResult r = g->vkResetCommandPool(g->device, g->commands, 0);
  if (r == VK_SUCCESS) r = g->vkBeginCommandBuffer(g->command, &begin);
  if (r != VK_SUCCESS) return ylm__gpu_fail(g, r, "no commands", e);
  ylm__gpu_barrier(g);
  return YLM_OK;
}

ylm_status ylm__gpu_submit(ylm_gpu *g, ylm_error *e) {
  VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                         .commandBufferCount = 1,
                         .pCommandBuffers = &g->command};
  ylm__gpu_barrier(g); /* the host sees what was written */
  VkResult r = g->vkEndCommandBuffer(g->command);
  if (r == VK_SUCCESS) r = g->vkResetFences(g->device, 1, &g->fence);
  if (r == VK_SUCCESS) r = g->vkQueueSubmit(g->queue, 1, &submit, g->fence);
  if (r == VK_SUCCESS) {
    r = g->vkWaitForFences(g->device, 1, &g->fence, VK_TRUE, UINT64_MAX);
    /* what has been submitted uses the commands and the fence until it ends */
    if (r != VK_SUCCESS && g->vkDeviceWaitIdle(g->device) != VK_SUCCESS) r = VK_ERROR_DEVICE_LOST;
  }
  g->use.submissions++;
  return r == VK_SUCCESS ? YLM_OK : ylm__gpu_fail(g, r, "work was not done", e);
}
