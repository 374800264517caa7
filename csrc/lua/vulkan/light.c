/* light.c - lights in a device's memory, an object with a light field. */
#include "vulkan.h"

#include "../binding_grid.h"
#include "ylm_light.h"

#define GPU_LIGHTS "ylm.gpu_lights"

/* The lights on the device, and those that they were made from. */
typedef struct device_lights {
  ylm_gpu_lights *on;   /* NULL once closed */
  ylm_light_set **from; /* in the userdata that `keep` holds in the registry; its NULL: closed */
  int keep, method;
} device_lights;

static const ylm_field *field_of(void *object) {
  const device_lights *d = object;
  return d->on && *d->from ? ylm_gpu_lights_field(d->on) : NULL;
}

/* In the order of ylm_gpu_method. */

/* gpu_lights_create(gpu, lights, method) -> lights on the device */
static int create(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  lua_settop(L, 3);
  ylm_gpu *g = ylmL_gpu_check(L, 1);
  const ylm_light_set *set = ylmL_lights_check(L, 2);
  int method = luaL_checkoption(L, 3, NULL, ylmL_sums_choices);
  device_lights *d = lua_newuserdata(L, sizeof *d);
  *d = (device_lights){NULL, lua_touserdata(L, 2), LUA_NOREF, method};
  luaL_getmetatable(L, GPU_LIGHTS);
  lua_setmetatable(L, -2);
  lua_pushvalue(L, 2);
  d->keep = luaL_ref(L, LUA_REGISTRYINDEX);
  return ylmL_result(L, 1, ylm_gpu_lights_create(g, set, (ylm_gpu_method)method, &d->on, &e), &e);
}

static int release(lua_State *L) {
  device_lights *d = ylmL_check(L, 1, GPU_LIGHTS);
  ylm_gpu_lights_free(d->on);
  d->on = NULL;
  luaL_unref(L, LUA_REGISTRYINDEX, d->keep);
  d->keep = LUA_NOREF;
  ylmL_disown(L, 1);
  return 0;
}

static int close_lights(lua_State *L) {
  ylmL_check(L, 1, GPU_LIGHTS);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  return release(L);
}

/* gpu_lights_info(lights) -> count, method; nil once closed */
static int info(lua_State *L) {
  const device_lights *d = ylmL_check(L, 1, GPU_LIGHTS);
  if (!field_of((void *)(uintptr_t)d)) return 0;
  ylmL_push_count(L, ylm_light_set_count(*d->from));
  lua_pushstring(L, ylmL_sums_choices[d->method]);
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
** gpu_grid_bake(form table, lights on a device, occupied [n][3] of the host or a device | list of
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
