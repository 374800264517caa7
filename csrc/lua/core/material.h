/* material.h - what the bindings of materials and of their tables share. Private. */
#ifndef YLM_LUA_MATERIAL_H
#define YLM_LUA_MATERIAL_H

#include "../binding.h"

/* n directions of length 1, [n][3] float, of rows [n][3] or one row for all; NULL (nil, message, code
   pushed): a row is zero, not finite or, where `above` is wanted, below the surface. */
ylmL_array *ylmL_unit_rows(lua_State *L, int i, size_t n, const char *name, bool above);

#endif
