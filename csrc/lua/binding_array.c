/* binding_array.c - ylm.array as every binding makes and checks it (functions: core/array.c). */
#include "binding.h"

#include <stdlib.h>
#include <string.h>

/* Elements shared by an array and its views; given back when the last of them goes. */
struct ylmL_block {
  size_t users;
  void (*give_back)(void *owner);
  void *owner;
};

void ylmL_array_close(ylmL_array *a) {
  if (a->block && --a->block->users == 0) {
    a->block->give_back(a->block->owner);
    free(a->block);
  }
  a->block = NULL;
  a->data = NULL;
}

/* An empty array object on the stack. */
static ylmL_array *push_object(lua_State *L) {
  ylmL_array *a = lua_newuserdata(L, sizeof *a);
  memset(a, 0, sizeof *a);
  luaL_getmetatable(L, YLM_ARRAY);
  lua_setmetatable(L, -2);
  return a;
}

ylmL_array *ylmL_array_share(lua_State *L, ylm_dtype t, int axes, const size_t *shape, void *data,
                             void (*give_back)(void *owner), void *owner) {
  size_t count;
  if (axes < 1 || axes > YLM_MAX_AXES || !ylm_shape_count(axes, shape, &count)) return NULL;
  ylmL_array *a = push_object(L);
  a->block = malloc(sizeof *a->block);
  if (!a->block) {
    lua_pop(L, 1);
    return NULL;
  }
  a->block->users = 1;
  a->block->give_back = give_back;
  a->block->owner = owner;
  a->data = data;
  a->dtype = t;
  a->axes = axes;
  memcpy(a->shape, shape, (size_t)axes * sizeof *shape);
  a->count = count;
  return a;
}

static ylmL_array *new_array(lua_State *L, ylm_dtype t, int axes, const size_t *shape, bool zero) {
  size_t count;
  if (axes < 1 || axes > YLM_MAX_AXES || !ylm_shape_count(axes, shape, &count)) return NULL;
  void *data =
      zero ? ylm_alloc_zero(count, ylm_numbers_size(t)) : ylm_alloc(count, ylm_numbers_size(t));
  ylmL_array *a = data ? ylmL_array_share(L, t, axes, shape, data, ylm_free, data) : NULL;
  if (!a)
    ylm_free(data);
  else
    ylmL_charge(L, count * ylm_numbers_size(t));
  return a;
}

ylmL_array *ylmL_array_new(lua_State *L, ylm_dtype t, int axes, const size_t *shape) {
  return new_array(L, t, axes, shape, true);
}

ylmL_array *ylmL_array_unset(lua_State *L, ylm_dtype t, int axes, const size_t *shape) {
  return new_array(L, t, axes, shape, false);
}

void ylmL_array_keep(lua_State *L, int i) {
  ylmL_array *a = lua_touserdata(L, -1);
  ylmL_own(L, lua_gettop(L));
  lua_pushvalue(L, i);
  lua_rawseti(L, -2, 1);
  lua_pop(L, 1);
  a->keeps = true;
}

ylmL_array *ylmL_array_result(lua_State *L, int given, ylm_dtype t, int axes, const size_t *shape,
                              ylm_status *s) {
  if (lua_isnil(L, given)) {
    ylmL_array *a = ylmL_array_new(L, t, axes, shape);
    size_t count;
    if (a) return a;
    *s = ylm_shape_count(axes, shape, &count) ? YLM_ENOMEM : YLM_EOVERFLOW;
    lua_pushnil(L);
    return NULL;
  }
  ylmL_array *a = ylmL_array_check(L, given);
  lua_pushvalue(L, given);
  bool fits = a->axes == axes && memcmp(a->shape, shape, (size_t)axes * sizeof *shape) == 0;
  if (a->dtype == t && fits) return a;
  *s = a->dtype != t ? YLM_ETYPE : YLM_ESHAPE;
  return NULL;
}

ylmL_array *ylmL_array_part(lua_State *L, int at, size_t k, int axes, const size_t *shape) {
  ylmL_array *parent = ylmL_array_any(L, at);
  ylmL_array *v = push_object(L);
  v->data = (char *)parent->data + k * ylm_numbers_size(parent->dtype);
  v->dtype = parent->dtype;
  v->convention = parent->convention;
  v->axes = axes;
  memcpy(v->shape, shape, (size_t)axes * sizeof *shape);
  ylm_shape_count(axes, shape, &v->count);
  v->block = parent->block;
  v->block->users++;
  if (parent->keeps) {
    ylmL_own(L, lua_gettop(L));
    ylmL_own(L, at);
    lua_rawgeti(L, -1, 1);
    lua_rawseti(L, -3, 1);
    lua_pop(L, 2);
    v->keeps = true;
  }
  return v;
}

ylmL_array *ylmL_array_any(lua_State *L, int i) {
  ylmL_array *a = ylmL_check(L, i, YLM_ARRAY);
  if (!a->data) luaL_argerror(L, i, "the array has been closed");
  return a;
}

/* Raises by check.fail of lua/ylm/check.lua, which finds the caller's line. */
static void refuse_type(lua_State *L, ylm_dtype t) {
  const char *wide = ylm_numbers_type_name(ylm_numbers_wide(t));
  lua_getglobal(L, "require");
  lua_pushliteral(L, "ylm.check");
  lua_call(L, 1, 1);
  lua_getfield(L, -1, "fail");
  lua_pushfstring(
      L, "an array of float or double expected, got one of %s: ylm.array(a, '%s') converts it",
      ylm_numbers_type_name(t), wide);
  lua_call(L, 1, 0);
}

ylmL_array *ylmL_array_check(lua_State *L, int i) {
  ylmL_array *a = ylmL_array_any(L, i);
  if (a->dtype != ylm_numbers_wide(a->dtype)) refuse_type(L, a->dtype);
  return a;
}

ylmL_array *ylmL_array_opt(lua_State *L, int i) {
  return lua_isnoneornil(L, i) ? NULL : ylmL_array_check(L, i);
}
