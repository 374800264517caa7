/* codec.c - opens ylm.c.codec: the binding of libylm_codec.so, image files. */
#include "../binding.h"
#include "ylm_codec.h"

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

static const luaL_Reg functions[] = {
    {"image_write", image_write}, {"image_read", image_read}, {NULL, NULL}};

int luaopen_ylm_c_codec(lua_State *L) {
  ylmL_check_abi(L);
  lua_newtable(L);
  luaL_setfuncs(L, functions, 0);
  return 1;
}
