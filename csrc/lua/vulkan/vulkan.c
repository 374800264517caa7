/* vulkan.c - opens ylm.c.vulkan: devices. For lua/ylm/vulkan/init.lua. */
#include "vulkan.h"

#include <string.h>

ylm_gpu *ylmL_gpu_check(lua_State *L, int i) {
  ylm_gpu **g = ylmL_check(L, i, YLM_GPU);
  if (!*g) luaL_argerror(L, i, "the device has been closed");
  return *g;
}

void ylmL_gpu_type(lua_State *L, const char *name, const luaL_Reg *methods) {
  ylmL_type(L, name, NULL);
  luaL_setfuncs(L, methods, 0);
  lua_pop(L, 1);
}

static void push_info(lua_State *L, const ylm_gpu_info *i) {
  lua_createtable(L, 0, 20);
  lua_pushstring(L, i->name);
  lua_setfield(L, -2, "name");
  lua_pushstring(L, i->driver);
  lua_setfield(L, -2, "driver");
  lua_pushstring(L, ylm_gpu_type_name(i->type));
  lua_setfield(L, -2, "type");
  lua_pushfstring(L, "%d.%d.%d", (int)i->vulkan[0], (int)i->vulkan[1], (int)i->vulkan[2]);
  lua_setfield(L, -2, "vulkan");
  ylmL_set_boolean(L, "usable", i->usable);
  ylmL_set_boolean(L, "float64", i->float64);
  ylmL_set_boolean(L, "int64", i->int64);
  ylmL_set_boolean(L, "timestamps", i->timestamps);
  ylmL_set_count(L, "subgroup", i->subgroup);
  ylmL_set_count(L, "binds", i->binds);
  ylmL_set_count(L, "group_size", i->group_size);
  ylmL_set_count(L, "groups", i->groups);
  ylmL_set_count(L, "shared_bytes", i->shared_bytes);
  ylmL_set_count(L, "bind_bytes", i->bind_bytes);
  ylmL_set_count(L, "allocation_bytes", i->allocation_bytes);
  ylmL_set_count(L, "memory_bytes", i->memory_bytes);
}

/* gpu_devices() -> list of tables */
static int devices(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_gpu_info *list;
  size_t n;
  ylm_status s = ylm_gpu_list(&list, &n, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  lua_createtable(L, (int)n, 0);
  for (size_t i = 0; i < n; i++) {
    push_info(L, &list[i]);
    lua_rawseti(L, -2, (int)i + 1);
  }
  ylm_free(list);
  return 1;
}

/* gpu_open(index from 1 | nil, name | nil, validate, staging) -> gpu */
static int gpu_open(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_gpu_options o = {.index = (int)luaL_optnumber(L, 1, 0) - 1,
                       .name = luaL_optstring(L, 2, NULL),
                       .validate = lua_toboolean(L, 3),
                       .staging = lua_toboolean(L, 4)};
  ylm_gpu **g = lua_newuserdata(L, sizeof *g);
  *g = NULL;
  luaL_getmetatable(L, YLM_GPU);
  lua_setmetatable(L, -2);
  return ylmL_result(L, 1, ylm_gpu_open(&o, g, &e), &e);
}

static int gpu_gc(lua_State *L) {
  ylm_gpu **g = ylmL_check(L, 1, YLM_GPU);
  ylm_gpu_free(*g);
  *g = NULL;
  return 0;
}

/* gpu_close(gpu): its object stays, to be asked for messages */
static int gpu_close(lua_State *L) {
  ylm_gpu *g = ylmL_gpu_check(L, 1);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  return ylmL_result(L, 0, ylm_gpu_close(g), NULL);
}

/* gpu_state(gpu) -> true, or nil, message, code */
static int gpu_state(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_status s = ylm_gpu_state(ylmL_gpu_check(L, 1), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static int gpu_info(lua_State *L) {
  push_info(L, ylm_gpu_about(ylmL_gpu_check(L, 1)));
  return 1;
}

/* gpu_messages(gpu) -> number, the first */
static int gpu_messages(lua_State *L) {
  const char *first;
  ylmL_push_count(L, ylm_gpu_messages(ylmL_gpu_check(L, 1), &first));
  lua_pushstring(L, first);
  return 2;
}

static int gpu_used(lua_State *L) {
  ylm_gpu_use u = ylm_gpu_used(ylmL_gpu_check(L, 1));
  lua_createtable(L, 0, 10);
  ylmL_set_count(L, "arrays", u.buffers);
  ylmL_set_count(L, "bytes", u.bytes);
  ylmL_set_count(L, "uploaded", u.uploaded);
  ylmL_set_count(L, "downloaded", u.downloaded);
  ylmL_set_number(L, "upload_seconds", u.upload);
  ylmL_set_number(L, "download_seconds", u.download);
  ylmL_set_number(L, "run_seconds", u.run);
  ylmL_set_count(L, "dispatches", u.dispatches);
  ylmL_set_count(L, "submissions", u.submissions);
  ylmL_set_count(L, "pipelines", u.pipelines);
  return 1;
}

/* gpu_lose(gpu): as if the driver had lost the device; for specs */
static int gpu_lose(lua_State *L) {
  ylm_gpu_lose(ylmL_gpu_check(L, 1));
  return 0;
}

/* gpu_break(gpu, i, "memory" | "lost" | "unknown" | "none") -> name of the driver's i-th function
   that may fail, which then fails (or works again), or nil; for specs */
static int gpu_break(lua_State *L) {
  static const char *const words[] = {"none", "memory", "lost", "unknown", NULL};
  static const ylm_status how[] = {YLM_OK, YLM_ENOMEM, YLM_EDEVICE, YLM_EINVAL};
  size_t i = (size_t)luaL_checkinteger(L, 2) - 1;
  lua_pushstring(L,
                 ylm_gpu_break(ylmL_gpu_check(L, 1), i, how[luaL_checkoption(L, 3, NULL, words)]));
  return 1;
}

/* gpu_shrink(gpu, memory bytes | 0, bytes that kernels see | 0, buffers of a kernel | 0, without
   double): for specs */
static int gpu_shrink(lua_State *L) {
  ylm_gpu_shrink(ylmL_gpu_check(L, 1), (uint64_t)luaL_checknumber(L, 2),
                 (uint64_t)luaL_checknumber(L, 3), (uint32_t)luaL_checknumber(L, 4),
                 lua_toboolean(L, 5));
  return 0;
}

/* gpu_blunder(gpu): something for the validation layer to complain about; for specs */
static int gpu_blunder(lua_State *L) {
  ylm_gpu_blunder(ylmL_gpu_check(L, 1));
  return 0;
}

/* gpu_peak(gpu) -> operations per second, bytes per second */
static int gpu_peak(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  double flops = 0, bytes = 0;
  ylm_status s = ylm_gpu_peak(ylmL_gpu_check(L, 1), &flops, &bytes, &e);
  lua_pushnumber(L, (lua_Number)flops);
  lua_pushnumber(L, (lua_Number)bytes);
  return ylmL_result(L, 2, s, &e);
}

void ylmL_gpu_push_times(lua_State *L, const ylm_gpu_times *t) {
  lua_createtable(L, 0, t->stages);
  for (int i = 0; i < t->stages; i++) {
    lua_createtable(L, 0, 3);
    ylmL_set_number(L, "seconds", t->stage[i].seconds);
    ylmL_set_number(L, "longest", t->stage[i].longest);
    ylmL_set_count(L, "dispatches", t->stage[i].dispatches);
    lua_setfield(L, -2, t->stage[i].name);
  }
}

/*
** gpu_spin(gpu, groups, steps, progress) -> times, sum of the results
** Runs the kernel that measures the peak: work that is as long as one wants, for specs.
*/
static int gpu_spin(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_gpu *g = ylmL_gpu_check(L, 1);
  ylmL_progress progress;
  ylm_gpu_times times = {0};
  double groups = (double)luaL_checknumber(L, 2), sum = 0;
  struct {
    uint32_t n, steps;
    float a, b;
  } push = {(uint32_t)(groups * 64), (uint32_t)luaL_checknumber(L, 3), 0, 1};
  const ylm_progress *p = ylmL_progress_begin(L, 4, &progress);
  size_t shape[1] = {push.n};
  ylm_gpu_work w = {.verb = YLM_GPU_DISPATCH,
                    .stage = "spin",
                    .groups = (uint64_t)groups,
                    .cost = push.steps,
                    .push = &push,
                    .push_bytes = sizeof push,
                    .binds = 1};
  ylmL_array *host = ylmL_array_new(L, YLM_FLOAT, 1, shape);
  if (!host) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_gpu_kernel_get(g, "peak_fma", 1, (uint32_t[]){64}, &w.kernel, &e);
  if (s == YLM_OK) s = ylm_gpu_buffer_create(g, push.n * 4ull, &w.bind[0].buffer, &e);
  if (s == YLM_OK) s = ylm_gpu_run(g, 1, &w, &times, p, &e);
  if (s == YLM_OK) s = ylm_gpu_download(w.bind[0].buffer, 0, push.n * 4ull, host->data, &e);
  ylm_gpu_buffer_free(w.bind[0].buffer);
  for (size_t i = 0; i < push.n; i++) sum += (double)((float *)host->data)[i];
  ylmL_gpu_push_times(L, &times);
  lua_pushnumber(L, (lua_Number)sum);
  return ylmL_result_progress(L, 2, s, &e, &progress);
}

static const luaL_Reg functions[] = {{"gpu_devices", devices},     {"gpu_open", gpu_open},
                                     {"gpu_close", gpu_close},     {"gpu_state", gpu_state},
                                     {"gpu_info", gpu_info},       {"gpu_messages", gpu_messages},
                                     {"gpu_used", gpu_used},       {"gpu_lose", gpu_lose},
                                     {"gpu_break", gpu_break},     {"gpu_shrink", gpu_shrink},
                                     {"gpu_blunder", gpu_blunder}, {"gpu_peak", gpu_peak},
                                     {"gpu_spin", gpu_spin},       {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", gpu_gc}, {NULL, NULL}};

int luaopen_ylm_c_vulkan(lua_State *L) {
  ylmL_check_abi(L);
  ylmL_gpu_type(L, YLM_GPU, methods);
  lua_newtable(L);
  luaL_setfuncs(L, functions, 0);
#define X(name) ylmL_open_vulkan_##name(L);
  YLML_VULKAN_BINDINGS(X)
#undef X
  return 1;
}
