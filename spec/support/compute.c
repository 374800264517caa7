/*
** compute.c - runs a compute shader on the first Vulkan device, for specs.
**
**   compute SHADER.spv X Y Z X Y Z ..
**
** Binding 0 of the shader is a buffer of vec4, one for each three numbers; one invocation a vec4. Prints what it leaves
** there, three numbers a line. Ends with 77 where there is no device.
*/
#include <stdio.h>
#include <stdlib.h>
#include <vulkan/vulkan.h>

static void need(VkResult r, const char *what) {
  if (r == VK_SUCCESS) return;
  fprintf(stderr, "%s: %d\n", what, (int)r);
  exit(r == VK_ERROR_INCOMPATIBLE_DRIVER ? 77 : 1);
}

static uint32_t *read_words(const char *path, size_t *bytes) {
  FILE *f = fopen(path, "rb");
  static uint32_t words[1 << 16];
  *bytes = f ? fread(words, 1, sizeof words, f) : 0;
  if (f) fclose(f);
  return words;
}

static VkPhysicalDevice first_device(void) {
  VkInstance instance;
  VkInstanceCreateInfo in = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  need(vkCreateInstance(&in, NULL, &instance), "instance");
  uint32_t n = 1;
  VkPhysicalDevice device = NULL;
  vkEnumeratePhysicalDevices(instance, &n, &device);
  if (n == 0) exit(77);
  return device;
}

static VkDeviceMemory host_memory(VkPhysicalDevice physical, VkDevice device, VkBuffer buffer) {
  VkMemoryRequirements want;
  VkPhysicalDeviceMemoryProperties have;
  vkGetBufferMemoryRequirements(device, buffer, &want);
  vkGetPhysicalDeviceMemoryProperties(physical, &have);
  VkMemoryPropertyFlags flags =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  uint32_t type = 0;
  while (type < have.memoryTypeCount && (!(want.memoryTypeBits >> type & 1) ||
                                         (have.memoryTypes[type].propertyFlags & flags) != flags))
    type++;
  VkMemoryAllocateInfo ai = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                             .allocationSize = want.size,
                             .memoryTypeIndex = type};
  VkDeviceMemory memory;
  need(vkAllocateMemory(device, &ai, NULL, &memory), "memory");
  need(vkBindBufferMemory(device, buffer, memory, 0), "bind");
  return memory;
}

static VkPipeline pipeline_of(VkDevice device, const char *path, VkPipelineLayout layout) {
  VkShaderModuleCreateInfo mi = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  mi.pCode = read_words(path, &mi.codeSize);
  VkShaderModule module;
  need(vkCreateShaderModule(device, &mi, NULL, &module), "module");
  VkComputePipelineCreateInfo pi = {
      .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
      .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = module,
                .pName = "main"},
      .layout = layout};
  VkPipeline pipeline;
  need(vkCreateComputePipelines(device, NULL, 1, &pi, NULL, &pipeline), "pipeline");
  return pipeline;
}

/* A device with one queue, of family 0, which lavapipe computes by. */
static VkDevice device_of(VkPhysicalDevice physical) {
  VkDevice device;
  float priority = 1;
  VkDeviceQueueCreateInfo qi = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                .queueCount = 1,
                                .pQueuePriorities = &priority};
  VkDeviceCreateInfo di = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                           .queueCreateInfoCount = 1,
                           .pQueueCreateInfos = &qi};
  need(vkCreateDevice(physical, &di, NULL, &device), "device");
  return device;
}

/* The layout of a pipeline with one buffer, and of the set that names it. */
static VkPipelineLayout layout_of(VkDevice device, VkDescriptorSetLayout *sets) {
  VkDescriptorSetLayoutBinding binding = {.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                          .descriptorCount = 1,
                                          .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
  VkDescriptorSetLayoutCreateInfo li = {.sType =
                                            VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                        .bindingCount = 1,
                                        .pBindings = &binding};
  need(vkCreateDescriptorSetLayout(device, &li, NULL, sets), "set layout");
  VkPipelineLayoutCreateInfo pl = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                   .setLayoutCount = 1,
                                   .pSetLayouts = sets};
  VkPipelineLayout layout;
  need(vkCreatePipelineLayout(device, &pl, NULL, &layout), "layout");
  return layout;
}

int main(int argc, char **argv) {
  uint32_t n = (uint32_t)(argc - 2) / 3;
  VkPhysicalDevice physical = first_device();
  VkDevice device = device_of(physical);

  VkBuffer buffer;
  VkBufferCreateInfo bi = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                           .size = 16 * n,
                           .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
  need(vkCreateBuffer(device, &bi, NULL, &buffer), "buffer");
  VkDeviceMemory memory = host_memory(physical, device, buffer);
  float *at;
  need(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, (void **)&at), "map");
  for (uint32_t i = 0; i < 3 * n; i++) at[i / 3 * 4 + i % 3] = strtof(argv[2 + i], NULL);

  VkDescriptorSetLayout sets;
  VkPipelineLayout layout = layout_of(device, &sets);
  VkDescriptorPoolSize size = {.type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .descriptorCount = 1};
  VkDescriptorPoolCreateInfo po = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                   .maxSets = 1,
                                   .poolSizeCount = 1,
                                   .pPoolSizes = &size};
  VkDescriptorPool pool;
  need(vkCreateDescriptorPool(device, &po, NULL, &pool), "pool");
  VkDescriptorSetAllocateInfo si = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                    .descriptorPool = pool,
                                    .descriptorSetCount = 1,
                                    .pSetLayouts = &sets};
  VkDescriptorSet set;
  need(vkAllocateDescriptorSets(device, &si, &set), "set");
  VkDescriptorBufferInfo whole = {.buffer = buffer, .range = VK_WHOLE_SIZE};
  VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                .dstSet = set,
                                .descriptorCount = 1,
                                .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                .pBufferInfo = &whole};
  vkUpdateDescriptorSets(device, 1, &write, 0, NULL);

  VkCommandPoolCreateInfo cp = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  VkCommandPool commands;
  need(vkCreateCommandPool(device, &cp, NULL, &commands), "commands");
  VkCommandBufferAllocateInfo ca = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                    .commandPool = commands,
                                    .commandBufferCount = 1};
  VkCommandBuffer work;
  need(vkAllocateCommandBuffers(device, &ca, &work), "command buffer");
  VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  need(vkBeginCommandBuffer(work, &begin), "begin");
  vkCmdBindPipeline(work, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_of(device, argv[1], layout));
  vkCmdBindDescriptorSets(work, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, NULL);
  vkCmdDispatch(work, n, 1, 1);
  need(vkEndCommandBuffer(work), "end");
  VkQueue queue;
  vkGetDeviceQueue(device, 0, 0, &queue);
  VkSubmitInfo submit = {
      .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &work};
  need(vkQueueSubmit(queue, 1, &submit, NULL), "submit");
  need(vkQueueWaitIdle(queue), "wait");
  for (uint32_t i = 0; i < n; i++)
    printf("%.9g %.9g %.9g\n", (double)at[4 * i], (double)at[4 * i + 1], (double)at[4 * i + 2]);
  return 0;
}
