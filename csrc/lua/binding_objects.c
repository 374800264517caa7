/*
** binding_objects.c - images, meshes and materials as Lua objects; arrays over their memory keep
** them alive.
*/
#include "binding.h"
#include "ylm_geom.h"
#include "ylm_image.h"
#include "ylm_light.h"
#include "ylm_material.h"

#include <stdlib.h>

/* A C object shared by its userdata and the arrays over it. */
typedef struct shared {
  void *object;
  void (*destroy)(void *object);
  size_t users;
} shared;

static void let_go(void *owner) {
  shared *s = owner;
  if (!s || --s->users > 0) return;
  if (s->object) s->destroy(s->object);
  free(s);
}

int ylmL_object_close(lua_State *L) {
  shared **u = lua_touserdata(L, 1);
  if (u) {
    let_go(*u);
    *u = NULL;
    ylmL_disown(L, 1);
  }
  return 0;
}

static const luaL_Reg methods[] = {{"__gc", ylmL_object_close}, {NULL, NULL}};

static shared *new_object(lua_State *L, const char *type, void (*destroy)(void *)) {
  shared **u = lua_newuserdata(L, sizeof *u);
  *u = NULL;
  ylmL_type(L, type, methods);
  lua_setmetatable(L, -2);
  *u = calloc(1, sizeof **u);
  if (!*u) ylmL_no_memory(L, NULL);
  (*u)->destroy = destroy;
  (*u)->users = 1;
  return *u;
}

static shared *check_object(lua_State *L, int i, const char *type) {
  shared *s = *(shared **)ylmL_check(L, i, type);
  if (!s || !s->object) luaL_argerror(L, i, "the object has been closed");
  return s;
}

static void destroy_image(void *image) { ylm_image_free(image); }
static void destroy_mesh(void *mesh) { ylm_mesh_free(mesh); }
static void destroy_material(void *material) { ylm_material_free(material); }
static void destroy_texture(void *texture) { ylm_texture_free(texture); }

ylm_image **ylmL_image_new(lua_State *L) {
  return (ylm_image **)(void *)&new_object(L, YLM_IMAGE, destroy_image)->object;
}

ylm_image *ylmL_image_check(lua_State *L, int i) { return check_object(L, i, YLM_IMAGE)->object; }

ylm_mesh **ylmL_mesh_new(lua_State *L) {
  return (ylm_mesh **)(void *)&new_object(L, YLM_MESH, destroy_mesh)->object;
}

ylm_mesh *ylmL_mesh_check(lua_State *L, int i) { return check_object(L, i, YLM_MESH)->object; }

const float *ylmL_mesh_floats(lua_State *L, const ylm_mesh *m) {
  bool far = ylm_mesh_is_far(m);
  float *copy = lua_newuserdata(L, far ? 12 * m->vertices : 1);
  for (size_t i = 0; far && i < 3 * m->vertices; i++)
    copy[i] = (float)(m->origin[i % 3] + m->position[i]);
  return far ? copy : m->position;
}

ylm_material **ylmL_material_new(lua_State *L) {
  return (ylm_material **)(void *)&new_object(L, YLM_MATERIAL, destroy_material)->object;
}

ylm_material *ylmL_material_check(lua_State *L, int i) {
  return check_object(L, i, YLM_MATERIAL)->object;
}

ylm_texture **ylmL_texture_new(lua_State *L) {
  return (ylm_texture **)(void *)&new_object(L, YLM_TEXTURE, destroy_texture)->object;
}

ylm_texture *ylmL_texture_check(lua_State *L, int i) {
  return check_object(L, i, YLM_TEXTURE)->object;
}

ylmL_array *ylmL_object_array(lua_State *L, int i, ylm_dtype t, int axes, const size_t *shape,
                              void *data) {
  shared *s = *(shared **)lua_touserdata(L, i);
  s->users++;
  ylmL_array *a = ylmL_array_share(L, t, axes, shape, data, let_go, s);
  if (!a) {
    s->users--;
    ylmL_no_memory(L, NULL);
  }
  return a;
}

ylmL_occluder *ylmL_occluder_push(lua_State *L, const ylmL_occluder_kind *kind) {
  ylmL_occluder *o = lua_newuserdata(L, sizeof *o);
  *o = (ylmL_occluder){NULL, kind};
  luaL_getmetatable(L, YLML_OCCLUDER);
  lua_setmetatable(L, -2);
  return o;
}

struct ylm_light_set *ylmL_lights_check(lua_State *L, int i) {
  struct ylm_light_set *set = *(struct ylm_light_set **)ylmL_check(L, i, YLM_LIGHTS);
  if (!set) luaL_argerror(L, i, "the lights have been closed");
  return set;
}

static int free_surfaces(lua_State *L) {
  ylm_light_surfaces_free(lua_touserdata(L, 1));
  return 0;
}

static const luaL_Reg surfaces_methods[] = {{"__gc", free_surfaces}, {NULL, NULL}};

ylm_light_surfaces *ylmL_light_surfaces(lua_State *L, int i, size_t tiles) {
  const ylm_light_set *set = ylmL_lights_check(L, i);
  ylm_light_surfaces *s = lua_newuserdata(L, sizeof *s);
  *s = (ylm_light_surfaces){0};
  ylmL_type(L, "ylm.light_surfaces", surfaces_methods);
  lua_setmetatable(L, -2);
  return ylm_light_set_surfaces(set, tiles, s) == YLM_OK ? s : NULL;
}
