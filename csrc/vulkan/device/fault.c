/* fault.c - a driver that fails when asked to, for specs of what happens then. */
#include <string.h>

#include "gpu.h"

/* Functions that may fail. */
#define FALLIBLE(X)                                                                                \
  X(vkAllocateMemory)                                                                              \
  X(vkMapMemory)                                                                                   \
  X(vkCreateBuffer)                                                                                \
  X(vkBindBufferMemory)                                                                            \
  X(vkCreateShaderModule)                                                                          \
  X(vkCreatePipelineLayout)                                                                        \
  X(vkCreateComputePipelines)                                                                      \
  X(vkCreateDescriptorSetLayout)                                                                   \
  X(vkResetDescriptorPool)                                                                         \
  X(vkAllocateDescriptorSets)                                                                      \
  X(vkResetCommandPool)                                                                            \
  X(vkBeginCommandBuffer)                                                                          \
  X(vkEndCommandBuffer)                                                                            \
  X(vkResetFences)                                                                                 \
  X(vkQueueSubmit)                                                                                 \
  X(vkWaitForFences)                                                                               \
  X(vkGetQueryPoolResults)

/* Stand in for any of them: callers remove arguments, which are not read. */
static VkResult out_of_memory(void) { return VK_ERROR_OUT_OF_DEVICE_MEMORY; }
static VkResult lost(void) { return VK_ERROR_DEVICE_LOST; }
static VkResult unknown(void) { return VK_ERROR_UNKNOWN; }

static PFN_vkVoidFunction stub(ylm_status s) {
  return s == YLM_ENOMEM    ? (PFN_vkVoidFunction)out_of_memory
         : s == YLM_EDEVICE ? (PFN_vkVoidFunction)lost
                            : (PFN_vkVoidFunction)unknown;
}

const char *ylm_gpu_break(ylm_gpu *g, size_t i, ylm_status s) {
#define X(name) #name,
  static const char *const names[] = {FALLIBLE(X)};
#undef X
  if (i >= sizeof names / sizeof *names || ylm_gpu_state(g, NULL) == YLM_ECLOSED) return NULL;
  PFN_vkVoidFunction f = s == YLM_OK ? g->vk.vkGetDeviceProcAddr(g->device, names[i]) : stub(s);
#define X(name)                                                                                    \
  if (strcmp(names[i], #name) == 0) g->name = (PFN_##name)f;
  FALLIBLE(X)
#undef X
  return names[i];
}
