/* grid_set.c - ylm.grid_set: grids in bricks. lua/ylm/grid/set.lua. */
#include "grid.h"

#define SET_TYPE "ylm.grid_set"

/* The set at `i`; raises where it has been closed. */
static ylm_grid_set *set_check(lua_State *L, int i) {
  ylm_grid_set **s = ylmL_check(L, i, SET_TYPE);
  if (!*s) luaL_argerror(L, i, "the grid has been closed");
  return *s;
}

ylm_grid_set *ylmL_grid_set_test(lua_State *L, int i) {
  return ylmL_test(L, i, SET_TYPE) ? set_check(L, i) : NULL;
}

static const ylm_field *field_of(void *object) {
  ylm_grid_set **s = object;
  return *s ? ylm_grid_set_field(*s) : NULL;
}

/* grid_set_open(folder, bytes of the cache) -> set */
static int grid_set_open(lua_State *L) {
  ylm_error e = {0};
  const char *folder = luaL_checkstring(L, 1);
  size_t cache = (size_t)luaL_optnumber(L, 2, 0);
  ylm_grid_set **s = lua_newuserdata(L, sizeof *s);
  *s = NULL;
  luaL_getmetatable(L, SET_TYPE);
  lua_setmetatable(L, -2);
  return ylmL_result(L, 1, ylm_grid_set_open(folder, cache, s, &e), &e);
}

/* grid_set_look(set) -> form, stats with those of the set */
static int grid_set_look(lua_State *L) {
  const ylm_grid_set *s = set_check(L, 1);
  const ylm_grid_contents *v = ylm_grid_set_look(s);
  ylm_grid_set_stats t = ylm_grid_set_stats_of(s);
  ylmL_grid_push_form(L, &v->form);
  ylmL_grid_push_stats(L, &v->form, v->stats);
  ylmL_set_count(L, "bricks", t.bricks);
  ylmL_set_count(L, "brick_level", t.level);
  ylmL_set_count(L, "file_bytes", t.bytes);
  ylmL_set_count(L, "held", t.held);
  ylmL_set_count(L, "reads", t.reads);
  return 2;
}

/* grid_set_file(set, i) -> the path of brick i, 1 .. bricks, or of the top behind them; nil: there is none */
static int grid_set_file(lua_State *L) {
  char path[4096];
  size_t i = (size_t)luaL_checknumber(L, 2);
  if (i < 1 || !ylm_grid_set_file(set_check(L, 1), i - 1, path, sizeof path)) return 0;
  lua_pushstring(L, path);
  return 1;
}

/* grid_set_pack(set, threads, progress) -> grid */
static int grid_set_pack(lua_State *L) {
  ylmL_progress progress;
  lua_settop(L, 3);
  ylm_grid_set *set = set_check(L, 1);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  const ylm_progress *p = ylmL_progress_begin(L, 3, &progress);
  ylm_grid **g = ylmL_grid_new(L);
  ylm_error e = {0};
  ylm_status s = ylm_grid_set_pack(set, (int)luaL_checknumber(L, 2), p, g, &e);
  if (s == YLM_OK) ylmL_charge(L, ylm_grid_look(*g)->stats->bytes);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* grid_set_write(set, path, threads, progress) -> true */
static int grid_set_write(lua_State *L) {
  ylmL_progress progress;
  lua_settop(L, 4);
  ylm_grid_set *set = set_check(L, 1);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  const ylm_progress *p = ylmL_progress_begin(L, 4, &progress);
  ylm_error e = {0};
  ylm_status s =
      ylm_grid_set_write(set, luaL_checkstring(L, 2), (int)luaL_checknumber(L, 3), p, &e);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* grid_set_write_small(set, folder, tolerance or 0, bytes or 0, step or 0, threads, progress) -> bytes, report */
static int grid_set_write_small(lua_State *L) {
  lua_settop(L, 7);
  ylm_grid_set *set = set_check(L, 1);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylmL_progress progress;
  ylm_error e = {0};
  ylm_grid_small how = {.tolerance = luaL_checknumber(L, 3),
                        .bytes = (uint64_t)luaL_checknumber(L, 4),
                        .step = luaL_checknumber(L, 5),
                        .threads = (int)luaL_checknumber(L, 6),
                        .progress = ylmL_progress_begin(L, 7, &progress)};
  ylm_grid_small_report report;
  uint64_t bytes = 0;
  ylm_status s = ylm_grid_set_write_small(set, luaL_checkstring(L, 2), &how, &bytes, &report, &e);
  if (s == YLM_OK) {
    lua_pushnumber(L, (lua_Number)bytes);
    ylmL_grid_push_small(L, &report);
  }
  return ylmL_result_progress(L, 2, s, &e, &progress);
}

/* grid_set_small(set) -> the report of a folder of few bytes; nil: it is none */
static int grid_set_small(lua_State *L) {
  ylm_grid_small_report report;
  if (!ylm_grid_set_small_of(set_check(L, 1), &report)) return 0;
  ylmL_grid_push_small(L, &report);
  return 1;
}

/* grid_set_is_open(value) -> true for a set that has not been closed, false for a closed one, else nil */
static int grid_set_is_open(lua_State *L) {
  ylm_grid_set **s = ylmL_test(L, 1, SET_TYPE);
  if (!s) return 0;
  lua_pushboolean(L, *s != NULL);
  return 1;
}

static int grid_set_close(lua_State *L) {
  ylm_grid_set **s = ylmL_check(L, 1, SET_TYPE);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_grid_set_free(*s);
  *s = NULL;
  ylmL_disown(L, 1);
  return 0;
}

static const luaL_Reg functions[] = {
    {"grid_set_open", grid_set_open},   {"grid_set_look", grid_set_look},
    {"grid_set_file", grid_set_file},   {"grid_set_is_open", grid_set_is_open},
    {"grid_set_close", grid_set_close}, {"grid_set_pack", grid_set_pack},
    {"grid_set_write", grid_set_write}, {"grid_set_write_small", grid_set_write_small},
    {"grid_set_small", grid_set_small}, {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", grid_set_close}, {NULL, NULL}};

void ylmL_open_grid_set(lua_State *L) {
  ylmL_type(L, SET_TYPE, methods);
  ylmL_type_has_field(L, field_of);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
