/* binding_grid.h - how a bake is asked for, of the processor or of a device: binding_grid.c,
   compiled into every binding. */
#ifndef YLM_LUA_BINDING_GRID_H
#define YLM_LUA_BINDING_GRID_H

#include "binding.h"
#include "ylm_grid.h"

#define YLM_GRID_TYPE "ylm.grid"

/* A grid object that holds nothing yet, on the stack. */
ylm_grid **ylmL_grid_new(lua_State *L);
/* The grid at `i`; raises where it has been closed or is being updated. */
ylm_grid *ylmL_grid_check(lua_State *L, int i);
/* The interpolation named at `i`. */
ylm_grid_interpolation ylmL_grid_interpolation(lua_State *L, int i);
/* The table at `i`, which lua/ylm/grid/bake.lua fills completely. */
ylm_grid_form ylmL_grid_form(lua_State *L, int i);
/* The quantity named by argument i, "lights" where it is nil. */
ylm_quantity ylmL_grid_quantity(lua_State *L, int i);
/* Surfaces from argument i, the bytes of a ylm_grid_walls; NULL where it is none. */
const ylm_grid_walls *ylmL_grid_walls(lua_State *L, int i, ylm_grid_walls *walls);
/* The triangles of the list of meshes at `i`, n of them, in a userdata left on the stack. */
const ylm_grid_mesh *ylmL_grid_meshes(lua_State *L, int i, size_t *n);
/* A source from the stack: 1 a table with `normals` of points, or nil, 3 occupied [n][3] | list of meshes, kept on the stack | nil, 4 seed, 5
 * threads, 6 max_points, 7 progress. */
ylm_grid_source ylmL_grid_source(lua_State *L, ylmL_progress *progress);

#endif
