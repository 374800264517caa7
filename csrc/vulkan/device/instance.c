/* instance.c - libvulkan at run time, an instance, and what the validation layer says. */
#include "gpu.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#define VALIDATION "VK_LAYER_KHRONOS_validation"
#define INSTALL "install a Vulkan driver (Debian: mesa-vulkan-drivers, or the graphics card's own)"

static const char *result_name(VkResult r) {
  switch (r) {
  case VK_ERROR_OUT_OF_HOST_MEMORY: return "out of memory";
  case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "out of the device's memory";
  case VK_ERROR_INITIALIZATION_FAILED: return "initialisation failed";
  case VK_ERROR_DEVICE_LOST: return "the device was lost";
  case VK_ERROR_LAYER_NOT_PRESENT: return "a layer is missing";
  case VK_ERROR_EXTENSION_NOT_PRESENT: return "an extension is missing";
  case VK_ERROR_FEATURE_NOT_PRESENT: return "a feature is missing";
  case VK_ERROR_INCOMPATIBLE_DRIVER: return "no driver that fits";
  case VK_ERROR_TOO_MANY_OBJECTS: return "too many objects";
  default: return "the driver failed";
  }
}

ylm_status ylm__vk_fail(VkResult r, const char *what, ylm_error *e) {
  ylm_status s = YLM_EDEVICE;
  if (r == VK_ERROR_OUT_OF_HOST_MEMORY || r == VK_ERROR_OUT_OF_DEVICE_MEMORY) s = YLM_ENOMEM;
  if (r == VK_ERROR_TOO_MANY_OBJECTS) s = YLM_ELIMIT;
  if (r == VK_ERROR_INCOMPATIBLE_DRIVER || r == VK_ERROR_LAYER_NOT_PRESENT ||
      r == VK_ERROR_EXTENSION_NOT_PRESENT || r == VK_ERROR_FEATURE_NOT_PRESENT)
    s = YLM_EMISSING;
  return ylm_fail(e, s, "Vulkan: %s: %s (VkResult %d)", what, result_name(r), (int)r);
}

/* Opens the library; the environment may name another one. */
static ylm_status open_library(ylm__vk *vk, ylm_error *e) {
  const char *asked = getenv("YLM_VULKAN_LIBRARY");
  const char *names[] = {asked && *asked ? asked : "libvulkan.so.1",
                         asked && *asked ? NULL : "libvulkan.so"};
  for (int i = 0; i < 2 && names[i] && !vk->library; i++)
    vk->library = dlopen(names[i], RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (!vk->library)
    return ylm_fail(
        e, YLM_EMISSING,
        "there is no Vulkan loader: %s cannot be opened; install it (Debian: libvulkan1) "
        "and a driver (mesa-vulkan-drivers, or the graphics card's own)",
        names[0]);
  /* A function pointer through a pointer to it: ISO C has no cast from void *. */
  *(void **)(void *)&vk->vkGetInstanceProcAddr = dlsym(vk->library, "vkGetInstanceProcAddr");
  if (!vk->vkGetInstanceProcAddr)
    return ylm_fail(e, YLM_EMISSING, "%s is no Vulkan loader", names[0]);
  return YLM_OK;
}

static VKAPI_ATTR VkBool32 VKAPI_CALL heard(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                            VkDebugUtilsMessageTypeFlagsEXT types,
                                            const VkDebugUtilsMessengerCallbackDataEXT *data,
                                            void *user) {
  ylm__vk *vk = user;
  (void)severity, (void)types;
  if (__atomic_fetch_add(&vk->messages, 1, __ATOMIC_RELAXED) == 0)
    snprintf(vk->first, sizeof vk->first, "%s", data->pMessage ? data->pMessage : "?");
  return VK_FALSE;
}

static bool has_layer(const ylm__vk *vk, const char *name) {
  VkLayerProperties list[64];
  uint32_t n = 64;
  VkResult r = vk->vkEnumerateInstanceLayerProperties(&n, list);
  for (uint32_t i = 0; (r == VK_SUCCESS || r == VK_INCOMPLETE) && i < n; i++)
    if (strcmp(list[i].layerName, name) == 0) return true;
  return false;
}

/*
** Makes, once in a process, an instance that stays: the loader then keeps the drivers. A driver that is loaded anew for each device
** may come to an end (NVIDIA's 580 is refused the 28th time).
*/
static void keep_drivers(const ylm__vk *vk, const VkApplicationInfo *app) {
  static bool kept;
  if (__atomic_exchange_n(&kept, true, __ATOMIC_RELAXED)) return;
  VkInstance stays;
  VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                               .pApplicationInfo = app};
  if (vk->vkCreateInstance(&info, NULL, &stays) != VK_SUCCESS)
    __atomic_store_n(&kept, false, __ATOMIC_RELAXED);
}

static ylm_status create_instance(ylm__vk *vk, bool validate, ylm_error *e) {
  const char *layers[] = {VALIDATION};
  const char *extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                              VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  const VkValidationFeatureEnableEXT races[] = {
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  /* Messages of instance creation and destruction come through this one. */
  VkDebugUtilsMessengerCreateInfoEXT listen = {
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                         VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                     VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
      .pfnUserCallback = heard,
      .pUserData = vk};
  VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                      .pNext = &listen,
                                      .enabledValidationFeatureCount = 1,
                                      .pEnabledValidationFeatures = races};
  VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                           .pApplicationName = "ylm",
                           .pEngineName = "ylm",
                           .apiVersion = VK_API_VERSION_1_2};
  VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                               .pNext = validate ? &features : NULL,
                               .pApplicationInfo = &app,
                               .enabledLayerCount = validate ? 1 : 0,
                               .ppEnabledLayerNames = layers,
                               .enabledExtensionCount = validate ? 2 : 0,
                               .ppEnabledExtensionNames = extensions};
  if (validate && !has_layer(vk, VALIDATION))
    return ylm_fail(
        e, YLM_EMISSING,
        "the Vulkan validation layer is not installed (Debian: vulkan-validationlayers)");
  VkResult r = vk->vkCreateInstance(&info, NULL, &vk->instance);
  if (r == VK_ERROR_INCOMPATIBLE_DRIVER)
    return ylm_fail(e, YLM_EMISSING, "there is no Vulkan driver; " INSTALL);
  if (r != VK_SUCCESS) return ylm__vk_fail(r, "no instance", e);
  keep_drivers(vk, &app);
  if (!validate) return YLM_OK;
  PFN_vkCreateDebugUtilsMessengerEXT create =
      (PFN_vkCreateDebugUtilsMessengerEXT)vk->vkGetInstanceProcAddr(
          vk->instance, "vkCreateDebugUtilsMessengerEXT");
  vk->vkDestroyDebugUtilsMessengerEXT =
      (PFN_vkDestroyDebugUtilsMessengerEXT)vk->vkGetInstanceProcAddr(
          vk->instance, "vkDestroyDebugUtilsMessengerEXT");
  if (create && vk->vkDestroyDebugUtilsMessengerEXT)
    create(vk->instance, &listen, NULL, &vk->messenger);
  if (!vk->messenger)
    return ylm_fail(e, YLM_EMISSING, "the Vulkan validation layer takes no messenger");
  return YLM_OK;
}

static ylm_status open_all(ylm__vk *vk, bool validate, ylm_error *e) {
  ylm_status s = open_library(vk, e);
  if (s != YLM_OK) return s;
#define X(name)                                                                                    \
  vk->name = (PFN_##name)vk->vkGetInstanceProcAddr(NULL, #name);                                   \
  if (!vk->name)                                                                                   \
    return ylm_fail(e, YLM_EMISSING, "the Vulkan loader is too old: it has no %s", #name);
  YLM_VK_GLOBAL(X)
#undef X
  s = create_instance(vk, validate, e);
  if (s != YLM_OK) return s;
#define X(name)                                                                                    \
  vk->name = (PFN_##name)vk->vkGetInstanceProcAddr(vk->instance, #name);                           \
  if (!vk->name)                                                                                   \
    return ylm_fail(e, YLM_EMISSING, "the Vulkan loader is too old: it has no %s", #name);
  YLM_VK_INSTANCE(X)
#undef X
  return YLM_OK;
}

ylm_status ylm__vk_open(ylm__vk *vk, bool validate, ylm_error *e) {
  memset(vk, 0, sizeof *vk);
  ylm_status s = open_all(vk, validate, e);
  if (s != YLM_OK) ylm__vk_close(vk);
  return s;
}

void ylm__vk_close(ylm__vk *vk) {
  if (vk->messenger) vk->vkDestroyDebugUtilsMessengerEXT(vk->instance, vk->messenger, NULL);
  if (vk->instance) {
    /* The one function that a loader too old might have left us without. */
    PFN_vkDestroyInstance destroy =
        (PFN_vkDestroyInstance)vk->vkGetInstanceProcAddr(vk->instance, "vkDestroyInstance");
    if (destroy) destroy(vk->instance, NULL);
  }
  if (vk->library) dlclose(vk->library);
  vk->messenger = VK_NULL_HANDLE;
  vk->instance = NULL;
  vk->library = NULL;
}

ylm_status ylm__vk_devices(const ylm__vk *vk, VkPhysicalDevice **list, uint32_t *n, ylm_error *e) {
  VkResult r = vk->vkEnumeratePhysicalDevices(vk->instance, n, NULL);
  if (r == VK_ERROR_INITIALIZATION_FAILED || (r == VK_SUCCESS && *n == 0))
    return ylm_fail(e, YLM_EMISSING, "there is no Vulkan device; " INSTALL);
  if (r != VK_SUCCESS) return ylm__vk_fail(r, "no devices", e);
  *list = ylm_alloc(*n, sizeof **list);
  if (!*list) return ylm_no_memory(e);
  r = vk->vkEnumeratePhysicalDevices(vk->instance, n, *list);
  if (r == VK_SUCCESS || r == VK_INCOMPLETE) return YLM_OK;
  ylm_free(*list);
  *list = NULL;
  return ylm__vk_fail(r, "no devices", e);
}
