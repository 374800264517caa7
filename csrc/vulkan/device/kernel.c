/* kernel.c - pipelines from the SPIR-V that the build has embedded. */
#include "gpu.h"

#include <string.h>

enum { OP_CAPABILITY = 17, OP_DECORATE = 71, FLOAT64 = 10, INT64 = 11, BINDING = 33 };

/* Requirements that a module declares. */
typedef struct needs {
  int binds;
  bool float64, int64;
} needs;

static needs read_needs(const ylm__shader *s) {
  needs n = {0, false, false};
  size_t words = s->bytes / 4;
  for (size_t at = 5; at < words;) {
    uint32_t length = s->code[at] >> 16, op = s->code[at] & 0xffff;
    if (length == 0 || length > words - at) break;
    if (op == OP_CAPABILITY && s->code[at + 1] == FLOAT64) n.float64 = true;
    if (op == OP_CAPABILITY && s->code[at + 1] == INT64) n.int64 = true;
    if (op == OP_DECORATE && length == 4 && s->code[at + 2] == BINDING &&
        (int)s->code[at + 3] >= n.binds)
      n.binds = (int)s->code[at + 3] + 1;
    at += length;
  }
  return n;
}

static const ylm__shader *find(const char *name) {
  for (const ylm__shader *s = ylm__shaders; s->name; s++)
    if (strcmp(s->name, name) == 0) return s;
  return NULL;
}

static void drop(ylm_gpu *g, ylm_gpu_kernel *k) {
  if (k->pipeline) g->vkDestroyPipeline(g->device, k->pipeline, NULL);
  if (k->layout) g->vkDestroyPipelineLayout(g->device, k->layout, NULL);
  if (k->set) g->vkDestroyDescriptorSetLayout(g->device, k->set, NULL);
  ylm_free(k);
}

void ylm__kernels_drop(ylm_gpu *g) {
  while (g->kernels) {
    ylm_gpu_kernel *k = g->kernels;
    g->kernels = k->next;
    drop(g, k);
  }
}

static VkResult create_layout(ylm_gpu *g, ylm_gpu_kernel *k) {
  VkDescriptorSetLayoutBinding binding[YLM_GPU_BINDS];
  for (int i = 0; i < k->binds; i++)
    binding[i] = (VkDescriptorSetLayoutBinding){.binding = (uint32_t)i,
                                                .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                                .descriptorCount = 1,
                                                .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
  VkDescriptorSetLayoutCreateInfo set = {.sType =
                                             VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                         .bindingCount = (uint32_t)k->binds,
                                         .pBindings = binding};
  VkPushConstantRange push = {VK_SHADER_STAGE_COMPUTE_BIT, 0, 4 + YLM_GPU_PUSH_BYTES};
  VkResult r = g->vkCreateDescriptorSetLayout(g->device, &set, NULL, &k->set);
  if (r != VK_SUCCESS) return r;
  VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                       .setLayoutCount = 1,
                                       .pSetLayouts = &k->set,
                                       .pushConstantRangeCount = 1,
                                       .pPushConstantRanges = &push};
  return g->vkCreatePipelineLayout(g->device, &layout, NULL, &k->layout);
}

static VkResult create_pipeline(ylm_gpu *g, ylm_gpu_kernel *k) {
  VkSpecializationMapEntry entry[YLM_GPU_CONSTANTS];
  for (int i = 0; i < k->constants; i++)
    entry[i] = (VkSpecializationMapEntry){(uint32_t)i, (uint32_t)i * 4, 4};
  VkSpecializationInfo special = {(uint32_t)k->constants, entry, (size_t)k->constants * 4,
                                  k->constant};
  VkShaderModuleCreateInfo code = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                   .codeSize = k->shader->bytes,
                                   .pCode = k->shader->code};
  VkShaderModule module;
  VkResult r = g->vkCreateShaderModule(g->device, &code, NULL, &module);
  if (r != VK_SUCCESS) return r;
  VkComputePipelineCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
      .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = module,
                .pName = "main",
                .pSpecializationInfo = &special},
      .layout = k->layout};
  r = g->vkCreateComputePipelines(g->device, g->cache, 1, &info, NULL, &k->pipeline);
  g->vkDestroyShaderModule(g->device, module, NULL);
  return r;
}

static ylm_gpu_kernel *found(ylm_gpu *g, const ylm__shader *s, int constants,
                             const uint32_t *constant) {
  for (ylm_gpu_kernel *k = g->kernels; k; k = k->next)
    if (k->shader == s && k->constants == constants &&
        memcmp(k->constant, constant, (size_t)constants * 4) == 0)
      return k;
  return NULL;
}

/* YLM_OK if the device can run it. */
static ylm_status check(const ylm_gpu *g, const char *name, const needs *n, uint32_t group,
                        ylm_error *e) {
  const ylm_gpu_info *i = &g->info;
  if ((n->float64 && !i->float64) || (n->int64 && !i->int64))
    return ylm_fail(e, YLM_EMISSING, "'%s' does not compute in %s", i->name,
                    n->float64 && !i->float64 ? "double" : "64-bit integers");
  if (n->binds > (int)i->binds || n->binds > YLM_GPU_BINDS)
    return ylm_fail(e, YLM_EMISSING, "'%s' gives a kernel %u buffers, %s needs %d", i->name,
                    i->binds, name, n->binds);
  if (group < 1 || group > i->group_size)
    return ylm_fail(e, YLM_ELIMIT, "groups of '%s' have 1 to %u invocations, not %u", i->name,
                    i->group_size, group);
  return YLM_OK;
}

ylm_status ylm_gpu_kernel_get(ylm_gpu *g, const char *name, int constants, const uint32_t *constant,
                              ylm_gpu_kernel **out, ylm_error *e) {
  *out = NULL;
  ylm_status s = ylm_gpu_state(g, e);
  if (s != YLM_OK) return s;
  const ylm__shader *shader = find(name);
  if (!shader) return ylm_fail(e, YLM_EINVAL, "there is no kernel '%s'", name);
  if (constants < 1 || constants > YLM_GPU_CONSTANTS)
    return ylm_fail(e, YLM_EINVAL, "%s: 1 to %d constants, the group's size first", name,
                    YLM_GPU_CONSTANTS);
  *out = found(g, shader, constants, constant);
  if (*out) return YLM_OK;
  needs n = read_needs(shader);
  s = check(g, name, &n, constant[0], e);
  if (s != YLM_OK) return s;
  ylm_gpu_kernel *k = ylm_alloc_zero(1, sizeof *k);
  if (!k) return ylm_no_memory(e);
  k->shader = shader;
  k->binds = n.binds;
  k->constants = constants;
  memcpy(k->constant, constant, (size_t)constants * 4);
  VkResult r = create_layout(g, k);
  if (r == VK_SUCCESS) r = create_pipeline(g, k);
  if (r != VK_SUCCESS) {
    drop(g, k);
    return ylm__gpu_fail(g, r, "the driver does not take a kernel", e);
  }
  g->use.pipelines++;
  k->next = g->kernels;
  g->kernels = k;
  *out = k;
  return YLM_OK;
}
