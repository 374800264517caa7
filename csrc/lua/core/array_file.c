/* array_file.c - arrays from and to .npy files. */
#include "../binding.h"

/* array_read(path) -> array */
static int array_read(lua_State *L) {
  const char *path = luaL_checkstring(L, 1);
  ylm_error e = {0};
  unsigned char *bytes;
  size_t size;
  ylm_array_file f;
  ylm_status s = ylm_file_read(path, 0, &bytes, &size, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  s = ylm_array_file_parse(bytes, size, path, &f, &e);
  if (s == YLM_OK) {
    ylmL_array *a = ylmL_array_new(L, f.dtype, f.axes, f.shape);
    if (a) {
      ylm_array_file_copy(&f, a->data);
      a->convention = f.convention;
    } else {
      s = ylm_no_memory_for(&e, path);
    }
  }
  ylm_free(bytes);
  return ylmL_result(L, 1, s, &e);
}

/* array_write(array, path) -> true */
static int array_write(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1);
  ylm_error e = {0};
  ylm_status s = ylm_array_file_write(luaL_checkstring(L, 2), a->dtype, a->axes, a->shape,
                                      a->convention, a->data, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* file_head(path) -> the first 16 bytes as a string */
static int file_head(lua_State *L) {
  ylm_error e = {0};
  unsigned char bytes[16];
  size_t n;
  ylm_status s = ylm_file_head(luaL_checkstring(L, 1), bytes, sizeof bytes, &n, &e);
  lua_pushlstring(L, (const char *)bytes, s == YLM_OK ? n : 0);
  return ylmL_result(L, 1, s, &e);
}

/* file_probe(path) -> true where a file can be written */
static int file_probe(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = ylm_file_probe(luaL_checkstring(L, 1), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* file_save(path, text) -> true; the file is replaced whole or not at all */
static int file_save(lua_State *L) {
  ylm_error e = {0};
  size_t size;
  const char *path = luaL_checkstring(L, 1), *text = luaL_checklstring(L, 2, &size);
  ylm_status s = ylm_file_save(path, text, size, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {{"file_head", file_head},     {"file_probe", file_probe},
                                     {"file_save", file_save},     {"array_read", array_read},
                                     {"array_write", array_write}, {NULL, NULL}};

void ylmL_open_array_file(lua_State *L) { luaL_setfuncs(L, functions, 0); }
