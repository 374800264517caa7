/*
** scene.c - fuzzes the sandbox that runs scene files: text -> lua/ylm/sandbox.lua under Lua 5.4.
**
** The bindings are built with sanitizers and coverage. Lua code is not seen by libFuzzer, so every
** new kind of answer (its text, digits and quoted names left out) counts as something reached.
*/
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../../csrc/lua/binding.h"

#include <lualib.h>

int luaopen_ylm_c_core(lua_State *L);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

__attribute__((section("__libfuzzer_extra_counters"))) static uint8_t kinds[4096];

static char folder[] = "/tmp/ylm-fuzz-XXXXXX", path[64], mesh[64];

static const char setup[] =
    "package.path = 'lua/?.lua;lua/?/init.lua'\n"
    "local sandbox, form, check = require 'ylm.sandbox', require 'ylm.form', require 'ylm.check'\n"
    "local limits = { instructions = 3e4, seconds = 5, memory = 4e6, triangles = 2e4, cells = "
    "1e4,\n"
    "  lmax = 8, depth = 6, file_size = 65536 }\n"
    "local codes = { EFORMAT = 1, ELIMIT = 1, EINVAL = 1, EIO = 1, ENOMEM = 1, EMISSING = 1,\n"
    "  ESHAPE = 1, ERANGE = 1 }\n"
    "local upper, globals = string.upper, {}\n"
    "for k, v in pairs(_G) do globals[k] = v end\n"
    "return function(path)\n"
    "  local scene, message, code = sandbox.run(path, limits)\n"
    "  for k, v in pairs(_G) do assert(globals[k] == v, 'global changed') end\n"
    "  for k, v in pairs(globals) do assert(_G[k] == v, 'global changed') end\n"
    "  assert(('x').upper == upper and not form.observer and not check.boundary, 'state left')\n"
    "  if scene then assert(form.kind(scene) == 'scene') return 'scene' end\n"
    "  assert(type(message) == 'string' and #message < 1200 and not message:find('%c'), "
    "'message')\n"
    "  assert(codes[code], 'code ' .. tostring(code) .. ' of ' .. message)\n"
    "  return code .. message\n"
    "end\n";

static void die(const char *what) {
  fprintf(stderr, "scene: %s\n", what);
  __builtin_trap();
}

static void clean(void) {
  unlink(path);
  unlink(mesh);
  rmdir(folder);
}

static void put(const char *name, const void *data, size_t size) {
  FILE *f = fopen(name, "wb");
  if (!f || fwrite(data, 1, size, f) != size || fclose(f) != 0) die("cannot write");
}

/* A state with the sandbox, its function `run` at 1. */
static lua_State *begin(void) {
  static const char triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  if (!mkdtemp(folder)) die("no folder");
  snprintf(path, sizeof path, "%s/scene.lua", folder);
  snprintf(mesh, sizeof mesh, "%s/a.obj", folder);
  put(mesh, triangle, sizeof triangle - 1);
  atexit(clean);
  lua_State *L = luaL_newstate();
  luaL_openlibs(L);
  luaL_getsubtable(L, LUA_REGISTRYINDEX, "_PRELOAD");
  lua_pushcfunction(L, luaopen_ylm_c_core);
  lua_setfield(L, -2, "ylm.c.core");
  lua_settop(L, 0);
  if (luaL_dostring(L, setup)) die(lua_tostring(L, -1));
  return L;
}

static unsigned kind_of(const char *s) {
  unsigned h = 2166136261u;
  for (int quoted = 0; *s; s++) {
    if (*s == '\'' || *s == '"') quoted = !quoted;
    if (!quoted && !isdigit((unsigned char)*s)) h = (h ^ (unsigned char)*s) * 16777619u;
  }
  return h;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static lua_State *L;
  if (!L) L = begin();
  put(path, data, size);
  lua_pushvalue(L, 1);
  lua_pushstring(L, path);
  if (lua_pcall(L, 1, 1, 0) != LUA_OK) die(lua_tostring(L, -1));
  kinds[kind_of(lua_tostring(L, -1)) % sizeof kinds] = 1;
  lua_settop(L, 1);
  return 0;
}
