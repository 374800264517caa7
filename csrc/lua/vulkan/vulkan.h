/* vulkan.h - what the files of the Vulkan binding share. Private to csrc/lua/vulkan. */
#ifndef YLM_LUA_VULKAN_H
#define YLM_LUA_VULKAN_H

#include "../binding.h"
#include "ylm_vulkan.h"

#define YLM_GPU "ylm.gpu"
#define YLM_GPU_ARRAY "ylm.gpu_array"

/* The device at `i`; it may be closed or lost: functions of ylm_vulkan.h say so. */
ylm_gpu *ylmL_gpu_check(lua_State *L, int i);

/* An array whose elements are in a device's memory. */
typedef struct ylmL_gpu_array {
  ylm_gpu_buffer *buffer; /* NULL once closed */
  ylm_dtype dtype;
  int axes;
  size_t shape[YLM_MAX_AXES];
  size_t count;
  uint32_t convention;
} ylmL_gpu_array;

/* A new one on the stack, its elements not set; NULL and *s otherwise, with nothing pushed. */
ylmL_gpu_array *ylmL_gpu_array_new(lua_State *L, ylm_gpu *g, ylm_dtype t, int axes,
                                   const size_t *shape, ylm_status *s, ylm_error *e);
/* The array at `i`, open; raises otherwise. */
ylmL_gpu_array *ylmL_gpu_array_check(lua_State *L, int i);

/* An array of the host's or a device's: its numbers, type and extents; where it is nil, none: NULL,
   count 0. */
typedef struct ylmL_any_array {
  void *host;
  ylm_gpu_buffer *there;
  ylm_dtype dtype;
  int axes;
  const size_t *shape;
  size_t count;
} ylmL_any_array;

/* The one at `i`; raises on what is no open array. */
ylmL_any_array ylmL_any(lua_State *L, int i);
ylm_gpu_input ylmL_gpu_input(const ylmL_any_array *a);
/* Pushes the float array at stack index `given` if it has that shape, else a new one, of the
   device's memory (`there`) or the host's. Returns what was pushed. */
ylm_gpu_output ylmL_gpu_output(lua_State *L, int given, ylm_gpu *there, int axes,
                               const size_t *shape, ylm_status *s, ylm_error *e);

/* A grid's copy on the stack, closed until the caller fills it in. */
ylm_gpu_grid **ylmL_gpu_grid_new(lua_State *L);

/* Pushes times by stage: { name = { seconds =, longest =, dispatches = } }. */
void ylmL_gpu_push_times(lua_State *L, const ylm_gpu_times *t);

/* Makes a type's metatable with these functions, if it is not there yet; leaves nothing. */
void ylmL_gpu_type(lua_State *L, const char *name, const luaL_Reg *methods);

/* Each X(name) is a file vulkan/NAME.c with ylmL_open_vulkan_NAME(L), which adds functions to the
   table on top. */
#define YLML_VULKAN_BINDINGS(X)                                                                    \
  X(array)                                                                                         \
  X(grid)                                                                                          \
  X(light)                                                                                         \
  X(picture)                                                                                       \
  X(sh)

#define X(name) void ylmL_open_vulkan_##name(lua_State *L);
YLML_VULKAN_BINDINGS(X)
#undef X

#endif
