/* core.c - opens ylm.c.core: the binding of libylm.so. */
#include <string.h>
#include <unistd.h>

#include "../binding.h"

/* metatable(name) -> the metatable of an object type, or nil */
static int metatable(lua_State *L) {
  luaL_getmetatable(L, luaL_checkstring(L, 1));
  return 1;
}

/* type(value) -> the name of an object type of ylm, or nil */
static int object_type(lua_State *L) {
  if (lua_type(L, 1) != LUA_TUSERDATA || !lua_getmetatable(L, 1)) return 0;
  lua_getfield(L, -1, "__name");
  if (lua_type(L, -1) != LUA_TSTRING) return 0;
  lua_pushvalue(L, -1);
  lua_gettable(L, LUA_REGISTRYINDEX);
  if (!lua_rawequal(L, -1, -3)) return 0;
  lua_pop(L, 1);
  return 1;
}

/* The lists of words by name. */
static const struct {
  const char *name;
  const char *const *words;
} lists[] = {
#define X(name, ...) {#name, ylmL_##name##_choices},
    YLML_CHOICES(X) YLML_LISTS(X)
#undef X
};

/* Pushes a list of words, `first` (NULL: none) in front. */
static void push_words(lua_State *L, const char *const *words, const char *first) {
  int n = 0;
  lua_newtable(L);
  if (first) {
    lua_pushstring(L, first);
    lua_rawseti(L, -2, ++n);
  }
  for (; *words; words++) {
    if (first && strcmp(first, *words) == 0) continue;
    lua_pushstring(L, *words);
    lua_rawseti(L, -2, ++n);
  }
}

/* choices(name, first | nil) -> list of the words of an option, `first` in front; choices() -> all lists by name */
static int choices(lua_State *L) {
  const char *name = luaL_optstring(L, 1, NULL), *first = luaL_optstring(L, 2, NULL);
  if (!name) lua_newtable(L);
  for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
    if (name && strcmp(name, lists[i].name) != 0) continue;
    push_words(L, lists[i].words, first);
    if (name) return 1;
    lua_setfield(L, -2, lists[i].name);
  }
  if (name) luaL_argerror(L, 1, "no option has such a list");
  return 1;
}

/* info() -> version, kernel set in use, list of available sets, threads */
static int info(lua_State *L) {
  lua_pushliteral(L, YLM_VERSION);
  lua_pushstring(L, ylm_isa_name(ylm_isa_current()));
  lua_newtable(L);
  for (int i = 0, n = 0; i < YLM_ISA_COUNT; i++) {
    if (!ylm_isa_available((ylm_isa)i)) continue;
    lua_pushstring(L, ylm_isa_name((ylm_isa)i));
    lua_rawseti(L, -2, ++n);
  }
  lua_pushinteger(L, ylm_threads(0));
  return 4;
}

/* environment() -> true; nil, message, code where YLM_ISA or YLM_THREADS is not what it may be */
static int environment(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = ylm_environment_check(&e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* status(code name) -> "caller" | "world", sentence; nil if there is no such code */
static int status(lua_State *L) {
  const char *wanted = luaL_checkstring(L, 1);
  for (int i = 0; i < YLM_STATUS_COUNT; i++) {
    const char *name = ylm_status_name((ylm_status)i), *w = wanted;
    while (*name && *name == *w) name++, w++;
    if (*name != *w) continue;
    lua_pushstring(L, ylm_status_is_callers((ylm_status)i) ? "caller" : "world");
    lua_pushstring(L, ylm_status_text((ylm_status)i));
    return 2;
  }
  return 0;
}

/* no_memory(error) -> the sentence of what ylmL_no_memory raised; nil of any other value */
static int no_memory(lua_State *L) {
  lua_settop(L, 1);
  if (!lua_istable(L, 1) || !lua_getmetatable(L, 1)) return 0;
  luaL_getmetatable(L, YLM_NO_MEMORY);
  if (!lua_rawequal(L, 2, 3)) return 0;
  lua_getfield(L, 1, "message");
  return 1;
}

static int seconds(lua_State *L) {
  lua_pushnumber(L, (lua_Number)ylm_seconds());
  return 1;
}

/* is_terminal() -> is stderr a terminal? */
static int is_terminal(lua_State *L) {
  lua_pushboolean(L, isatty(STDERR_FILENO));
  return 1;
}

static const luaL_Reg functions[] = {{"metatable", metatable},
                                     {"type", object_type},
                                     {"info", info},
                                     {"environment", environment},
                                     {"status", status},
                                     {"seconds", seconds},
                                     {"is_terminal", is_terminal},
                                     {"no_memory", no_memory},
                                     {"choices", choices},
                                     {NULL, NULL}};

int luaopen_ylm_c_core(lua_State *L) {
  ylmL_check_abi(L);
  lua_newtable(L);
  luaL_setfuncs(L, functions, 0);
#define X(name) ylmL_open_##name(L);
  YLML_CORE_BINDINGS(X)
#undef X
  return 1;
}
