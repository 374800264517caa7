/*
** failure.c - memory that runs out where a spec wants it: preloaded, and a Lua module.
**
**   local failure = require "failure"
**   failure.arm(a, b)   requests a to b (a) for memory by ylm's libraries from here on fail
**   failure.arm(0)      none fails
**   failure.requests()  requests since then
**   failure.limit(n)    the address space may grow by n bytes more; nil: by any number
**
** A request is ylm's where the code that asks lies in libylm... or in a binding, ylm/c. Requests of
** Lua, of the C library, of Embree, VTK and OpenEXR pass.
*/
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <link.h>
#include <lua.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>

enum { MOST = 64 };
static struct { uintptr_t begin, end; } ours[MOST];
static int count;
static long first, last, seen; /* one thread asks at a time, or the spec sets YLM_THREADS=1 */

static int note(struct dl_phdr_info *info, size_t size, void *unused) {
  (void)size, (void)unused;
  if (!strstr(info->dlpi_name, "/libylm") && !strstr(info->dlpi_name, "/ylm/c/")) return 0;
  for (int i = 0; i < info->dlpi_phnum && count < MOST; i++) {
    const ElfW(Phdr) *p = info->dlpi_phdr + i;
    if (p->p_type != PT_LOAD || !(p->p_flags & PF_X)) continue;
    ours[count].begin = info->dlpi_addr + p->p_vaddr;
    ours[count++].end = info->dlpi_addr + p->p_vaddr + p->p_memsz;
  }
  return 0;
}

/* Shall this request fail? */
static bool fails(void *caller) {
  if (!first) return false;
  uintptr_t c = (uintptr_t)caller;
  for (int i = 0; i < count; i++)
    if (c >= ours[i].begin && c < ours[i].end) {
      long k = __atomic_add_fetch(&seen, 1, __ATOMIC_RELAXED);
      return k >= first && k <= last;
    }
  return false;
}

#define REAL(name)                                                                                 \
  static __typeof__(name) *real;                                                                   \
  if (!real) real = (__typeof__(name) *)dlsym(RTLD_NEXT, #name)
#define FAIL(value)                                                                                \
  if (fails(__builtin_return_address(0))) {                                                        \
    errno = ENOMEM;                                                                                \
    return value;                                                                                  \
  }

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);

void *malloc(size_t size) {
  FAIL(NULL)
  return __libc_malloc(size);
}
void *calloc(size_t n, size_t size) {
  FAIL(NULL)
  return __libc_calloc(n, size);
}
void *realloc(void *p, size_t size) {
  FAIL(NULL)
  return __libc_realloc(p, size);
}
void *aligned_alloc(size_t align, size_t size);
void *aligned_alloc(size_t align, size_t size) {
  REAL(aligned_alloc);
  FAIL(NULL)
  return real(align, size);
}
char *strdup(const char *s) {
  FAIL(NULL)
  char *p = __libc_malloc(strlen(s) + 1);
  return p ? strcpy(p, s) : NULL;
}
FILE *fdopen(int fd, const char *mode) {
  REAL(fdopen);
  FAIL(NULL)
  return real(fd, mode);
}
void *mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset) {
  REAL(mmap);
  FAIL(MAP_FAILED)
  return real(at, size, protection, flags, fd, offset);
}
void *mremap(void *p, size_t old, size_t size, int flags, ...) {
  static void *(*real)(void *, size_t, size_t, int, ...);
  if (!real) real = (void *(*)(void *, size_t, size_t, int, ...))dlsym(RTLD_NEXT, "mremap");
  FAIL(MAP_FAILED)
  return real(p, old, size, flags);
}

static int arm(lua_State *L) {
  count = 0;
  dl_iterate_phdr(note, NULL);
  seen = 0;
  first = (long)lua_tonumber(L, 1);
  last = lua_type(L, 2) == LUA_TNUMBER ? (long)lua_tonumber(L, 2) : first;
  return 0;
}

static int requests(lua_State *L) {
  lua_pushnumber(L, (lua_Number)seen);
  return 1;
}

static int limit(lua_State *L) {
  struct rlimit r;
  getrlimit(RLIMIT_AS, &r);
  long pages = 0;
  FILE *f = fopen("/proc/self/statm", "r");
  if (f && fscanf(f, "%ld", &pages) != 1) pages = 0;
  if (f) fclose(f);
  r.rlim_cur =
      lua_type(L, 1) == LUA_TNUMBER ? (rlim_t)(pages * 4096.0 + lua_tonumber(L, 1)) : r.rlim_max;
  setrlimit(RLIMIT_AS, &r);
  return 0;
}

int luaopen_failure(lua_State *L);
int luaopen_failure(lua_State *L) {
  lua_CFunction functions[] = {arm, requests, limit};
  const char *names[] = {"arm", "requests", "limit"};
  lua_createtable(L, 0, 3);
  for (int i = 0; i < 3; i++) {
    lua_pushcclosure(L, functions[i], 0);
    lua_setfield(L, -2, names[i]);
  }
  return 1;
}
