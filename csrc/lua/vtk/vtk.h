/* vtk.h - functions of this room that vtk.c registers. */
#ifndef YLM_LUA_DRAWING_H
#define YLM_LUA_DRAWING_H

#include "../binding_choices.h"

#include <lauxlib.h>
#include <lua.h>

#define YLM_VTK_SCENE "ylm.vtk.scene"

/* Entries of the table at i: a number, `otherwise` where it is missing; whether it is true; the place of its word in
   `words`, the first where it is missing. */
static inline double ylmL_vtk_number(lua_State *L, int i, const char *name, double otherwise) {
  lua_getfield(L, i, name);
  double x = lua_isnil(L, -1) ? otherwise : (double)lua_tonumber(L, -1);
  lua_pop(L, 1);
  return x;
}

static inline int ylmL_vtk_choice(lua_State *L, int i, const char *name, const char *const *words) {
  lua_getfield(L, i, name);
  int k = luaL_checkoption(L, -1, words[0], words);
  lua_pop(L, 1);
  return k;
}

static inline int ylmL_vtk_is_true(lua_State *L, int i, const char *name) {
  lua_getfield(L, i, name);
  int yes = lua_toboolean(L, -1);
  lua_pop(L, 1);
  return yes;
}

int ylmL_vtk_plot(lua_State *L);
int ylmL_vtk_save_pdf(lua_State *L);
int ylmL_vtk_show(lua_State *L);
int ylmL_vtk_live(lua_State *L);
/* Registers the type of windows. */
void ylmL_vtk_open_live(lua_State *L);

#endif
