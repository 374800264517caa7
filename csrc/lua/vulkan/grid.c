/*
** grid.c - grids in a device's memory. Arguments come sorted from lua/ylm/vulkan/grid.lua.
*/
#include "../binding_grid.h"
#include "vulkan.h"

#include <math.h>
#include <string.h>

#define GPU_GRID "ylm.gpu_grid"

static ylm_gpu_grid *copy_at(lua_State *L, int i) {
  ylm_gpu_grid **k = ylmL_check(L, i, GPU_GRID);
  if (!*k) luaL_argerror(L, i, "the copy has been closed");
  return *k;
}

ylm_gpu_grid **ylmL_gpu_grid_new(lua_State *L) {
  ylm_gpu_grid **k = lua_newuserdata(L, sizeof *k);
  *k = NULL;
  luaL_getmetatable(L, GPU_GRID);
  lua_setmetatable(L, -2);
  return k;
}

/* gpu_grid_create(gpu, grid, packed) -> copy, seconds */
static int create(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  double start = ylm_seconds();
  ylm_gpu *g = ylmL_gpu_check(L, 1);
  const ylm_grid *grid = ylmL_grid_check(L, 2);
  ylm_gpu_grid **k = ylmL_gpu_grid_new(L);
  ylm_status s = ylm_gpu_grid_create(g, grid, lua_toboolean(L, 3), k, &e);
  lua_pushnumber(L, (lua_Number)(ylm_seconds() - start));
  return ylmL_result(L, 2, s, &e);
}

/* gpu_grid_info(copy) -> bytes, or nil once closed */
static int info(lua_State *L) {
  ylm_gpu_grid **k = ylmL_check(L, 1, GPU_GRID);
  if (!*k) return 0;
  ylmL_push_count(L, ylm_gpu_grid_bytes(*k));
  return 1;
}

/* gpu_grid_packed(copy) -> error or nil where it is not known, rounding, largest; nothing: it is not packed, or closed */
static int packed(lua_State *L) {
  ylm_gpu_grid **k = ylmL_check(L, 1, GPU_GRID);
  ylm_grid_packing r;
  if (!*k || !ylm_gpu_grid_packed(*k, &r)) return 0;
  if (isnan(r.error))
    lua_pushnil(L);
  else
    lua_pushnumber(L, r.error);
  lua_pushnumber(L, r.rounding);
  lua_pushnumber(L, r.largest);
  return 3;
}

/* gpu_grid_current(copy, grid) -> whether it is open, and has the grid's present state */
static int current(lua_State *L) {
  ylm_gpu_grid **k = ylmL_check(L, 1, GPU_GRID);
  lua_pushboolean(L, *k && ylm_gpu_grid_current(*k, ylmL_grid_check(L, 2)));
  return 1;
}

static int gc(lua_State *L) {
  ylm_gpu_grid **k = ylmL_check(L, 1, GPU_GRID);
  ylm_gpu_grid_free(*k);
  *k = NULL;
  ylmL_disown(L, 1);
  return 0;
}

static int close_copy(lua_State *L) {
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  return gc(L);
}

typedef struct sample_form {
  ylm_grid_query q;
  int derivatives;
  int value, gradient, progress; /* on the stack */
} sample_form;

static const ylmL_entry sample_entries[] = {
    YLML(sample_form, q.interpolation, "interpolation", CHOICE,
         .choices = ylmL_interpolation_choices),
    YLML(sample_form, derivatives, "derivatives", INT),
    YLML(sample_form, q.nan_outside, "outside", EITHER, .choices = ylmL_outside_choices),
    YLML(sample_form, progress, "progress", VALUE),
    YLML(sample_form, value, "value", VALUE),
    YLML(sample_form, gradient, "gradient", VALUE),
    {.name = NULL}};

/* gpu_grid_sample(copy, grid, points, {interpolation, derivatives, outside, progress, value | nil,
   gradient | nil}) -> value, gradient | nil, outside, unbaked, seconds, times. New results are where the
   points are. */
static int sample(lua_State *L) {
  sample_form f = {.q = {.dtype = YLM_FLOAT}};
  ylmL_read(L, 4, sample_entries, &f);
  ylm_gpu_grid *k = copy_at(L, 1);
  const ylm_grid *grid = ylmL_grid_check(L, 2);
  const ylm_grid_contents *v = ylm_grid_look(grid);
  ylmL_any_array points = ylmL_any(L, 3);
  ylm_error e = {YLM_OK, ""};
  ylm_grid_report report = {0};
  ylm_gpu_times times = {0};
  ylmL_progress progress;
  f.q.point_dtype = points.dtype;
  f.q.progress = ylmL_progress_begin(L, f.progress, &progress);
  size_t shape[4] = {points.count / 3, (size_t)v->form.channels, (size_t)v->count, 3};
  ylm_gpu *there = points.there ? ylm_gpu_buffer_device(points.there) : NULL;
  ylm_status s = YLM_OK;
  ylm_gpu_output gradient = {NULL, NULL},
                 value = ylmL_gpu_output(L, f.value, there, 3, shape, &s, &e);
  if (f.derivatives > 0)
    gradient = ylmL_gpu_output(L, f.gradient, there, 4, shape, &s, &e);
  else
    lua_pushnil(L);
  if (s == YLM_OK)
    s = ylm_gpu_grid_sample(k, grid, &f.q, shape[0], ylmL_gpu_input(&points), value, gradient,
                            &report, &times, &e);
  if (s == YLM_OK) {
    ylmL_push_count(L, report.outside);
    ylmL_push_count(L, report.unbaked);
    lua_pushnumber(L, (lua_Number)report.seconds);
    ylmL_gpu_push_times(L, &times);
  }
  return ylmL_result_progress(L, 6, s, &e, &progress);
}

typedef struct shade_form {
  ylm_grid_query q;
  int points, transfer, material, radiance, progress; /* on the stack */
} shade_form;

static const ylmL_entry shade_entries[] = {YLML(shade_form, points, "points", VALUE),
                                           YLML(shade_form, transfer, "transfer", VALUE),
                                           YLML(shade_form, material, "material", VALUE),
                                           YLML(shade_form, q.interpolation, "interpolation",
                                                CHOICE, .choices = ylmL_interpolation_choices),
                                           YLML(shade_form, progress, "progress", VALUE),
                                           YLML(shade_form, radiance, "radiance", VALUE),
                                           {.name = NULL}};

/* gpu_grid_shade(copy, grid, {points [n][3], transfer [n][row], material [n][3], interpolation,
   progress, radiance | nil}) -> radiance [n][3], outside, unbaked, seconds, times; all float. The
   radiance is where the points are. */
static int shade(lua_State *L) {
  shade_form f = {.q = {.point_dtype = YLM_FLOAT, .dtype = YLM_FLOAT}};
  ylmL_read(L, 3, shade_entries, &f);
  ylm_gpu_grid *k = copy_at(L, 1);
  const ylm_grid *grid = ylmL_grid_check(L, 2);
  ylmL_any_array points = ylmL_any(L, f.points), transfer = ylmL_any(L, f.transfer),
                 material = ylmL_any(L, f.material);
  ylm_error e = {YLM_OK, ""};
  ylm_grid_report report = {0};
  ylm_gpu_times times = {0};
  ylmL_progress progress;
  if (!transfer.count && !transfer.axes) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = points.count / 3, row = transfer.shape[transfer.axes - 1];
  if (points.dtype != YLM_FLOAT || transfer.dtype != YLM_FLOAT || material.dtype != YLM_FLOAT)
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (points.count != 3 * n || transfer.count != n * row || material.count != 3 * n)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  f.q.progress = ylmL_progress_begin(L, f.progress, &progress);
  ylm_gpu *there = points.there ? ylm_gpu_buffer_device(points.there) : NULL;
  ylm_status s = YLM_OK;
  ylm_gpu_output radiance = ylmL_gpu_output(L, f.radiance, there, 2, (size_t[]){n, 3}, &s, &e);
  if (s == YLM_OK)
    s = ylm_gpu_grid_shade(k, grid, &f.q, n, ylmL_gpu_input(&points), row,
                           ylmL_gpu_input(&transfer), ylmL_gpu_input(&material), radiance, &report,
                           &times, &e);
  ylmL_push_count(L, report.outside);
  ylmL_push_count(L, report.unbaked);
  lua_pushnumber(L, (lua_Number)report.seconds);
  ylmL_gpu_push_times(L, &times);
  return ylmL_result_progress(L, 5, s, &e, &progress);
}

static const luaL_Reg functions[] = {{"gpu_grid_create", create},   {"gpu_grid_info", info},
                                     {"gpu_grid_packed", packed},   {"gpu_grid_close", close_copy},
                                     {"gpu_grid_sample", sample},   {"gpu_grid_shade", shade},
                                     {"gpu_grid_current", current}, {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", gc}, {NULL, NULL}};

void ylmL_open_vulkan_grid(lua_State *L) {
  luaL_setfuncs(L, functions, 0);
  ylmL_gpu_type(L, GPU_GRID, methods);
}
