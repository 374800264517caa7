/* page.c - pages of lines, areas and words, for lua/ylm/plot. */
#include "../binding_figure.h"
#include "vtk.h"
#include "ylm_vtk.h"

#include <string.h>

/* Numbers of the list `points` of the mark at i, or of its x and y; the list `room` of userdata keeps them. */
static void places(lua_State *L, int i, int room, ylm_vtk_mark *m) {
  lua_getfield(L, i, "points");
  size_t count = lua_istable(L, -1) ? lua_rawlen(L, -1) : 2;
  double *xy = lua_newuserdata(L, (count + 2) * sizeof *xy);
  lua_rawseti(L, room, (int)lua_rawlen(L, room) + 1);
  if (lua_istable(L, -1)) {
    ylmL_numbers(L, lua_gettop(L), (int)count, xy);
  } else {
    xy[0] = ylmL_vtk_number(L, i, "x", 0);
    xy[1] = ylmL_vtk_number(L, i, "y", 0);
  }
  lua_pop(L, 1);
  m->xy = xy;
  m->n = count / 2;
}

static void read_mark(lua_State *L, int i, int room, ylm_vtk_mark *m) {
  memset(m, 0, sizeof *m);
  places(L, i, room, m);
  lua_getfield(L, i, "text");
  m->text = lua_tostring(L, -1); /* the table keeps it */
  lua_pop(L, 1);
  m->dash = ylmL_vtk_choice(L, i, "dash", ylmL_dash_choices);
  m->size = ylmL_vtk_number(L, i, "size", 12);
  m->width = ylmL_vtk_number(L, i, "width", 1);
  m->bold = ylmL_vtk_is_true(L, i, "bold");
  m->fill = ylmL_vtk_is_true(L, i, "fill");
  lua_getfield(L, i, "colour");
  ylmL_numbers(L, lua_gettop(L), 3, m->colour);
  lua_rawgeti(L, -1, 4);
  m->colour[3] = lua_isnil(L, -1) ? 1 : (double)lua_tonumber(L, -1);
  lua_pop(L, 2);
}

/* save_pdf(path, width, height, marks) -> true; marks as lua/ylm/plot/lines.lua makes them */
int ylmL_vtk_save_pdf(lua_State *L) {
  ylm_error e;
  const char *path = luaL_checkstring(L, 1);
  int width = (int)luaL_checkinteger(L, 2), height = (int)luaL_checkinteger(L, 3);
  luaL_checktype(L, 4, LUA_TTABLE);
  lua_settop(L, 4);
  size_t n = lua_rawlen(L, 4);
  ylm_vtk_mark *marks = lua_newuserdata(L, (n + 1) * sizeof *marks);
  lua_newtable(L);
  for (size_t k = 0; k < n; k++) {
    lua_rawgeti(L, 4, (int)k + 1);
    luaL_checktype(L, 7, LUA_TTABLE);
    read_mark(L, 7, 6, &marks[k]);
    lua_settop(L, 6);
  }
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, ylm_vtk_save_pdf(path, width, height, n, marks, &e), &e);
}
