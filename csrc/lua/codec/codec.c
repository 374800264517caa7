/* codec.c - opens ylm.c.codec: the binding of libylm_codec.so, image files, glTF, image viewers. */
#include "gltf.h"
#include "ylm_codec.h"
#include "ylm_display.h"

#include <string.h>

/* image_write(image, path, layer or nil, bits or 0, tone name, stops) -> true */
static int image_write(lua_State *L) {
  ylm_image *image = ylmL_image_check(L, 1);
  ylm_error e = {0};
  ylm_codec_options o = {
      .layer = luaL_optstring(L, 3, NULL),
      .bits = (int)luaL_checknumber(L, 4),
      .exposure = (double)luaL_checknumber(L, 6),
  };
  if (!ylm_tone_find(luaL_checkstring(L, 5), &o.tone)) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  ylm_status s = ylm_codec_write(image, luaL_checkstring(L, 2), &o, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* image_read(path, raw, numbers or nil, bytes or nil) -> image; the last two are limits */
static int image_read(lua_State *L) {
  const char *path = luaL_checkstring(L, 1);
  ylm_error e = {0};
  ylm_codec_input input = {lua_toboolean(L, 2), (uint64_t)luaL_optnumber(L, 3, 0),
                           (size_t)luaL_optnumber(L, 4, 0)};
  ylm_image **image = ylmL_image_new(L);
  ylm_status s = ylm_codec_read(path, &input, image, &e);
  return ylmL_result(L, 1, s, &e);
}

/* Pushes bytes that C has allocated as a string, and frees them. */
static int push_bytes(lua_State *L, ylm_status s, unsigned char *bytes, size_t n,
                      const ylm_error *e) {
  if (s == YLM_OK) lua_pushlstring(L, (const char *)bytes, n);
  ylm_free(bytes);
  return ylmL_result(L, 1, s, e);
}

/* image_png(image, tone name, stops) -> bytes of a .png of its first layer */
static int image_png(lua_State *L) {
  ylm_codec_options o = {.exposure = (double)luaL_checknumber(L, 3)};
  unsigned char *bytes;
  size_t n;
  ylm_error e = {0};
  if (!ylm_tone_find(luaL_checkstring(L, 2), &o.tone)) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  ylm_status s = ylm_codec_png(ylmL_image_check(L, 1), &o, &bytes, &n, &e);
  return push_bytes(L, s, bytes, n, &e);
}

/* deflate(bytes) -> a stream of zlib */
static int deflate(lua_State *L) {
  size_t size, n;
  const char *in = luaL_checklstring(L, 1, &size);
  unsigned char *bytes;
  ylm_error e = {0};
  ylm_status s = ylm_codec_deflate((const unsigned char *)in, size, &bytes, &n, &e);
  return push_bytes(L, s, bytes, n, &e);
}

/* inflate(a stream of zlib, bytes that it has unpacked) -> bytes */
static int inflate(lua_State *L) {
  size_t size, n = (size_t)luaL_checknumber(L, 2);
  const char *in = luaL_checklstring(L, 1, &size);
  unsigned char *out = lua_newuserdata(L, n ? n : 1);
  ylm_error e = {0};
  ylm_status s = ylm_codec_inflate((const unsigned char *)in, size, n, out, &e);
  if (s == YLM_OK) lua_pushlstring(L, (const char *)out, n);
  return ylmL_result(L, 1, s, &e);
}

/* -- image viewers ------------------------------------------------------------------------ */

#define YLML_DISPLAY "ylm.display"

static ylm_display **display_at(lua_State *L, int i) {
  ylm_display **d = ylmL_check(L, i, YLML_DISPLAY);
  if (!*d) luaL_argerror(L, i, "the display has been closed");
  return d;
}

static int display_close(lua_State *L) {
  ylm_display **d = lua_touserdata(L, 1);
  if (d && *d) ylm_display_free(*d);
  if (d) *d = NULL;
  return 0;
}

static const luaL_Reg display_methods[] = {{"__gc", display_close}, {NULL, NULL}};

/* display_open(host, port) -> display */
static int display_open(lua_State *L) {
  const char *host = luaL_checkstring(L, 1);
  int port = (int)luaL_checkinteger(L, 2);
  ylm_error e = {0};
  ylm_display **d = lua_newuserdata(L, sizeof *d);
  *d = NULL;
  ylmL_type(L, YLML_DISPLAY, display_methods);
  lua_setmetatable(L, -2);
  return ylmL_result(L, 1, ylm_display_open(host, port, d, &e), &e);
}

/* The layer { float array [height][width][channels], name, name .. } on top; its size must be the picture's. */
static bool read_layer(lua_State *L, ylm_display_picture *p, ylm_display_layer *layer) {
  int i = lua_gettop(L);
  lua_rawgeti(L, i, 1);
  const ylmL_array *a = ylmL_array_check(L, i + 1);
  if (a->axes != 3 || a->dtype != YLM_FLOAT || a->shape[2] > 4 ||
      lua_rawlen(L, i) != a->shape[2] + 1)
    return false;
  if (p->layers && ((size_t)p->height != a->shape[0] || (size_t)p->width != a->shape[1]))
    return false;
  p->height = (int)a->shape[0];
  p->width = (int)a->shape[1];
  layer->channels = (int)a->shape[2];
  layer->pixels = a->data;
  for (int c = 0; c < layer->channels; c++) {
    lua_rawgeti(L, i, c + 2);
    size_t n = 0;
    const char *name = luaL_checklstring(L, -1, &n);
    if (n >= sizeof layer->channel[c] || strlen(name) != n) return false;
    memcpy(layer->channel[c], name, n + 1);
  }
  lua_settop(L, i);
  return true;
}

/* display_send(display, name, list of layers) -> true */
static int display_send(lua_State *L) {
  ylm_display_layer layers[YLM_DISPLAY_LAYERS];
  ylm_display **d = display_at(L, 1);
  ylm_display_picture p = {.name = luaL_checkstring(L, 2), .layer = layers};
  luaL_checktype(L, 3, LUA_TTABLE);
  lua_settop(L, 3);
  ylm_error e = {0};
  size_t n = lua_rawlen(L, 3);
  if (n > YLM_DISPLAY_LAYERS) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  for (size_t l = 0; l < n; l++) {
    lua_rawgeti(L, 3, (int)l + 1);
    luaL_checktype(L, 4, LUA_TTABLE);
    if (!read_layer(L, &p, &layers[l])) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
    p.layers++;
    lua_settop(L, 3);
  }
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, ylm_display_send(*d, &p, &e), &e);
}

/* display_drop(display, name) -> true */
static int display_drop(lua_State *L) {
  ylm_error e = {0};
  ylm_display **d = display_at(L, 1);
  ylm_status s = ylm_display_drop(*d, luaL_checkstring(L, 2), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {
    {"image_write", image_write},   {"image_read", image_read},
    {"image_png", image_png},       {"deflate", deflate},
    {"inflate", inflate},           {"display_open", display_open},
    {"display_send", display_send}, {"display_close", display_close},
    {"display_drop", display_drop}, {NULL, NULL}};

int luaopen_ylm_c_codec(lua_State *L) {
  ylmL_check_abi(L);
  lua_newtable(L);
  luaL_setfuncs(L, functions, 0);
  ylmL_open_gltf(L);
  lua_pushnumber(L, YLM_DISPLAY_LAYERS);
  lua_setfield(L, -2, "display_layers");
  lua_pushnumber(L, YLM_DISPLAY_NAME);
  lua_setfield(L, -2, "display_name");
  return 1;
}
