/*
** sandbox.c - what lua/ylm/sandbox.lua needs from C to run a stranger's scene file:
** a call that is bounded in instructions, time and memory, and file names that stay in a folder.
*/
#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "../binding.h"

/* -- a bounded call ----------------------------------------------------------- */

enum { STEP = 100 }; /* instructions between two looks at the clock */

/*
** The limits of a bounded call. `used` counts what was allocated less what was freed since it
** began; `traffic` what was allocated at all, so that copying long strings again and again is
** bounded too.
*/
typedef struct guard {
  int64_t used, bytes, traffic;
  double instructions, seconds; /* what is left; processor time at which to stop */
  const char *reason;           /* the limit that was passed, or NULL */
  const char *refused;          /* why the last request for more memory failed, or NULL */
  const char *last;             /* why the last one that failed did */
} guard;

/* Of this thread: other states may work in other threads. */
static double processor_seconds(void) {
  struct timespec t;
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t) != 0) return 0;
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The bounded call of this thread, or NULL. */
static _Thread_local guard *current;

/* Refuses to pass the limits; a block of a quarter of all memory is too large as well,
   because one comparison of two such strings is one instruction. */
static void *bounded(lua_Alloc f, void *ud, void *p, size_t old, size_t size) {
  guard *g = current;
  if (!g) return f(ud, p, old, size);
  int64_t before = p ? (int64_t)old : 0, more = (int64_t)size - before;
  if (more > 0) {
    g->refused = "memory";
    if (size > (size_t)g->bytes / 4 || g->used + more > g->bytes || g->traffic < (int64_t)size) {
      g->last = g->refused;
      return NULL;
    }
    g->traffic -= (int64_t)size;
  }
  void *q = f(ud, p, old, size);
  if (q || size == 0) g->used += more;
  if (more > 0) g->refused = q ? NULL : "exhausted";
  if (more > 0 && !q) g->last = g->refused;
  return q;
}

/* Whether an error says that memory ran out: `load` returns that as a message, which a caller raises again. */
static bool says_memory(lua_State *L) {
  const char *said = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "";
  return strstr(said, "not enough memory") != NULL;
}

/*
** A stand-in is the allocator of a state while a bounded call runs, with the state's own `ud`.
** A string of Lua 5.5 keeps the allocator that it was made by, and is freed by it, maybe long
** after the call: a stand-in lasts as long as the process. Each allocator function has one
** stand-in; a process has one or two such functions.
*/
#define STAND_IN(i)                                                                                \
  static void *bounded_##i(void *ud, void *p, size_t old, size_t size) {                           \
    return bounded(atomic_load(&stood_for[i]), ud, p, old, size);                                  \
  }
enum { STAND_INS = 4 };
static _Atomic(lua_Alloc) stood_for[STAND_INS];
STAND_IN(0)
STAND_IN(1)
STAND_IN(2)
STAND_IN(3)
static const lua_Alloc stand_ins[STAND_INS] = {bounded_0, bounded_1, bounded_2, bounded_3};

/* The stand-in for an allocator; NULL: too many are in use. */
static lua_Alloc stand_in(lua_Alloc f) {
  for (int i = 0; i < STAND_INS; i++) {
    lua_Alloc was = NULL;
    if (atomic_compare_exchange_strong(&stood_for[i], &was, f) || was == f) return stand_ins[i];
  }
  return NULL;
}

/* Counts instructions; once a limit is passed it raises at every instruction that follows. */
static void tick(lua_State *L, lua_Debug *ar) {
  (void)ar;
  guard *g = current;
  if (!g) return;
  g->instructions -= STEP;
  if (g->instructions < 0)
    g->reason = "instructions";
  else if (processor_seconds() > g->seconds)
    g->reason = "time";
  if (!g->reason) return;
  lua_sethook(L, tick, LUA_MASKCOUNT, 1);
  luaL_error(L, "a limit was reached");
}

/*
** bounded_call(f, instructions, bytes, seconds, message handler) -> true, result
** or false, error value, "instructions" | "time" | "memory" | "exhausted" (the machine's) | nil
*/
static int bounded_call(lua_State *L) {
  luaL_checktype(L, 1, LUA_TFUNCTION);
  guard g = {.instructions = luaL_checknumber(L, 2),
             .bytes = (int64_t)luaL_checknumber(L, 3),
             .seconds = processor_seconds() + luaL_checknumber(L, 4)};
  g.traffic = g.bytes * 32;
  if (current) return luaL_error(L, "bounded calls do not nest");
  void *ud = NULL;
  lua_Alloc f = lua_getallocf(L, &ud), instead = stand_in(f);
  if (!instead) return luaL_error(L, "bounded calls of states by %d allocators at most", STAND_INS);
  lua_Hook hook = lua_gethook(L);
  int mask = lua_gethookmask(L), count = lua_gethookcount(L);
  luaL_checktype(L, 5, LUA_TFUNCTION);
  lua_settop(L, 5);
  luaL_checkstack(L, 8, "bounded_call");
  lua_pushvalue(L, 1);
  current = &g;
  lua_setallocf(L, instead, ud);
  lua_sethook(L, tick, LUA_MASKCOUNT, STEP);
  int status = lua_pcall(L, 0, 1, 5);
  lua_setallocf(L, f, ud);
  current = NULL;
  lua_sethook(L, hook, mask, count);
  if (status == LUA_ERRMEM && !g.refused) g.refused = "memory";
  if ((status == LUA_ERRMEM || status == LUA_ERRERR) && !g.reason) g.reason = g.refused;
  if (status == LUA_ERRRUN && !g.reason && g.last && says_memory(L)) g.reason = g.last;
  lua_pushboolean(L, status == 0 && !g.reason);
  lua_insert(L, -2);
  if (g.reason)
    lua_pushstring(L, g.reason);
  else
    lua_pushnil(L);
  return 3;
}

/* -- files ---------------------------------------------------------------------- */

/* Is the relative path free of "..", of empty parts and of a leading slash? */
static bool stays_below(const char *path) {
  if (*path == 0 || *path == '/') return false;
  for (const char *part = path; part; part = strchr(part, '/')) {
    if (*part == '/') part++;
    size_t n = strcspn(part, "/");
    if (n == 0 || (n == 2 && part[0] == '.' && part[1] == '.')) return false;
  }
  return true;
}

/*
** resolve_inside(folder, path) -> the file's real name, its size; nil, message, code unless `path`
** is relative and leads, symbolic links followed, to a regular file below `folder`.
*/
static int resolve_inside(lua_State *L) {
  size_t size;
  const char *folder = luaL_checkstring(L, 1), *path = luaL_checklstring(L, 2, &size);
  char root[PATH_MAX], file[PATH_MAX];
  struct stat st;
  ylm_error e = {0};
  ylm_status s = YLM_OK;
  if (strlen(path) != size || !stays_below(path))
    s = ylm_fail(&e, YLM_EINVAL,
                 "a path inside the scene's folder expected: relative, without '..'");
  else if (!realpath(folder, root))
    s = ylm_fail(&e, YLM_EIO, "%s: no such folder", folder);
  else {
    lua_pushfstring(L, "%s/%s", root, path);
    if (!realpath(lua_tostring(L, -1), file)) s = ylm_fail(&e, YLM_EIO, "%s: no such file", path);
  }
  if (s == YLM_OK) {
    size_t n = strlen(root);
    if (n == 1) n = 0; /* the folder is "/" */
    bool inside = strncmp(root, file, n) == 0 && (file[n] == '/' || file[n] == 0);
    if (inside && stat(file, &st) == 0 && S_ISDIR(st.st_mode))
      s = ylm_fail(&e, YLM_EIO, "%s: a folder, not a file", path);
    else if (!inside || file[n] != '/')
      s = ylm_fail(&e, YLM_EINVAL, "%s: a link that leads out of the scene's folder", path);
    else if (stat(file, &st) != 0 || !S_ISREG(st.st_mode))
      s = ylm_fail(&e, YLM_EIO, "%s: not a regular file", path);
    else {
      lua_pushstring(L, file);
      lua_pushnumber(L, (lua_Number)st.st_size);
    }
  }
  return ylmL_result(L, 2, s, &e);
}

typedef struct bytes {
  const unsigned char *data;
  size_t size;
} bytes;

static int push_bytes(lua_State *L) {
  const bytes *b = lua_touserdata(L, 1);
  lua_pushlstring(L, (const char *)b->data, b->size);
  return 1;
}

/* read_file(path, limit) -> its bytes; nil, message, code unless it is a regular file within it */
static int read_file(lua_State *L) {
  const char *path = luaL_checkstring(L, 1);
  size_t limit = (size_t)luaL_checknumber(L, 2), size = 0;
  unsigned char *data = NULL;
  ylm_error e = {0};
  ylm_status s = ylm_file_read(path, limit, &data, &size, &e);
  if (s != YLM_OK) return ylmL_result(L, 1, s, &e);
  bytes b = {data, size};
  lua_pushcfunction(L, push_bytes);
  lua_pushlightuserdata(L, &b);
  int status = lua_pcall(L, 1, 1, 0);
  ylm_free(data);
  return status == 0 ? 1 : lua_error(L);
}

void ylmL_open_sandbox(lua_State *L) {
  static const luaL_Reg functions[] = {{"bounded_call", bounded_call},
                                       {"resolve_inside", resolve_inside},
                                       {"read_file", read_file},
                                       {NULL, NULL}};
  luaL_setfuncs(L, functions, 0);
}
