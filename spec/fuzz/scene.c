/*
** scene.c - fuzzes the sandbox that runs scene files: text -> lua/ylm/sandbox.lua under Lua 5.4.
**
** The bindings and the readers of images are built with sanitizers and coverage. In the folder of
** the scene lie a mesh, a.obj, and images, a.png and a.exr. Lua code is not seen by libFuzzer, so
** every new kind of answer (its text, digits and quoted names left out) counts as reached.
*/
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../../csrc/lua/binding.h"

#include <lualib.h>

#ifndef FUZZ_TREE /* the folder of the tree: runs begin in another */
#define FUZZ_TREE "."
#endif

int luaopen_ylm_c_core(lua_State *L);
int luaopen_ylm_c_codec(lua_State *L);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

__attribute__((section("__libfuzzer_extra_counters"))) static uint8_t kinds[4096];

static char folder[] = "/tmp/ylm-fuzz-XXXXXX", path[64], mesh[64], images[2][64];
static const char *const image_names[2] = {"a.png", "a.exr"};

static const char setup[] =
    "package.path = '" FUZZ_TREE "/lua/?.lua;" FUZZ_TREE "/lua/?/init.lua'\n"
    "local sandbox, form, check = require 'ylm.sandbox', require 'ylm.form', require 'ylm.check'\n"
    "local limits = form.options(1, 'fuzz', sandbox.limits, { instructions = 3e4, time_limit = 5,\n"
    "  memory = 4e6, triangles = 2e4, numbers = 1e5, cells = 1e4, texels = 4096, lmax = 8,\n"
    "  depth = 6, file_size = 65536 })\n"
    "local shown, make = require 'ylm.text'.shown, require 'ylm.scene'.scene\n"
    "local codes = { EFORMAT = 1, ELIMIT = 1, EINVAL = 1, EIO = 1, ENOMEM = 1, EMISSING = 1,\n"
    "  ESHAPE = 1, ERANGE = 1 }\n"
    "local upper, globals = string.upper, {}\n"
    "for k, v in pairs(_G) do globals[k] = v end\n"
    "return function(path)\n"
    "  local scene, message, code = sandbox.run(path, limits, make)\n"
    "  for k, v in pairs(_G) do assert(globals[k] == v, 'global changed') end\n"
    "  for k, v in pairs(globals) do assert(_G[k] == v, 'global changed') end\n"
    "  assert(('x').upper == upper and not form.observer and not check.boundary, 'state left')\n"
    "  if scene then assert(form.kind(scene) == 'scene') return 'scene' end\n"
    "  assert(type(message) == 'string' and #message < 1200 and shown(message) == message, "
    "'message')\n"
    "  assert(codes[code], 'code ' .. tostring(code) .. ' of ' .. message)\n"
    "  assert(not message:find 'lua/ylm/[%w_/]*%.lua:%d', message)\n" /* not the caller's line */
    "  return code .. message\n"
    "end\n";

/* Writes the images of the given names: 4 x 2 texels, some dark, some negative. */
static const char paint[] =
    "local image = require('ylm.image').image { size = { 4, 2 }, layers = { { 'radiance', 3 } } }\n"
    "for y = 1, 2 do for x = 1, 4 do for c = 1, 3 do\n"
    "  image:layer():set(y, x, c, (x * y * c % 7 - 1) / 4)\n"
    "end end end\n"
    "for _, path in ipairs { ... } do assert(image:save(path)) end\n";

static void die(const char *what) {
  fprintf(stderr, "scene: %s\n", what);
  __builtin_trap();
}

static void clean(void) {
  unlink(path);
  unlink(mesh);
  for (int i = 0; i < 2; i++) unlink(images[i]);
  rmdir(folder);
}

static void put(const char *name, const void *data, size_t size) {
  FILE *f = fopen(name, "wb");
  if (!f || fwrite(data, 1, size, f) != size || fclose(f) != 0) die("cannot write");
}

static void run_paint(lua_State *L) {
  if (luaL_loadstring(L, paint)) die(lua_tostring(L, -1));
  for (int i = 0; i < 2; i++) {
    snprintf(images[i], sizeof images[i], "%s/%s", folder, image_names[i]);
    lua_pushstring(L, images[i]);
  }
  if (lua_pcall(L, 2, 0, 0) != LUA_OK) die(lua_tostring(L, -1));
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
  lua_pushcfunction(L, luaopen_ylm_c_codec);
  lua_setfield(L, -2, "ylm.c.codec");
  lua_settop(L, 0);
  if (luaL_dostring(L, setup)) die(lua_tostring(L, -1));
  run_paint(L);
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
