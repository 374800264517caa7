/* shade.h - what the files that bind shading share. Private to csrc/lua. */
#ifndef YLM_LUA_SCENE_SHADE_H
#define YLM_LUA_SCENE_SHADE_H

#include "traced.h"
#include "ylm_shade.h"

#define YLML_SHADE_VIEW "ylm.view"

/* The view at `i`, open; raises otherwise. */
ylm_shade_view *ylmL_shade_view(lua_State *L, int i);
/* The option at `i`: "transfer" or "cosine". */
ylm_shade_weight ylmL_shade_weight(lua_State *L, int i);
/* How many shading points a view has. */
size_t ylmL_shade_points(const ylm_shade_view *v);
/* The float array at `i`, which must have that many elements, or a new one; on the stack's top.
   NULL: *s says why. */
ylmL_array *ylmL_shade_result(lua_State *L, int i, int axes, const size_t *shape, ylm_status *s);

#endif
