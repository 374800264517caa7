/* light.c - lights in a device's memory, an object with a light field. */
#include "vulkan.h"

#include "../binding_grid.h"
#include "ylm_light.h"

#define GPU_LIGHTS "ylm.gpu_lights"

/* The lights on the device, and those that they were made from. */
typedef struct device_lights {
  ylm_gpu_lights *on;   /* NULL once closed */
  ylm_lights **from;    /* in the userdata that `keep` holds in the registry; its NULL: closed */
  ylm_polygons ***flat; /* [n], the same; `from` is NULL where there are no spheres */
  size_t n;
  int keep[2], method;
} device_lights;

static bool flat_open(const device_lights *d) {
  for (size_t i = 0; i < d->n; i++)
    if (!*d->flat[i]) return false;
  return true;
}

static const ylm_field *field_of(void *object) {
  const device_lights *d = object;
  bool open = (!d->from || *d->from) && flat_open(d);
  return d->on && open ? ylm_gpu_lights_field(d->on) : NULL;
}

/* Puts them onto the device. */
static ylm_status put(device_lights *d, ylm_gpu *g, ylm_error *e) {
  const ylm_polygons **flat = ylm_alloc(d->n, sizeof *flat);
  if (!flat) return YLM_ENOMEM;
  for (size_t i = 0; i < d->n; i++) flat[i] = *d->flat[i];
  ylm_status s = ylm_gpu_lights_create(g, d->from ? *d->from : NULL, d->n, flat,
                                       (ylm_gpu_method)d->method, &d->on, e);
  ylm_free((void *)flat);
  return s;
}

/* gpu_lights_create(gpu, lights | nil, {polygons ..}, method number) -> lights on the device */
static int create(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  lua_settop(L, 4);
  ylm_gpu *g = ylmL_gpu_check(L, 1);
  ylm_lights **from = lua_isnil(L, 2) ? NULL : ylmL_check(L, 2, "ylm.lights");
  luaL_checktype(L, 3, LUA_TTABLE);
  int method = (int)luaL_checknumber(L, 4);
  size_t n = (size_t)lua_rawlen(L, 3);
  device_lights *d = lua_newuserdata(L, sizeof *d);
  *d = (device_lights){NULL, from, NULL, 0, {LUA_NOREF, LUA_NOREF}, method};
  luaL_getmetatable(L, GPU_LIGHTS);
  lua_setmetatable(L, -2);
  d->flat = ylm_alloc(n, sizeof *d->flat);
  if (!d->flat) return ylmL_result(L, 1, YLM_ENOMEM, NULL);
  for (; d->n < n; d->n++) {
    lua_rawgeti(L, 3, (int)d->n + 1);
    d->flat[d->n] = ylmL_check(L, -1, "ylm.polygons");
    lua_pop(L, 1);
  }
  if ((from && !*from) || !flat_open(d)) luaL_argerror(L, 2, "the lights have been closed");
  for (int i = 0; i < 2; i++) {
    lua_pushvalue(L, 2 + i);
    d->keep[i] = luaL_ref(L, LUA_REGISTRYINDEX);
  }
  return ylmL_result(L, 1, put(d, g, &e), &e);
}

static int release(lua_State *L) {
  device_lights *d = ylmL_check(L, 1, GPU_LIGHTS);
  ylm_gpu_lights_free(d->on);
  d->on = NULL;
  for (int i = 0; i < 2; i++) {
    luaL_unref(L, LUA_REGISTRYINDEX, d->keep[i]);
    d->keep[i] = LUA_NOREF;
  }
  ylm_free((void *)d->flat);
  d->from = NULL;
  d->flat = NULL;
  d->n = 0;
  return 0;
}

static int close_lights(lua_State *L) {
  ylmL_check(L, 1, GPU_LIGHTS);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  return release(L);
}

/* gpu_lights_info(lights) -> count, method number; nil once closed */
static int info(lua_State *L) {
  const device_lights *d = ylmL_check(L, 1, GPU_LIGHTS);
  if (!field_of((void *)(uintptr_t)d)) return 0;
  size_t n = d->from ? ylm_lights_count(*d->from) : 0;
  for (size_t i = 0; i < d->n; i++) n += ylm_polygons_count(*d->flat[i]);
  ylmL_push_count(L, n);
  lua_pushnumber(L, d->method);
  return 2;
}

/* gpu_lights_on(lights, gpu) -> whether they are in that device's memory */
static int on(lua_State *L) {
  const device_lights *d = ylmL_check(L, 1, GPU_LIGHTS);
  lua_pushboolean(L, d->on && ylm_gpu_lights_device(d->on) == ylmL_gpu_check(L, 2));
  return 1;
}

/* gpu_lights_times(lights) -> times of all that was done, by stage */
static int times(lua_State *L) {
  const device_lights *d = ylmL_check(L, 1, GPU_LIGHTS);
  if (!d->on) luaL_argerror(L, 1, "the lights have been closed");
  ylmL_gpu_push_times(L, ylm_gpu_lights_times(d->on));
  return 1;
}

/*
** gpu_grid_bake(form table, lights on a device, occupied [n][3], the host's or a device's | list of
** meshes | nil, seed, threads, max_points, progress) -> grid, its copy on the device | nil
*/
static int grid_bake(lua_State *L) {
  lua_settop(L, 7);
  luaL_checkstack(L, 20, "gpu_grid_bake");
  ylm_grid_form form = ylmL_grid_form(L, 1);
  const device_lights *d = ylmL_check(L, 2, GPU_LIGHTS);
  if (!field_of((void *)(uintptr_t)d)) luaL_argerror(L, 2, "the lights have been closed");
  ylmL_any_array occupied = {0};
  if (!lua_istable(L, 3)) occupied = ylmL_any(L, 3);
  ylmL_progress progress;
  lua_pushvalue(L, 3); /* it stays on the stack */
  if (occupied.there) {
    lua_pushnil(L);
    lua_replace(L, 3);
  }
  ylm_grid_source source = ylmL_grid_source(L, &progress);
  if (occupied.there) source.occupied = occupied.count / 3, source.occupied_dtype = occupied.dtype;
  ylm_grid **g = ylmL_grid_new(L);
  ylm_gpu_grid **copy = ylmL_gpu_grid_new(L);
  ylm_error e = {0};
  ylm_status s = ylm_gpu_grid_bake(d->on, &form, &source, occupied.there, g, copy, &e);
  if (s == YLM_OK) ylmL_charge(L, ylm_grid_look(*g)->stats->bytes);
  if (s == YLM_OK && !*copy) lua_pop(L, 1);
  return ylmL_result_progress(L, *copy ? 2 : 1, s, &e, &progress);
}

static const luaL_Reg functions[] = {{"gpu_lights_create", create},
                                     {"gpu_lights_close", close_lights},
                                     {"gpu_lights_info", info},
                                     {"gpu_lights_on", on},
                                     {"gpu_lights_times", times},
                                     {"gpu_grid_bake", grid_bake},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", release}, {NULL, NULL}};

void ylmL_open_vulkan_light(lua_State *L) {
  luaL_setfuncs(L, functions, 0);
  ylmL_gpu_type(L, GPU_LIGHTS, methods);
  luaL_getmetatable(L, GPU_LIGHTS);
  ylmL_type_has_field(L, field_of);
  lua_pop(L, 1);
}
