/* traced.h - what the files that bind scenes share. Private to csrc/lua. */
#ifndef YLM_LUA_SCENE_TRACED_H
#define YLM_LUA_SCENE_TRACED_H

#include "../binding.h"
#include "ylm_scene.h"

/* The traced scene at `i`, open; raises otherwise. */
ylm_scene *ylmL_scene(lua_State *L, int i);
/* The n numbers of the table at `i`. */
void ylmL_scene_numbers(lua_State *L, int i, int n, double *x);

/* The lights at `i` as rays see them; the floats live in an array left on the stack. False without
   memory. */
bool ylmL_scene_lamps(lua_State *L, int i, ylm_scene_lamps *lamps);

#endif
