/* vtk.h - functions of this room that vtk.c registers. */
#ifndef YLM_LUA_DRAWING_H
#define YLM_LUA_DRAWING_H

#include <lua.h>

#define YLM_VTK_SCENE "ylm.vtk.scene"

int ylmL_vtk_plot(lua_State *L);
int ylmL_vtk_save_pdf(lua_State *L);
int ylmL_vtk_show(lua_State *L);

#endif
