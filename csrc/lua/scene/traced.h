/* traced.h - what the files that bind scenes share. Private to csrc/lua. */
#ifndef YLM_LUA_SCENE_TRACED_H
#define YLM_LUA_SCENE_TRACED_H

#include "../binding.h"
#include "ylm_scene.h"

/* The traced scene at `i`, open; raises otherwise. */
ylm_scene *ylmL_scene(lua_State *L, int i);
/* The n numbers of the table at `i`. */
void ylmL_scene_numbers(lua_State *L, int i, int n, double *x);
/* For entries of a struct (ylmL_read): a traced scene, const ylm_scene *; a camera, ylm_camera, of a list of ten numbers: from,
   at, up, fov. */
void ylmL_read_scene(lua_State *L, int i, void *field);
void ylmL_read_camera(lua_State *L, int i, void *field);

/* The lights at `i` as rays see them, relative to an origin (NULL: 0); the floats live in an array left on the stack.
   False without memory. */
bool ylmL_scene_lamps(lua_State *L, int i, const double *origin, ylm_scene_lamps *lamps);

/* Places of the world, an array [n][3] at `i`, relative to an origin (NULL: 0); may leave memory on the stack. */
const float (*ylmL_scene_places(lua_State *L, int i, const double *origin, size_t *n))[3];
/* Pushes n places relative to an origin as those of the world: float, or double where the origin is not NULL. False
   without memory. */
bool ylmL_scene_push_places(lua_State *L, const double *origin, size_t n, const float *x);
/* The places of the points [n][3] at `i` with the normals behind, in memory of the state; NULL: nil, message, code are
   pushed. surface.c */
ylm_scene_place *ylmL_scene_read_surfaces(lua_State *L, int i, const ylm_scene *scene, size_t *n);
/* Numbers in an array of floats, from 0 as integers, become floats from 1; UINT32_MAX: 0. surface.c */
void ylmL_from_one(ylmL_array *a);
/* Pushes the points [n][3] of places in the world and their normals, float [n][3], above room of its own; false: no memory.
   surface.c */
bool ylmL_scene_push_surfaces(lua_State *L, const ylm_scene *scene, size_t n,
                              const ylm_scene_place *place);

/* For entries of a struct (ylmL_read): what paths keep of a scene, ylm_path_guides *, nothing yet where path_guides() made it. */
void ylmL_guides_read(lua_State *L, int i, void *field);

/* Pushes a fingerprint: 16 digits. */
void ylmL_scene_push_print(lua_State *L, uint64_t print);

#endif
