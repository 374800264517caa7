/* binding.c - compiled into every binding: results, types, progress, the ABI guard. */
#include "binding.h"
#include "ylm_pace.h"

#include <string.h>

#if LUA_VERSION_NUM < 502
/* Absent from 5.1 and LuaJIT without 5.2 compatibility; present where this object must not run. */
extern void luaL_checkversion_(lua_State *L, lua_Number v) __attribute__((weak));
#endif

void ylmL_check_abi(lua_State *L) {
#if LUA_VERSION_NUM >= 502
  luaL_checkversion(L);
#else
  if (luaL_checkversion_) {
    /* Calling into a state of another layout is unsafe; an error by message alone is not. */
    lua_pushliteral(L, "ylm: this binding was built for Lua 5.1; set LUA_CPATH to build/luaX.Y");
    lua_error(L);
  }
#endif
}

bool ylmL_toint64(lua_State *L, int i, int64_t *out) {
  if (lua_type(L, i) != LUA_TNUMBER) return false;
  double x = (double)lua_tonumber(L, i);
  if (!(x >= -9007199254740992.0 && x <= 9007199254740992.0) || x != (double)(int64_t)x)
    return false;
  *out = (int64_t)x;
  return true;
}

void ylmL_push_count(lua_State *L, uint64_t n) { lua_pushinteger(L, (lua_Integer)n); }

void ylmL_set_count(lua_State *L, const char *name, uint64_t n) {
  ylmL_push_count(L, n);
  lua_setfield(L, -2, name);
}

void ylmL_set_number(lua_State *L, const char *name, double x) {
  lua_pushnumber(L, (lua_Number)x);
  lua_setfield(L, -2, name);
}

void ylmL_set_boolean(lua_State *L, const char *name, bool x) {
  lua_pushboolean(L, x);
  lua_setfield(L, -2, name);
}

int ylmL_no_memory(lua_State *L, const char *text) {
  lua_createtable(L, 0, 1);
  lua_pushstring(L, text ? text : ylm_status_text(YLM_ENOMEM));
  lua_setfield(L, -2, "message");
  ylmL_type(L, YLM_NO_MEMORY, NULL);
  lua_setmetatable(L, -2);
  return lua_error(L);
}

int ylmL_result(lua_State *L, int n, ylm_status s, const ylm_error *e) {
  if (s == YLM_OK) return n;
  const char *text = e && e->status == s && e->text[0] ? e->text : ylm_status_text(s);
  if (s == YLM_ENOMEM) return ylmL_no_memory(L, text);
  lua_pushnil(L);
  lua_pushstring(L, text);
  if (s == YLM_ECANCELLED) {
    lua_pop(L, 1);
    lua_pushliteral(L, "cancelled");
  }
  lua_pushstring(L, ylm_status_name(s));
  return 3;
}

/* -- object types ---------------------------------------------------------------------------- */

/* The only list of types whose methods are written in Lua: the type, the module that has them. */
#define METHODS_IN_LUA(X)                                                                          \
  X("ylm.array", "ylm.array")                                                                      \
  X("ylm.image", "ylm.image")                                                                      \
  X("ylm.mesh", "ylm.geometry")                                                                    \
  X("ylm.grid", "ylm.grid")                                                                        \
  X("ylm.grid_set", "ylm.grid")                                                                    \
  X("ylm.view", "ylm.render")                                                                      \
  X("ylm.links", "ylm.transfer")                                                                   \
  X("ylm.radiosity", "ylm.transfer")                                                               \
  X("ylm.gather", "ylm.transfer")                                                                  \
  X("ylm.receivers", "ylm.transfer")                                                               \
  X("ylm.occluder", "ylm.shadow")                                                                  \
  X("ylm.shadowed", "ylm.shadow")                                                                  \
  X("ylm.visible", "ylm.emit")                                                                     \
  X("ylm.sh_rotation", "ylm.sh.rotate")

/* Functions that a module may define for its type. */
static const char *const events[] = {"__index", "__newindex", "__len", "__tostring", "__add",
                                     "__sub",   "__mul",      "__div", "__pow",      "__unm"};
#define EVENTS (sizeof events / sizeof *events)
enum { ARITHMETIC = 4 }; /* the first of the events whose operands may stand in either order */

static const char *module_of(const char *type) {
#define X(name, module)                                                                            \
  if (strcmp(type, name) == 0) return module;
  METHODS_IN_LUA(X)
#undef X
  return NULL;
}

static int load_methods(lua_State *L);

/* Takes what loads the module out of the metatable on top of the stack. */
static void forget_loader(lua_State *L) {
  for (size_t i = 0; i < EVENTS; i++) {
    lua_pushstring(L, events[i]);
    lua_rawget(L, -2);
    if (lua_tocfunction(L, -1) == load_methods) {
      lua_pushstring(L, events[i]);
      if (i)
        lua_pushnil(L);
      else
        lua_pushvalue(L, -3);
      lua_rawset(L, -4);
    }
    lua_pop(L, 1);
  }
}

/* The event of two operands, either of which may be the object whose module is being loaded. */
static int operate(lua_State *L, const char *event) {
  for (int i = 1; i <= 2; i++) {
    if (!luaL_getmetafield(L, i, event)) continue;
    lua_insert(L, 1);
    lua_call(L, 2, 1);
    return 1;
  }
  return luaL_error(L, "an object of ylm that has no arithmetic");
}

/* An object is used before the module with its methods was: loads that, then does what was wanted.
   Upvalues: require, the module, the number of the event. */
static int load_methods(lua_State *L) {
  int event = (int)lua_tointeger(L, lua_upvalueindex(3));
  lua_settop(L, event == 0 || event >= ARITHMETIC ? 2 : event == 1 ? 3 : 1);
  lua_pushvalue(L, lua_upvalueindex(1));
  lua_pushvalue(L, lua_upvalueindex(2));
  lua_call(L, 1, 0);
  for (int i = 1; i <= (event >= ARITHMETIC ? 2 : 1); i++)
    if (lua_getmetatable(L, i)) {
      forget_loader(L);
      lua_pop(L, 1);
    }
  if (event >= ARITHMETIC) return operate(L, events[event]);
  if (event == 0) {
    lua_gettable(L, 1);
    return 1;
  }
  if (event == 1) {
    lua_settable(L, 1);
    return 0;
  }
  if (!luaL_callmeta(L, 1, events[event]))
    return luaL_error(L, "%s has no %s", lua_tostring(L, lua_upvalueindex(2)), events[event]);
  return 1;
}

/* Until `module` is loaded, the metatable on top of the stack loads it when it is asked. */
static void load_when_used(lua_State *L, const char *module) {
  for (size_t i = 0; i < EVENTS; i++) {
    lua_getglobal(L, "require");
    lua_pushstring(L, module);
    lua_pushinteger(L, (lua_Integer)i);
    lua_pushcclosure(L, load_methods, 3);
    lua_setfield(L, -2, events[i]);
  }
}

void ylmL_type(lua_State *L, const char *name, const luaL_Reg *methods) {
  if (!luaL_newmetatable(L, name)) return;
  lua_pushvalue(L, -1);
  lua_setfield(L, -2, "__index");
  lua_pushstring(L, name);
  lua_setfield(L, -2, "__name");
  if (module_of(name)) load_when_used(L, module_of(name));
  if (methods) luaL_setfuncs(L, methods, 0);
}

void *ylmL_test(lua_State *L, int i, const char *name) {
  void *p = lua_touserdata(L, i);
  if (!p || lua_islightuserdata(L, i) || !lua_getmetatable(L, i)) return NULL;
  luaL_getmetatable(L, name);
  if (!lua_rawequal(L, -1, -2)) p = NULL;
  lua_pop(L, 2);
  return p;
}

void *ylmL_check(lua_State *L, int i, const char *name) {
  void *p = ylmL_test(L, i, name);
  if (!p) {
    const char *got = luaL_typename(L, i);
    luaL_argerror(L, i, lua_pushfstring(L, "%s expected, got %s", name, got));
  }
  return p;
}

void ylmL_charge(lua_State *L, size_t bytes) {
  size_t kilobytes = bytes >> 10;
  if (kilobytes > 64) lua_gc(L, LUA_GCSTEP, kilobytes > 1 << 20 ? 1 << 20 : (int)kilobytes);
}

/* A function pointer as bytes: ISO C has no cast from it to void *. */
void ylmL_type_has_field(lua_State *L, ylmL_field_of *get) {
  lua_pushlstring(L, (const char *)&get, sizeof get);
  lua_setfield(L, -2, "__field");
}

ylmL_field_of *ylmL_field_getter(lua_State *L, int i) {
  ylmL_field_of *get = NULL;
  if (lua_touserdata(L, i) && lua_getmetatable(L, i)) {
    size_t size;
    lua_getfield(L, -1, "__field");
    const char *bytes = lua_tolstring(L, -1, &size);
    if (bytes && size == sizeof get) memcpy(&get, bytes, sizeof get);
    lua_pop(L, 2);
  }
  return get;
}

const ylm_field *ylmL_field_check(lua_State *L, int i) {
  ylmL_field_of *get = ylmL_field_getter(L, i);
  const ylm_field *field = get ? get(lua_touserdata(L, i)) : NULL;
  if (!field) luaL_argerror(L, i, "an object with a light field expected");
  return field;
}

/* -- progress: the arguments of a call must outlive what its progress function does ---------- */

/* Tables of the registry with objects for keys, which are weak. BUSY: arguments of calls with a
   progress function, true while that function runs. PARTS: objects that others are made of, true. */
#define BUSY "ylm.busy"
#define PARTS "ylm.parts"

void ylmL_note_part(lua_State *L) {
  ylmL_weak(L, PARTS);
  lua_pushvalue(L, -2);
  lua_pushboolean(L, 1);
  lua_rawset(L, -3);
  lua_pop(L, 1);
}

/* Adds to the number of progress functions that run, which stands in the table at `busy`. */
static int count_running(lua_State *L, int busy, int more) {
  lua_getfield(L, busy, "running");
  int running = (int)lua_tointeger(L, -1) + more;
  lua_pop(L, 1);
  lua_pushinteger(L, running);
  lua_setfield(L, busy, "running");
  return running;
}

/* Makes entries for the arguments below `top`, and for the number of progress functions that run,
   so that marking them later takes no memory. */
static void note_arguments(lua_State *L, int top) {
  ylmL_weak(L, BUSY);
  count_running(L, lua_gettop(L), 0);
  for (int i = 1; i <= top; i++) {
    if (lua_type(L, i) != LUA_TUSERDATA) continue;
    lua_pushvalue(L, i);
    lua_rawget(L, -2);
    bool known = lua_toboolean(L, -1);
    lua_pop(L, 1);
    lua_pushvalue(L, i);
    lua_pushboolean(L, known);
    lua_rawset(L, -3);
  }
  lua_pop(L, 1);
}

/* Marks (or unmarks) arguments in the table at `busy`; returns those that changed, as bits. */
static uint64_t mark(lua_State *L, int busy, int top, uint64_t which, bool value) {
  uint64_t changed = 0;
  for (int i = 1; i <= top && i <= 64; i++) {
    uint64_t bit = (uint64_t)1 << (i - 1);
    if (!(which & bit) || lua_type(L, i) != LUA_TUSERDATA) continue;
    lua_pushvalue(L, i);
    lua_rawget(L, busy);
    bool now = lua_toboolean(L, -1);
    lua_pop(L, 1);
    if (now == value) continue;
    lua_pushvalue(L, i);
    lua_pushboolean(L, value);
    lua_rawset(L, busy);
    changed |= bit;
  }
  return changed;
}

ylm_status ylmL_busy(lua_State *L, int i) {
  lua_getfield(L, LUA_REGISTRYINDEX, BUSY);
  bool busy = false;
  if (lua_istable(L, -1)) {
    lua_pushvalue(L, i);
    lua_rawget(L, -2);
    busy = lua_toboolean(L, -1);
    lua_pop(L, 1);
    /* a part of another object may be in use by any call whose progress function runs */
    lua_getfield(L, LUA_REGISTRYINDEX, PARTS);
    if (!busy && lua_istable(L, -1) && count_running(L, lua_gettop(L) - 1, 0) > 0) {
      lua_pushvalue(L, i);
      lua_rawget(L, -2);
      busy = lua_toboolean(L, -1);
      lua_pop(L, 1);
    }
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  return busy ? YLM_EBUSY : YLM_OK;
}

ylm_status ylmL_array_busy(lua_State *L, const ylmL_array *a) {
  bool busy = false;
  luaL_checkstack(L, 6, "busy");
  ylmL_weak(L, BUSY);
  int table = lua_gettop(L);
  if (count_running(L, table, 0) > 0)
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
      if (!lua_isboolean(L, -1) || !lua_toboolean(L, -1)) continue;
      const ylmL_array *b = ylmL_test(L, -2, YLM_ARRAY);
      busy |= b && b->data && ylmL_array_overlaps(a, b);
    }
  lua_settop(L, table - 1);
  return busy ? YLM_EBUSY : YLM_OK;
}

/* The registry's function that does nothing, for a debug hook to be called. */
static void push_nothing(lua_State *L) {
  lua_getfield(L, LUA_REGISTRYINDEX, "ylm.nothing");
  if (lua_isfunction(L, -1)) return;
  lua_pop(L, 1);
  if (luaL_loadstring(L, "") != 0) lua_error(L);
  lua_pushvalue(L, -1);
  lua_setfield(L, LUA_REGISTRYINDEX, "ylm.nothing");
}

/* Calls the function and its arguments on top of the stack, while the call's own arguments cannot
   be closed; leaves its result. False if it raised. */
static bool call_back(ylmL_progress *p, int arguments) {
  lua_State *L = p->L;
  int function = lua_gettop(L) - arguments;
  lua_getfield(L, LUA_REGISTRYINDEX, BUSY);
  lua_insert(L, function);
  uint64_t marked = mark(L, function, p->top, UINT64_MAX, true);
  count_running(L, function, 1);
  p->raised = lua_pcall(L, arguments, 1, 0) != 0;
  count_running(L, function, -1);
  mark(L, function, p->top, marked, false);
  lua_remove(L, function);
  if (p->raised) p->message = lua_gettop(L);
  return !p->raised;
}

static bool step(void *user, uint64_t done, uint64_t total, const char *stage) {
  ylmL_progress *p = user;
  if (p->raised) return false;
  lua_State *L = p->L;
  if (lua_gethookmask(L)) {
    push_nothing(L);
    if (!call_back(p, 0)) return false;
    lua_pop(L, 1);
  }
  if (!p->index) return true;
  lua_pushvalue(L, p->index);
  ylmL_push_count(L, done);
  ylmL_push_count(L, total);
  lua_pushstring(L, stage ? stage : "");
  if (!call_back(p, 3)) return false;
  bool go = !lua_isboolean(L, -1) || lua_toboolean(L, -1);
  lua_pop(L, 1);
  return go;
}

const ylm_progress *ylmL_progress_begin(lua_State *L, int i, ylmL_progress *p) {
  memset(p, 0, sizeof *p);
  double every = 0;
  if (lua_istable(L, i)) { /* { function, every = seconds }, whose place the function takes */
    lua_getfield(L, i, "every");
    every = (double)lua_tonumber(L, -1);
    lua_pop(L, 1);
    lua_rawgeti(L, i, 1);
    lua_replace(L, i);
  }
  ylm_progress_pace(every);
  if (!lua_isnoneornil(L, i)) {
    luaL_checktype(L, i, LUA_TFUNCTION);
    p->index = i;
  }
  luaL_checkstack(L, 20, "progress");
  push_nothing(L);
  lua_pop(L, 1);
  p->base.step = step;
  p->base.user = p;
  p->L = L;
  /* a hook that comes later, an interrupt's, closes nothing; it is counted all the same */
  p->top = p->index || lua_gethookmask(L) ? lua_gettop(L) : 0;
  note_arguments(L, p->top);
  return &p->base;
}

int ylmL_result_progress(lua_State *L, int n, ylm_status s, const ylm_error *e, ylmL_progress *p) {
  if (p->raised) {
    lua_pushvalue(L, p->message);
    return lua_error(L);
  }
  return ylmL_result(L, n, s, e);
}
