/*
** grid.h - what the files that bind grids share, beside binding_grid.h. Private to csrc/lua.
*/
#ifndef YLM_LUA_CORE_GRID_H
#define YLM_LUA_CORE_GRID_H

#include "../binding_grid.h"

/* The report of the last update, as a table on the stack. */
void ylmL_grid_push_update(lua_State *L, const ylm_grid_form *f, const ylm_grid_stats *s);
/* The description of a grid, and its stats; times that are NaN are left out. */
void ylmL_grid_push_form(lua_State *L, const ylm_grid_form *f);
/* The report of a grid of few bytes: a table. */
void ylmL_grid_push_small(lua_State *L, const ylm_grid_small_report *r);
void ylmL_grid_push_stats(lua_State *L, const ylm_grid_form *f, const ylm_grid_stats *s);
/* The grid in bricks at `i`, NULL for other values; raises where it has been closed. */
ylm_grid_set *ylmL_grid_set_test(lua_State *L, int i);

#endif
