/* own.c - the own tables of objects, for lua/ylm. */
#include "../binding.h"

/* The field of an own table with the tables of pairs, by the other object. */
#define PARTNERS "partners"

/* Raises where the value at `i` is one that nothing can be kept of. */
static void check_owner(lua_State *L, int i) {
  int t = lua_type(L, i);
  if (t != LUA_TUSERDATA && t != LUA_TTABLE && t != LUA_TFUNCTION)
    luaL_argerror(L, i, "an object, a table or a function expected");
}

/* own(object) -> its own table, a new one where there is none. Of an object of ylm it stands beside the object, until that is
   closed; of a table or a function it lasts as long as that. */
static int own(lua_State *L) {
  lua_settop(L, 1);
  check_owner(L, 1);
  ylmL_own(L, 1);
  return 1;
}

/* owned(value, field) -> that field of the value's own table; nil where there is none. Makes no table. */
static int owned(lua_State *L) {
  lua_settop(L, 2);
  int t = lua_type(L, 1);
  bool owner = t == LUA_TUSERDATA || t == LUA_TTABLE || t == LUA_TFUNCTION;
  if (!owner || !ylmL_owned(L, 1)) {
    lua_pushnil(L);
    return 1;
  }
  lua_pushvalue(L, 2);
  lua_rawget(L, -2);
  return 1;
}

/* Adds the tables of pairs, of none so far, to the own table on top of the stack; pushes them. */
static void add_partners(lua_State *L) {
  lua_newtable(L);
  lua_createtable(L, 0, 1);
  lua_pushliteral(L, "k");
  lua_setfield(L, -2, "__mode");
  lua_setmetatable(L, -2);
  lua_pushvalue(L, -1);
  lua_setfield(L, -3, PARTNERS);
}

/* between(object, other) -> the table of both, a new one where there is none; it lasts as long as both, and as the object's own
   table. */
static int between(lua_State *L) {
  lua_settop(L, 2);
  check_owner(L, 1);
  check_owner(L, 2);
  ylmL_own(L, 1);
  lua_getfield(L, 3, PARTNERS);
  if (lua_isnil(L, 4)) {
    lua_pop(L, 1);
    add_partners(L);
  }
  lua_pushvalue(L, 2);
  lua_rawget(L, 4);
  if (lua_istable(L, 5)) return 1;
  lua_newtable(L);
  lua_pushvalue(L, 2);
  lua_pushvalue(L, -2);
  lua_rawset(L, 4);
  return 1;
}

/* partners(object) -> list of those that it has a table with */
static int partners(lua_State *L) {
  lua_settop(L, 1);
  check_owner(L, 1);
  lua_newtable(L);
  if (!ylmL_owned(L, 1)) return 1;
  lua_getfield(L, 3, PARTNERS);
  if (lua_isnil(L, 4)) {
    lua_settop(L, 2);
    return 1;
  }
  int n = 0;
  for (lua_pushnil(L); lua_next(L, 4); lua_pop(L, 1)) {
    lua_pushvalue(L, -2);
    lua_rawseti(L, 2, ++n);
  }
  lua_settop(L, 2);
  return 1;
}

static const luaL_Reg functions[] = {
    {"own", own}, {"owned", owned}, {"between", between}, {"partners", partners}, {NULL, NULL}};

void ylmL_open_own(lua_State *L) { luaL_setfuncs(L, functions, 0); }
