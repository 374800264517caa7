/*
** gpu.h - what the files of csrc/vulkan share. Private.
**
** Functions of Vulkan are found at run time, those of a device without a detour through the
** loader, and stand in ylm_gpu: g->vkCmdDispatch(...). No other functions are called.
*/
#ifndef YLM_GPU_H
#define YLM_GPU_H

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>

#include "ylm_vulkan.h"

/* -- functions ------------------------------------------------------------- */

/* The loader's own. */
#define YLM_VK_GLOBAL(X)                                                                           \
  X(vkCreateInstance)                                                                              \
  X(vkEnumerateInstanceExtensionProperties)                                                        \
  X(vkEnumerateInstanceLayerProperties) X(vkEnumerateInstanceVersion)

#define YLM_VK_INSTANCE(X)                                                                         \
  X(vkDestroyInstance)                                                                             \
  X(vkEnumeratePhysicalDevices)                                                                    \
  X(vkGetPhysicalDeviceProperties)                                                                 \
  X(vkGetPhysicalDeviceProperties2)                                                                \
  X(vkGetPhysicalDeviceFeatures)                                                                   \
  X(vkGetPhysicalDeviceMemoryProperties)                                                           \
  X(vkGetPhysicalDeviceQueueFamilyProperties)                                                      \
  X(vkCreateDevice)                                                                                \
  X(vkGetDeviceProcAddr)

#define YLM_VK_DEVICE(X)                                                                           \
  X(vkDestroyDevice)                                                                               \
  X(vkGetDeviceQueue)                                                                              \
  X(vkQueueSubmit)                                                                                 \
  X(vkDeviceWaitIdle)                                                                              \
  X(vkAllocateMemory)                                                                              \
  X(vkFreeMemory)                                                                                  \
  X(vkMapMemory)                                                                                   \
  X(vkCreateBuffer)                                                                                \
  X(vkDestroyBuffer)                                                                               \
  X(vkGetBufferMemoryRequirements)                                                                 \
  X(vkBindBufferMemory)                                                                            \
  X(vkCreateShaderModule)                                                                          \
  X(vkDestroyShaderModule)                                                                         \
  X(vkCreatePipelineCache)                                                                         \
  X(vkDestroyPipelineCache)                                                                        \
  X(vkCreatePipelineLayout)                                                                        \
  X(vkDestroyPipelineLayout)                                                                       \
  X(vkCreateComputePipelines)                                                                      \
  X(vkDestroyPipeline)                                                                             \
  X(vkCreateDescriptorSetLayout)                                                                   \
  X(vkDestroyDescriptorSetLayout)                                                                  \
  X(vkCreateDescriptorPool)                                                                        \
  X(vkDestroyDescriptorPool)                                                                       \
  X(vkResetDescriptorPool)                                                                         \
  X(vkAllocateDescriptorSets)                                                                      \
  X(vkUpdateDescriptorSets)                                                                        \
  X(vkCreateCommandPool)                                                                           \
  X(vkDestroyCommandPool)                                                                          \
  X(vkResetCommandPool)                                                                            \
  X(vkAllocateCommandBuffers)                                                                      \
  X(vkBeginCommandBuffer)                                                                          \
  X(vkEndCommandBuffer)                                                                            \
  X(vkCmdBindPipeline)                                                                             \
  X(vkCmdBindDescriptorSets)                                                                       \
  X(vkCmdPushConstants)                                                                            \
  X(vkCmdDispatch)                                                                                 \
  X(vkCmdPipelineBarrier)                                                                          \
  X(vkCmdCopyBuffer)                                                                               \
  X(vkCmdFillBuffer)                                                                               \
  X(vkCreateQueryPool)                                                                             \
  X(vkDestroyQueryPool)                                                                            \
  X(vkGetQueryPoolResults)                                                                         \
  X(vkCmdResetQueryPool)                                                                           \
  X(vkCmdWriteTimestamp)                                                                           \
  X(vkCreateFence)                                                                                 \
  X(vkDestroyFence)                                                                                \
  X(vkResetFences)                                                                                 \
  X(vkWaitForFences)

/* -- the loader and an instance: instance.c ---------------------------------- */

#define X(name) PFN_##name name;
typedef struct ylm__vk {
  void *library;
  VkInstance instance;
  VkDebugUtilsMessengerEXT messenger;
  PFN_vkGetInstanceProcAddr vkGetInstanceProcAddr;
  PFN_vkDestroyDebugUtilsMessengerEXT vkDestroyDebugUtilsMessengerEXT;
  YLM_VK_GLOBAL(X)
  YLM_VK_INSTANCE(X)
  size_t messages;  /* of the validation layer */
  char first[2000]; /* the first of them */
} ylm__vk;

/* Opens libvulkan and an instance; on failure nothing is left to close. */
ylm_status ylm__vk_open(ylm__vk *vk, bool validate, ylm_error *e);
void ylm__vk_close(ylm__vk *vk);
/* Devices of the instance; the caller frees *list with ylm_free. */
ylm_status ylm__vk_devices(const ylm__vk *vk, VkPhysicalDevice **list, uint32_t *n, ylm_error *e);
/* The sentence for a Vulkan result, and the status that it stands for. */
ylm_status ylm__vk_fail(VkResult r, const char *what, ylm_error *e);

/* -- a device: device.c -------------------------------------------------------- */

/* Memory that the host can see, for copies. */
typedef struct ylm__staging {
  VkBuffer buffer;
  VkDeviceMemory memory;
  void *at;
} ylm__staging;
/* Gives back what of it there is. */
void ylm__staging_drop(ylm_gpu *g);

enum {
  YLM__STAGING_BYTES = 8 << 20,
  YLM__SETS = 128, /* dispatches of one submission */
};

struct ylm_gpu {
  ylm__vk vk;
  ylm_gpu_info info;
  size_t users;
  int running;               /* calls of ylm_gpu_run that have not returned */
  bool closed, lost, direct; /* direct: buffers are mapped, there is no staging */
  VkPhysicalDevice physical;
  VkDevice device;
  VkQueue queue;
  uint32_t family;
  double tick; /* seconds of a timestamp's unit */
  uint64_t tick_mask;
  VkPhysicalDeviceMemoryProperties memory;
  VkPhysicalDeviceLimits limits;
  uint32_t memory_type, staging_type;
  VkCommandPool commands;
  VkCommandBuffer command;
  VkFence fence;
  VkQueryPool queries;
  VkDescriptorPool sets;
  VkPipelineCache cache;
  ylm__staging staging;
  struct ylm__block *blocks;      /* memory that buffers are cut from */
  struct ylm_gpu_buffer *buffers; /* all there are */
  struct ylm_gpu_kernel *kernels;
  uint32_t allocations;
  uint64_t quota; /* of all buffers together, for tests; 0: none */
  ylm_gpu_use use;
  YLM_VK_DEVICE(X)
};
#undef X

/* The status and sentence of a failed call; notes that a device was lost. */
ylm_status ylm__gpu_fail(ylm_gpu *g, VkResult r, const char *what, ylm_error *e);
/* Begins g->command; what is recorded sees everything before it. */
ylm_status ylm__gpu_begin(ylm_gpu *g, ylm_error *e);
/* Ends g->command, hands it in and waits. */
ylm_status ylm__gpu_submit(ylm_gpu *g, ylm_error *e);
/* Everything recorded from here on sees what was recorded before. */
void ylm__gpu_barrier(ylm_gpu *g);

/* -- memory: memory.c ------------------------------------------------------------ */

/* A piece of a block of memory. */
typedef struct ylm__piece {
  struct ylm__block *block;
  VkDeviceSize offset, bytes;
} ylm__piece;

ylm_status ylm__memory_take(ylm_gpu *g, const VkMemoryRequirements *need, ylm__piece *p,
                            ylm_error *e);
void ylm__memory_give(ylm_gpu *g, ylm__piece *p);
VkDeviceMemory ylm__memory_of(const ylm__piece *p);
/* Where the host sees the piece, or NULL. */
void *ylm__memory_at(const ylm__piece *p);
/* The type of memory with all the wanted properties, else with the needed ones; UINT32_MAX. */
uint32_t ylm__memory_type(const VkPhysicalDeviceMemoryProperties *m, uint32_t allowed,
                          VkMemoryPropertyFlags needed, VkMemoryPropertyFlags wanted);

/* -- buffers: buffer.c ------------------------------------------------------------ */

struct ylm_gpu_buffer {
  ylm_gpu *gpu;
  ylm_gpu_buffer *next, **link;
  uint64_t bytes;
  VkBuffer buffer; /* null once the device is closed */
  ylm__piece piece;
};

/* Gives back what the buffer has of the device; the object stays. */
void ylm__buffer_drop(ylm_gpu_buffer *b);

/* -- kernels: kernel.c ------------------------------------------------------------- */

/* The shaders that the build embeds: build/obj/vulkan/shaders.c. */
typedef struct ylm__shader {
  const char *name;
  const uint32_t *code;
  size_t bytes;
} ylm__shader;
extern const ylm__shader ylm__shaders[]; /* ends with a NULL name */

struct ylm_gpu_kernel {
  ylm_gpu_kernel *next;
  const ylm__shader *shader;
  int constants, binds;
  uint32_t constant[YLM_GPU_CONSTANTS];
  VkDescriptorSetLayout set;
  VkPipelineLayout layout;
  VkPipeline pipeline;
  bool warm;   /* it has run: the driver has compiled it */
  double rate; /* seconds per unit of cost; 0: not measured yet */
};

void ylm__kernels_drop(ylm_gpu *g);

#endif
