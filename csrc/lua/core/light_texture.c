/* light_texture.c - images on parallelograms: texels, and the parts that they are cut into. */
#include "../binding.h"

#include "ylm_light.h"

ylm_light_texture ylmL_light_texture(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  ylm_light_texture t = {.texel = a->data,
                         .scale = (double)luaL_checknumber(L, 3),
                         .tolerance = (double)luaL_checknumber(L, 4),
                         .largest = (double)luaL_checknumber(L, 5)};
  if (a->dtype != YLM_FLOAT || a->axes != 3 || a->shape[2] != 3 || a->count == 0)
    luaL_argerror(L, 1, "a float array [height][width][3] expected");
  t.height = a->shape[0];
  t.width = a->shape[1];
  luaL_checktype(L, 2, LUA_TTABLE);
  for (int i = 0; i < 9; i++) {
    lua_rawgeti(L, 2, i + 1);
    (i < 3 ? t.corner : i < 6 ? t.u : t.v)[i % 3] = (double)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  return t;
}

/* texture_texels(float [h][w] or [h][w][c]) -> float [h][w][3]; one or two channels are grey (and
   alpha), the fourth is left out */
static int texture_texels(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  size_t channels = a->axes == 3 ? a->shape[2] : 1;
  if (a->dtype != YLM_FLOAT || a->axes < 2 || a->axes > 3 || channels < 1)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 3, (size_t[]){a->shape[0], a->shape[1], 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  const float *from = a->data;
  float *to = out->data;
  for (size_t i = 0; i < a->shape[0] * a->shape[1]; i++, from += channels, to += 3)
    for (size_t c = 0; c < 3; c++) to[c] = from[channels < 3 ? 0 : c];
  return 1;
}

static ylmL_array *rows(lua_State *L, size_t n, size_t width) {
  return ylmL_array_new(L, YLM_DOUBLE, width ? 2 : 1, (size_t[]){n, width});
}

/* texture_quads(texels, {9}, scale, tolerance, largest) -> vertices [n*4][3], radiance [n][3] */
static int texture_quads(lua_State *L) {
  ylm_light_texture t = ylmL_light_texture(L);
  size_t n = ylm_light_texture_quads(&t, NULL, NULL);
  ylmL_array *vertices = rows(L, 4 * n, 3), *radiance = vertices ? rows(L, n, 3) : NULL;
  if (!radiance) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  if (n > 0) ylm_light_texture_quads(&t, vertices->data, radiance->data);
  return 2;
}

/* texture_tiles(as texture_quads, across) -> triangles [n][9], radiance [n][3] */
static int texture_tiles(lua_State *L) {
  ylm_light_texture t = ylmL_light_texture(L);
  size_t across = (size_t)luaL_checknumber(L, 6);
  size_t n = ylm_light_texture_tiles(&t, across, NULL, NULL);
  ylmL_array *triangles = rows(L, n, 9), *radiance = triangles ? rows(L, n, 3) : NULL;
  if (!radiance) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_light_texture_tiles(&t, across, triangles->data, radiance->data);
  return 2;
}

static const luaL_Reg functions[] = {{"texture_texels", texture_texels},
                                     {"texture_quads", texture_quads},
                                     {"texture_tiles", texture_tiles},
                                     {NULL, NULL}};

void ylmL_open_light_texture(lua_State *L) { luaL_setfuncs(L, functions, 0); }
