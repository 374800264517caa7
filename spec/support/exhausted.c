/*
** exhausted.c - aligned memory runs out for a while: LD_PRELOADed, and a Lua module of the same process.
**
**   local exhausted = require "exhausted"
**   exhausted.between(a, b)   requests number a to b from here on fail; 0, 0: none
**   exhausted.requests()      requests since then
**
** All memory of grids and lights is aligned (csrc/base/memory.c).
*/
#define _GNU_SOURCE
#include <dlfcn.h>
#include <lua.h>
#include <stddef.h>

static long seen, first, last; /* for one thread */

void *aligned_alloc(size_t align, size_t size);
void *aligned_alloc(size_t align, size_t size) {
  static void *(*real)(size_t, size_t);
  if (!real) real = (void *(*)(size_t, size_t))dlsym(RTLD_NEXT, "aligned_alloc");
  seen++;
  return seen >= first && seen <= last ? NULL : real(align, size);
}

static int between(lua_State *L) {
  seen = 0;
  first = (long)lua_tonumber(L, 1);
  last = (long)lua_tonumber(L, 2);
  return 0;
}

static int requests(lua_State *L) {
  lua_pushnumber(L, (lua_Number)seen);
  return 1;
}

int luaopen_exhausted(lua_State *L);
int luaopen_exhausted(lua_State *L) {
  lua_createtable(L, 0, 2);
  lua_pushcclosure(L, between, 0);
  lua_setfield(L, -2, "between");
  lua_pushcclosure(L, requests, 0);
  lua_setfield(L, -2, "requests");
  return 1;
}
