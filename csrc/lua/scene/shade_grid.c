/* shade_grid.c - shading by grids. */
#include <string.h>

#include "../binding_grid.h"
#include "shade.h"
#include "ylm_shade_over.h"

/* The factors that field `window` of the table at i lists; false: there is none. */
static bool read_window(lua_State *L, int i, double window[YLM_LMAX + 1]) {
  lua_getfield(L, i, "window");
  bool some = lua_istable(L, -1);
  for (int l = 0; some && l <= YLM_LMAX; l++) {
    lua_rawgeti(L, -1, l + 1);
    window[l] = (double)lua_tonumber(L, -1);
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  return some;
}

/* shade_grid(view, grid, "transfer" | "cosine", "hermite" | "taylor" | "linear", threads, progress,
              {window = factors of degrees 0 .. | nil} | nil)
   -> radiance [n][3], outside, unbaked, seconds */
static int shade_grid(lua_State *L) {
  double window[YLM_LMAX + 1];
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_grid *g = ylmL_grid_check(L, 2);
  ylm_shade_weight weight = ylmL_shade_weight(L, 3);
  ylm_grid_interpolation how = ylmL_grid_interpolation(L, 4);
  int threads = (int)luaL_checknumber(L, 5);
  ylm_grid_report report = {0};
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 7);
  if (!lua_istable(L, 7)) {
    lua_newtable(L);
    lua_replace(L, 7);
  }
  bool damped = read_window(L, 7, window);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylmL_shade_points(v), 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  const ylm_progress *progress = ylmL_progress_begin(L, 6, &p);
  ylm_status s = ylm_shade_grid(v, g, weight, how, damped ? window : NULL, threads, progress,
                                out->data, &report, &e);
  if (s == YLM_OK) {
    ylmL_push_count(L, report.outside);
    ylmL_push_count(L, report.unbaked);
    lua_pushnumber(L, (lua_Number)report.seconds);
  }
  return ylmL_result_progress(L, 4, s, &e, &p);
}

#define MEMORY "ylm.shade_memory"

static int memory_free(lua_State *L) {
  ylm_shade_memory **m = ylmL_check(L, 1, MEMORY);
  ylm_shade_memory_free(*m);
  *m = NULL;
  return 0;
}

/* shade_memory(view) -> memory for shade_grid_again */
static int shade_memory(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_memory **m = lua_newuserdata(L, sizeof *m);
  *m = NULL;
  luaL_getmetatable(L, MEMORY);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_shade_memory_create(v, m);
  if (s == YLM_OK) ylmL_charge(L, 20 * ylmL_shade_points(v));
  return ylmL_result(L, 1, s, NULL);
}

/* shade_grid_again(view, memory, grid, "hermite" | "taylor" | "linear", threads, progress,
   radiance)
   -> radiance [n][3] (the array given), outside, unbaked, seconds, fresh */
static int shade_grid_again(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_memory **m = ylmL_check(L, 2, MEMORY);
  const ylm_grid *g = ylmL_grid_check(L, 3);
  ylm_grid_interpolation how = ylmL_grid_interpolation(L, 4);
  int threads = (int)luaL_checknumber(L, 5);
  ylmL_array *out = ylmL_array_check(L, 7);
  ylm_grid_report report = {0};
  uint64_t fresh = 0;
  ylm_error e = {0};
  ylmL_progress p;
  if (ylmL_busy(L, 2) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  if (out->dtype != YLM_FLOAT || out->count != 3 * ylmL_shade_points(v) || !*m)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  const ylm_progress *progress = ylmL_progress_begin(L, 6, &p);
  ylm_status s =
      ylm_shade_grid_again(v, *m, g, how, threads, progress, out->data, &report, &fresh, &e);
  lua_pushvalue(L, 7);
  if (s == YLM_OK) {
    lua_pushnumber(L, (lua_Number)report.outside);
    lua_pushnumber(L, (lua_Number)report.unbaked);
    lua_pushnumber(L, (lua_Number)report.seconds);
    lua_pushnumber(L, (lua_Number)fresh);
  }
  return ylmL_result_progress(L, 5, s, &e, &p);
}

/* (view, threads, image [h][w][numbers], lights): draws lamps over it. */
static int draw(lua_State *L, size_t numbers,
                ylm_status (*lamps_into)(const ylm_shade_view *, const ylm_scene_lamps *, int,
                                         float *)) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  int threads = (int)luaL_checknumber(L, 2);
  ylmL_array *image = ylmL_array_check(L, 3);
  ylm_scene_lamps lamps;
  if (image->dtype != YLM_FLOAT || image->count != numbers * (size_t)o->width * (size_t)o->height)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  lua_settop(L, 4);
  if (!ylmL_scene_lamps(L, 4, ylm_shade_view_origin(v), &lamps))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = lamps_into(v, &lamps, threads, image->data);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, NULL);
}

/* shade_draw_lamps(view, threads, image [h][w][3], lights) */
static int shade_draw_lamps(lua_State *L) { return draw(L, 3, ylm_shade_draw_lamps); }

/* shade_lamp_depth(view, threads, depth [h][w] or [h][w][1], lights) */
static int shade_lamp_depth(lua_State *L) { return draw(L, 1, ylm_shade_lamp_depth); }

/* shade_lamp_at(view, lights, x, y, reach) -> index from 1, pixels away, depth; 0 where there is none */
static int shade_lamp_at(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  double x = (double)luaL_checknumber(L, 3), y = (double)luaL_checknumber(L, 4);
  double reach = (double)luaL_checknumber(L, 5);
  ylm_scene_lamps lamps;
  ylm_shade_lamp found;
  lua_settop(L, 2);
  if (!ylmL_scene_lamps(L, 2, ylm_shade_view_origin(v), &lamps))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  bool some = ylm_shade_lamp_at(v, &lamps, x, y, reach, &found);
  ylmL_push_count(L, some ? (uint64_t)found.index + 1 : 0);
  lua_pushnumber(L, some ? (lua_Number)found.away : 0);
  lua_pushnumber(L, some ? (lua_Number)found.depth : 0);
  return 3;
}

/* shade_grid_cells(view, grid, threads) -> level [n], error [n] */
static int shade_grid_cells(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_grid *g = ylmL_grid_check(L, 2);
  int threads = (int)luaL_checknumber(L, 3);
  size_t n = ylmL_shade_points(v);
  ylmL_array *level = ylmL_array_new(L, YLM_FLOAT, 1, &n);
  ylmL_array *error = level ? ylmL_array_new(L, YLM_FLOAT, 1, &n) : NULL;
  if (!error) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 2, ylm_shade_grid_cells(v, g, threads, level->data, error->data), NULL);
}

static const luaL_Reg functions[] = {{"shade_grid", shade_grid},
                                     {"shade_grid_cells", shade_grid_cells},
                                     {"shade_memory", shade_memory},
                                     {"shade_grid_again", shade_grid_again},
                                     {"shade_draw_lamps", shade_draw_lamps},
                                     {"shade_lamp_depth", shade_lamp_depth},
                                     {"shade_lamp_at", shade_lamp_at},
                                     {NULL, NULL}};

static const luaL_Reg memory_methods[] = {{"__gc", memory_free}, {NULL, NULL}};

void ylmL_open_shade_grid(lua_State *L) {
  ylmL_type(L, MEMORY, memory_methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
