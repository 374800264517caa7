/* binding_own.c - what Lua keeps of an object: the object's own table. */
#include "binding.h"

#include <string.h>

/* The table that stands beside a userdata: its environment, or its user value. */
#if LUA_VERSION_NUM < 502
#define get_beside lua_getfenv
#define set_beside lua_setfenv
#elif LUA_VERSION_NUM < 504
#define get_beside lua_getuservalue
#define set_beside lua_setuservalue
#else
#define get_beside(L, i) lua_getiuservalue(L, i, 1)
#define set_beside(L, i) lua_setiuservalue(L, i, 1)
#endif

/* The metatable of own tables: an environment of 5.1 may be another table. */
#define OWN "ylm.own"
/* The table of the registry with own tables by values that have no place beside them. */
#define OWNED "ylm.owned"

void ylmL_weak(lua_State *L, const char *name) {
  lua_getfield(L, LUA_REGISTRYINDEX, name);
  if (lua_istable(L, -1)) return;
  lua_pop(L, 1);
  lua_newtable(L);
  lua_createtable(L, 0, 1);
  lua_pushliteral(L, "k");
  lua_setfield(L, -2, "__mode");
  lua_setmetatable(L, -2);
  lua_pushvalue(L, -1);
  lua_setfield(L, LUA_REGISTRYINDEX, name);
}

/* Is the value on top of the stack an own table? */
static bool is_own(lua_State *L) {
  if (!lua_istable(L, -1) || !lua_getmetatable(L, -1)) return false;
  luaL_getmetatable(L, OWN);
  bool own = lua_rawequal(L, -1, -2);
  lua_pop(L, 2);
  return own;
}

/* Is the value at `i` a userdata of an object type of ylm? */
static bool is_object(lua_State *L, int i) {
  if (lua_type(L, i) != LUA_TUSERDATA || !lua_getmetatable(L, i)) return false;
  lua_getfield(L, -1, "__name");
  bool named = lua_type(L, -1) == LUA_TSTRING && strncmp(lua_tostring(L, -1), "ylm.", 4) == 0;
  if (named) {
    lua_gettable(L, LUA_REGISTRYINDEX);
    named = lua_rawequal(L, -1, -2);
  }
  lua_pop(L, 2);
  return named;
}

bool ylmL_owned(lua_State *L, int i) {
  if (is_object(L, i))
    get_beside(L, i);
  else {
    ylmL_weak(L, OWNED);
    lua_pushvalue(L, i);
    lua_rawget(L, -2);
    lua_remove(L, -2);
  }
  if (is_own(L)) return true;
  lua_pop(L, 1);
  return false;
}

void ylmL_own(lua_State *L, int i) {
  luaL_checkstack(L, 6, "own");
  if (ylmL_owned(L, i)) return;
  lua_newtable(L);
  luaL_newmetatable(L, OWN);
  lua_setmetatable(L, -2);
  bool object = is_object(L, i);
  if (!object) {
    ylmL_weak(L, OWNED);
    lua_pushvalue(L, i);
  }
  lua_pushvalue(L, object ? -1 : -3);
  if (object)
    set_beside(L, i);
  else {
    lua_rawset(L, -3);
    lua_pop(L, 1);
  }
}

void ylmL_disown(lua_State *L, int i) {
  if (!ylmL_owned(L, i)) return;
  lua_pop(L, 1);
#if LUA_VERSION_NUM < 502
  lua_pushvalue(L, LUA_GLOBALSINDEX);
#else
  lua_pushnil(L);
#endif
  set_beside(L, i);
}
