/* shade_part.c - parts of views, and what paths say of them. */
#include "shade.h"

/* shade_part(view, pixels: a list of numbers from 0) -> view */
static int shade_part(lua_State *L) {
  ylm_shade_view *whole = ylmL_shade_view(L, 1);
  luaL_checktype(L, 2, LUA_TTABLE);
  size_t n = lua_rawlen(L, 2);
  ylm_error e = {0};
  uint32_t *pixel = lua_newuserdata(L, (n + 1) * sizeof *pixel);
  for (size_t i = 0; i < n; i++) {
    lua_rawgeti(L, 2, (int)i + 1);
    pixel[i] = (uint32_t)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  ylm_shade_view **v = lua_newuserdata(L, sizeof *v);
  *v = NULL;
  luaL_getmetatable(L, YLML_SHADE_VIEW);
  lua_setmetatable(L, -2);
  return ylmL_result(L, 1, ylm_shade_view_part(whole, n, pixel, v, &e), &e);
}

/* shade_judge(view, {samples, first, last, error, seed, threads, progress})
   -> mean [n][3], variance [n][3], rays */
static int shade_judge(lua_State *L) {
  static const char *const names[] = {"samples", "first",   "last",     "error",
                                      "seed",    "threads", "progress", NULL};
  enum { SAMPLES = 3, FIRST, LAST, ERROR, SEED, THREADS, PROGRESS };
  ylmL_named(L, 2, names);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylm_path_options o = {.samples = (int)luaL_checknumber(L, SAMPLES),
                        .first = (int)luaL_checknumber(L, FIRST),
                        .last = (int)luaL_checknumber(L, LAST),
                        .error = (double)luaL_optnumber(L, ERROR, 0),
                        .seed = (uint64_t)luaL_checknumber(L, SEED),
                        .threads = (int)luaL_optnumber(L, THREADS, 0),
                        .progress = ylmL_progress_begin(L, PROGRESS, &p)};
  size_t shape[] = {ylmL_shade_points(v), 3};
  ylmL_array *mean = ylmL_array_new(L, YLM_FLOAT, 2, shape);
  ylmL_array *variance = mean ? ylmL_array_new(L, YLM_FLOAT, 2, shape) : NULL;
  ylm_path_stats stats = {0};
  if (!variance) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_shade_judge(v, &o, mean->data, variance->data, &stats, &e);
  ylmL_push_count(L, stats.nearest_rays + stats.lamp_rays + stats.shadow_rays);
  return ylmL_result_progress(L, 3, s, &e, &p);
}

/* Float rows [points][3] of a view at `i`; NULL: they are not. */
static const float *rows(lua_State *L, int i, const ylm_shade_view *v) {
  ylmL_array *a = ylmL_array_check(L, i);
  return a->dtype == YLM_FLOAT && a->count == 3 * ylmL_shade_points(v) ? a->data : NULL;
}

/* shade_compare(view, a [n][3], b [n][3], variance [n][3] or nil) -> { pixels, mean, square, uncertainty,
   edges } */
static int shade_compare(lua_State *L) {
  const ylm_shade_view *v = ylmL_shade_view(L, 1);
  const float *a = rows(L, 2, v), *b = rows(L, 3, v);
  const float *variance = lua_isnoneornil(L, 4) ? NULL : rows(L, 4, v);
  ylm_shade_error out;
  if (!a || !b || (!variance && !lua_isnoneornil(L, 4))) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_status s = ylm_shade_compare(v, a, b, variance, &out);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  lua_newtable(L);
  ylmL_set_count(L, "pixels", out.pixels);
  ylmL_set_number(L, "mean", out.mean);
  ylmL_set_number(L, "square", out.square);
  ylmL_set_number(L, "uncertainty", out.uncertainty);
  ylmL_set_number(L, "edges", out.edges);
  return 1;
}

static const luaL_Reg functions[] = {{"shade_part", shade_part},
                                     {"shade_judge", shade_judge},
                                     {"shade_compare", shade_compare},
                                     {NULL, NULL}};

void ylmL_open_shade_part(lua_State *L) { luaL_setfuncs(L, functions, 0); }
