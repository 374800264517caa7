/* shade.h - what the files that bind shading share. Private to csrc/lua. */
#ifndef YLM_LUA_SCENE_SHADE_H
#define YLM_LUA_SCENE_SHADE_H

#include "../binding.h"
#include "ylm_shade.h"

#define YLML_SHADE_SCENE "ylm.shade_scene"
#define YLML_SHADE_VIEW "ylm.prepared"

/* The scene, the view at `i`, open; raises otherwise. */
ylm_shade_scene *ylmL_shade_scene(lua_State *L, int i);
ylm_shade_view *ylmL_shade_view(lua_State *L, int i);
/* How many shading points a view has. */
size_t ylmL_shade_points(const ylm_shade_view *v);
/* The n numbers of the table at `i`. */
void ylmL_shade_numbers(lua_State *L, int i, int n, double *x);
/* The float array at `i`, which must have that many elements, or a new one; on the stack's top.
   NULL: *s says why. */
ylmL_array *ylmL_shade_result(lua_State *L, int i, int axes, const size_t *shape, ylm_status *s);

/* Lamps as floats from double arrays at [n][3], radius [n], radiance [n][3] from i on, and of flat
   lamps, which may be nil, triangles [t][9], disks [d][7], radiance [t+d][3]; the floats live in an
   array left on the stack. False without memory. */
bool ylmL_shade_lamps(lua_State *L, int i, ylm_shade_lamps *lamps);

#endif
