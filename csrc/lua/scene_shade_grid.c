/* scene_shade_grid.c - shading by grids. */
#include <string.h>

#include "scene_shade.h"

static const ylm_grid *check_grid(lua_State *L, int i) {
  ylm_grid **g = ylmL_check(L, i, "ylm.grid");
  if (!*g) luaL_argerror(L, i, "the grid has been closed");
  if (ylm_grid_updating(*g)) luaL_argerror(L, i, "the grid is being updated");
  return *g;
}

static size_t point_count(const ylm_shade_view *v) {
  ylm_shade_stats stats;
  ylm_shade_view_stats(v, &stats);
  return stats.points;
}

/* shade_grid(view, grid, "hermite" | "taylor" | "linear", threads, progress)
   -> radiance [n][3], outside, unbaked, seconds */
static int shade_grid(lua_State *L) {
  static const char *const names[] = {"hermite", "taylor", "linear", NULL};
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_grid *g = check_grid(L, 2);
  ylm_grid_interpolation how = (ylm_grid_interpolation)luaL_checkoption(L, 3, "hermite", names);
  int threads = (int)luaL_checknumber(L, 4);
  ylm_grid_report report = {0};
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 5);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){point_count(v), 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  const ylm_progress *progress = ylmL_progress_begin(L, 5, &p);
  ylm_status s = ylm_shade_grid(v, g, how, threads, progress, out->data, &report, &e);
  if (s == YLM_OK) {
    ylmL_push_count(L, report.outside);
    ylmL_push_count(L, report.unbaked);
    lua_pushnumber(L, (lua_Number)report.seconds);
  }
  return ylmL_result_progress(L, 4, s, &e, &p);
}

/* shade_grid_cells(view, grid, threads) -> level [n], error [n] */
static int shade_grid_cells(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_grid *g = check_grid(L, 2);
  int threads = (int)luaL_checknumber(L, 3);
  size_t n = point_count(v);
  ylmL_array *level = ylmL_array_new(L, YLM_FLOAT, 1, &n);
  ylmL_array *error = level ? ylmL_array_new(L, YLM_FLOAT, 1, &n) : NULL;
  if (!error) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 2, ylm_shade_grid_cells(v, g, threads, level->data, error->data), NULL);
}

static const luaL_Reg functions[] = {
    {"shade_grid", shade_grid}, {"shade_grid_cells", shade_grid_cells}, {NULL, NULL}};

void ylmL_open_shade_grid(lua_State *L) { luaL_setfuncs(L, functions, 0); }
