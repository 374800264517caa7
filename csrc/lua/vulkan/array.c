/* array.c - arrays in a device's memory. */
#include "vulkan.h"

#include <string.h>

ylmL_gpu_array *ylmL_gpu_array_check(lua_State *L, int i) {
  ylmL_gpu_array *a = ylmL_check(L, i, YLM_GPU_ARRAY);
  if (!a->buffer) luaL_argerror(L, i, "the array has been closed");
  return a;
}

ylmL_gpu_array *ylmL_gpu_array_new(lua_State *L, ylm_gpu *g, ylm_dtype t, int axes,
                                   const size_t *shape, ylm_status *s, ylm_error *e) {
  size_t count;
  if (axes < 1 || axes > YLM_MAX_AXES || !ylm_shape_count(axes, shape, &count)) {
    *s = ylm_fail_plain(e, YLM_EOVERFLOW);
    return NULL;
  }
  ylmL_gpu_array *a = lua_newuserdata(L, sizeof *a);
  memset(a, 0, sizeof *a);
  luaL_getmetatable(L, YLM_GPU_ARRAY);
  lua_setmetatable(L, -2);
  *s = ylm_gpu_buffer_create(g, count * ylm_dtype_size(t), &a->buffer, e);
  if (*s != YLM_OK) {
    lua_pop(L, 1);
    return NULL;
  }
  a->dtype = t;
  a->axes = axes;
  memcpy(a->shape, shape, (size_t)axes * sizeof *shape);
  a->count = count;
  return a;
}

ylmL_any_array ylmL_any(lua_State *L, int i) {
  if (lua_isnil(L, i)) return (ylmL_any_array){0};
  if (ylmL_test(L, i, YLM_GPU_ARRAY)) {
    const ylmL_gpu_array *a = ylmL_gpu_array_check(L, i);
    return (ylmL_any_array){NULL, a->buffer, a->dtype, a->axes, a->shape, a->count};
  }
  const ylmL_array *a = ylmL_array_check(L, i);
  return (ylmL_any_array){a->data, NULL, a->dtype, a->axes, a->shape, a->count};
}

ylm_gpu_input ylmL_gpu_input(const ylmL_any_array *a) { return (ylm_gpu_input){a->host, a->there}; }

ylm_gpu_output ylmL_gpu_output(lua_State *L, int given, ylm_gpu *there, int axes,
                               const size_t *shape, ylm_status *s, ylm_error *e) {
  ylm_gpu_output none = {NULL, NULL};
  if (!lua_isnil(L, given)) {
    ylmL_any_array a = ylmL_any(L, given);
    if (a.dtype != YLM_FLOAT)
      *s = YLM_ETYPE;
    else if (a.axes != axes || memcmp(a.shape, shape, (size_t)axes * sizeof *shape) != 0)
      *s = YLM_ESHAPE;
    lua_pushvalue(L, given);
    return (ylm_gpu_output){a.host, a.there};
  }
  if (there) {
    ylm_status made = YLM_OK;
    ylmL_gpu_array *a = ylmL_gpu_array_new(L, there, YLM_FLOAT, axes, shape, &made, e);
    if (a) return (ylm_gpu_output){NULL, a->buffer};
    *s = made;
  } else {
    ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, axes, shape);
    if (a) return (ylm_gpu_output){a->data, NULL};
    *s = YLM_ENOMEM;
  }
  lua_pushnil(L);
  return none;
}

/* gpu_upload(gpu, array) -> gpu array, seconds */
static int upload(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_gpu *g = ylmL_gpu_check(L, 1);
  const ylmL_array *from = ylmL_array_check(L, 2);
  ylm_status s;
  double start = ylm_seconds();
  ylmL_gpu_array *a = ylmL_gpu_array_new(L, g, from->dtype, from->axes, from->shape, &s, &e);
  if (!a) return ylmL_result(L, 0, s, &e);
  a->convention = from->convention;
  s = ylm_gpu_upload(a->buffer, 0, a->count * ylm_dtype_size(a->dtype), from->data, &e);
  lua_pushnumber(L, (lua_Number)(ylm_seconds() - start));
  return ylmL_result(L, 2, s, &e);
}

/* gpu_array_new(gpu, shape, dtype) -> gpu array, its elements not set */
static int array_new(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_gpu *g = ylmL_gpu_check(L, 1);
  size_t shape[YLM_MAX_AXES];
  luaL_checktype(L, 2, LUA_TTABLE);
  int axes = (int)lua_rawlen(L, 2);
  if (axes < 1 || axes > YLM_MAX_AXES) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  for (int i = 0; i < axes; i++) {
    int64_t n;
    lua_rawgeti(L, 2, i + 1);
    if (!ylmL_toint64(L, -1, &n) || n < 0) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
    shape[i] = (size_t)n;
    lua_pop(L, 1);
  }
  ylm_status s;
  ylm_dtype t = strcmp(luaL_checkstring(L, 3), "double") == 0 ? YLM_DOUBLE : YLM_FLOAT;
  ylmL_gpu_array_new(L, g, t, axes, shape, &s, &e);
  return ylmL_result(L, 1, s, &e);
}

/* gpu_download(gpu array, array | nil) -> array, seconds */
static int download(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  const ylmL_gpu_array *a = ylmL_gpu_array_check(L, 1);
  ylmL_array *to = ylmL_array_opt(L, 2);
  if (to && to->dtype != a->dtype) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (to &&
      (to->axes != a->axes || memcmp(to->shape, a->shape, (size_t)a->axes * sizeof *a->shape) != 0))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  double start = ylm_seconds();
  if (to)
    lua_pushvalue(L, 2);
  else
    to = ylmL_array_new(L, a->dtype, a->axes, a->shape);
  if (!to) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  to->convention = a->convention;
  ylm_status s = ylm_gpu_download(a->buffer, 0, a->count * ylm_dtype_size(a->dtype), to->data, &e);
  lua_pushnumber(L, (lua_Number)(ylm_seconds() - start));
  return ylmL_result(L, 2, s, &e);
}

/* gpu_array_info(gpu array) -> shape, dtype, convention, whether it is open */
static int array_info(lua_State *L) {
  const ylmL_gpu_array *a = ylmL_check(L, 1, YLM_GPU_ARRAY);
  lua_createtable(L, a->axes, 0);
  for (int i = 0; i < a->axes; i++) {
    ylmL_push_count(L, a->shape[i]);
    lua_rawseti(L, -2, i + 1);
  }
  lua_pushstring(L, a->dtype == YLM_DOUBLE ? "double" : "float");
  lua_pushnumber(L, (lua_Number)a->convention);
  lua_pushboolean(L, a->buffer != NULL);
  return 4;
}

static int array_close(lua_State *L) {
  ylmL_gpu_array *a = ylmL_check(L, 1, YLM_GPU_ARRAY);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_gpu_buffer_free(a->buffer);
  a->buffer = NULL;
  ylmL_disown(L, 1);
  return 0;
}

static const luaL_Reg functions[] = {
    {"gpu_upload", upload},         {"gpu_array_new", array_new},     {"gpu_download", download},
    {"gpu_array_info", array_info}, {"gpu_array_close", array_close}, {NULL, NULL}};

static int array_gc(lua_State *L) {
  ylmL_gpu_array *a = ylmL_check(L, 1, YLM_GPU_ARRAY);
  ylm_gpu_buffer_free(a->buffer);
  a->buffer = NULL;
  ylmL_disown(L, 1);
  return 0;
}

static const luaL_Reg methods[] = {{"__gc", array_gc}, {NULL, NULL}};

void ylmL_open_vulkan_array(lua_State *L) {
  luaL_setfuncs(L, functions, 0);
  ylmL_gpu_type(L, YLM_GPU_ARRAY, methods);
}
