/* traced.h - what the files that bind scenes share. Private to csrc/lua. */
#ifndef YLM_LUA_SCENE_TRACED_H
#define YLM_LUA_SCENE_TRACED_H

#include "../binding.h"
#include "ylm_scene.h"

/* The traced scene at `i`, open; raises otherwise. */
ylm_scene *ylmL_scene(lua_State *L, int i);
/* The n numbers of the table at `i`. */
void ylmL_scene_numbers(lua_State *L, int i, int n, double *x);

/* Lamps as floats from double arrays at [n][3], radius [n], radiance [n][3] from i on, and of flat
   lamps, which may be nil, triangles [t][9], disks [d][7], radiance [t+d][3]; the floats live in an
   array left on the stack. False without memory. */
bool ylmL_scene_lamps(lua_State *L, int i, ylm_scene_lamps *lamps);

#endif
