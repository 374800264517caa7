/* gltf.h - the reader of glTF for codec.c. */
#ifndef YLM_LUA_GLTF_H
#define YLM_LUA_GLTF_H

#include "../binding.h"

/* Adds its functions to the table on top. */
void ylmL_open_gltf(lua_State *L);

#endif
