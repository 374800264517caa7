/* binding_figure.h - the object types of csrc/figure, shared by core/figure*.c and vtk/. */
#ifndef YLM_LUA_FIGURE_H
#define YLM_LUA_FIGURE_H

#include "binding.h"
#include "ylm_figure.h"

#define YLM_SHAPE "ylm.shape"
#define YLM_VOLUME "ylm.volume"
#define YLM_CANVAS "ylm.canvas"

/* Element pointer and row count of a double array whose rows have `width` numbers; raises. */
static inline const double *ylmL_doubles(lua_State *L, int i, size_t width, size_t *rows) {
  ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_DOUBLE || a->count % width != 0)
    luaL_argerror(L, i, "an array of doubles with rows of another width expected");
  if (rows) *rows = a->count / width;
  return a->data;
}

/* ylmL_doubles, but NULL for nil; raises where the row count is not `rows`. */
static inline const double *ylmL_doubles_of(lua_State *L, int i, size_t width, size_t rows) {
  size_t n;
  if (lua_isnoneornil(L, i)) return NULL;
  const double *p = ylmL_doubles(L, i, width, &n);
  if (n != rows) luaL_argerror(L, i, "an array with as many rows as the first expected");
  return p;
}

/* n numbers from the plain table at `i`. */
static inline void ylmL_numbers(lua_State *L, int i, int n, double *out) {
  luaL_checktype(L, i, LUA_TTABLE);
  for (int k = 0; k < n; k++) {
    lua_rawgeti(L, i, k + 1);
    out[k] = (double)lua_tonumber(L, -1);
    lua_pop(L, 1);
  }
}

/* Cells from i on: origin, size, level | nil, drawn | nil, corner | nil. */
static inline ylm_figure_cells ylmL_cells(lua_State *L, int i) {
  ylm_figure_cells c = {0, NULL, NULL, NULL, NULL, NULL};
  c.origin = ylmL_doubles(L, i, 3, &c.n);
  c.size = ylmL_doubles_of(L, i + 1, 3, c.n);
  c.level = ylmL_doubles_of(L, i + 2, 1, c.n);
  c.drawn = ylmL_doubles_of(L, i + 3, 1, c.n);
  c.corner = ylmL_doubles_of(L, i + 4, 8, c.n);
  return c;
}

/* Pushes {x0, y0, z0, x1, y1, z1}. */
static inline void ylmL_push_bounds(lua_State *L, const double b[6]) {
  lua_createtable(L, 6, 0);
  for (int i = 0; i < 6; i++) {
    lua_pushnumber(L, b[i]);
    lua_rawseti(L, -2, i + 1);
  }
}

/* The scale at i, i+1, i+2, i+3: map name, least, largest, logarithmic. */
static inline ylm_figure_scale ylmL_scale(lua_State *L, int i) {
  ylm_figure_scale s = {luaL_checkstring(L, i), (double)luaL_checknumber(L, i + 1),
                        (double)luaL_checknumber(L, i + 2), lua_toboolean(L, i + 3)};
  return s;
}

#endif
