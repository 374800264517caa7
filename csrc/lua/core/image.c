/* image.c - images: layers, metadata; lua/ylm/image/init.lua has the methods. */
#include "../binding.h"
#include "ylm_image.h"

static int integer(lua_State *L, int i) {
  double x = (double)luaL_checknumber(L, i);
  return x > 2e9 ? 2000000000 : x < -2e9 ? -2000000000 : (int)x;
}

/* image_new(width, height) -> image without layers */
static int image_new(lua_State *L) {
  ylm_error e = {0};
  int w = integer(L, 1), h = integer(L, 2);
  ylm_image **image = ylmL_image_new(L);
  return ylmL_result(L, 1, ylm_image_create(w, h, image, &e), &e);
}

/* image_add(image, name, channels) -> array [h][w][c]; made first, so that no layer stays
   without */
static int image_add(lua_State *L) {
  ylm_error e = {0};
  ylm_image *image = ylmL_image_check(L, 1);
  const char *name = luaL_checkstring(L, 2);
  int channels = integer(L, 3);
  size_t shape[3] = {(size_t)image->height, (size_t)image->width, 1};
  ylmL_array *a = ylmL_object_array(L, 1, YLM_FLOAT, 3, shape, NULL);
  ylm_status s = ylm_image_add(image, name, channels, &e);
  if (s == YLM_OK) {
    a->data = ylm_image_find(image, name)->data;
    a->shape[2] = (size_t)channels;
    a->count = shape[0] * shape[1] * a->shape[2];
    ylmL_charge(L, a->count * sizeof(float));
  }
  return ylmL_result(L, 1, s, &e);
}

/* image_info(image) -> width, height, list of layer names, list of channels */
static int image_info(lua_State *L) {
  ylm_image *image = ylmL_image_check(L, 1);
  lua_pushinteger(L, image->width);
  lua_pushinteger(L, image->height);
  lua_createtable(L, image->layers, 0);
  lua_createtable(L, image->layers, 0);
  for (int i = 0; i < image->layers; i++) {
    lua_pushstring(L, image->layer[i].name);
    lua_rawseti(L, -3, i + 1);
    lua_pushinteger(L, image->layer[i].channels);
    lua_rawseti(L, -2, i + 1);
  }
  return 4;
}

/* image_layer(image, name or nil) -> array [h][w][c], or nothing if there is no such layer */
static int image_layer(lua_State *L) {
  ylm_image *image = ylmL_image_check(L, 1);
  ylm_layer *layer = ylm_image_find(image, luaL_optstring(L, 2, NULL));
  if (!layer) return 0;
  size_t shape[3] = {(size_t)image->height, (size_t)image->width, (size_t)layer->channels};
  ylmL_object_array(L, 1, YLM_FLOAT, 3, shape, layer->data);
  return 1;
}

/* image_set_text(image, key, value or nil) -> true */
static int image_set_text(lua_State *L) {
  ylm_image *image = ylmL_image_check(L, 1);
  ylm_status s = ylm_image_set_text(image, luaL_checkstring(L, 2), luaL_optstring(L, 3, NULL));
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, NULL);
}

/* image_get_text(image, key) -> value or nil */
static int image_get_text(lua_State *L) {
  ylm_image *image = ylmL_image_check(L, 1);
  const char *value = ylm_image_get_text(image, luaL_checkstring(L, 2));
  if (!value) return 0;
  lua_pushstring(L, value);
  return 1;
}

/* image_texts(image) -> list of keys in order */
static int image_texts(lua_State *L) {
  ylm_image *image = ylmL_image_check(L, 1);
  lua_createtable(L, image->texts, 0);
  for (int i = 0; i < image->texts; i++) {
    lua_pushstring(L, image->text[i].key);
    lua_rawseti(L, -2, i + 1);
  }
  return 1;
}

/* image_close(image) lets go of the memory, which arrays over it may still hold */
static int image_close(lua_State *L) {
  ylmL_image_check(L, 1);
  return ylmL_object_close(L);
}

static const luaL_Reg functions[] = {{"image_new", image_new},
                                     {"image_add", image_add},
                                     {"image_info", image_info},
                                     {"image_layer", image_layer},
                                     {"image_set_text", image_set_text},
                                     {"image_get_text", image_get_text},
                                     {"image_texts", image_texts},
                                     {"image_close", image_close},
                                     {NULL, NULL}};

void ylmL_open_image(lua_State *L) {
  ylmL_image_new(L); /* registers the type */
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
