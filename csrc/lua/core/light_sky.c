/* light_sky.c - binds skies: panoramas, and skies of the CIE. Arguments come sorted from
   lua/ylm/light/environment.lua and lua/ylm/sh/sky.lua. */
#include "../binding.h"

#include "ylm_light_sky.h"

/* The three numbers of field `name` of the table on top of the stack; zeros where there is none. */
static void vector(lua_State *L, const char *name, double out[3]) {
  lua_getfield(L, -1, name);
  for (int a = 0; a < 3; a++) {
    out[a] = 0;
    if (lua_isnil(L, -1)) continue;
    lua_rawgeti(L, -1, a + 1);
    out[a] = (double)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
}

/* The sky {kind, zenith, sun | nil, luminance} at stack index i. */
static ylm_light_cie sky(lua_State *L, int i) {
  ylm_light_cie s;
  luaL_checktype(L, i, LUA_TTABLE);
  lua_pushvalue(L, i);
  lua_getfield(L, -1, "kind");
  s.kind = (ylm_light_cie_kind)luaL_checkoption(L, lua_gettop(L), NULL, ylmL_cie_sky_choices);
  lua_getfield(L, -2, "luminance");
  s.luminance = (double)luaL_checknumber(L, -1);
  lua_pop(L, 2);
  vector(L, "zenith", s.zenith);
  vector(L, "sun", s.sun);
  lua_pop(L, 1);
  return s;
}

/* sky_luminance(sky, x, y, z) -> number; sky_luminance(sky, directions double [n][3]) -> double
   [n][1]. Directions have length 1. */
static int sky_luminance(lua_State *L) {
  ylm_light_cie s = sky(L, 1);
  if (lua_isnumber(L, 2)) {
    double d[3] = {(double)luaL_checknumber(L, 2), (double)luaL_checknumber(L, 3),
                   (double)luaL_checknumber(L, 4)};
    lua_pushnumber(L, (lua_Number)ylm_light_cie_luminance(&s, d));
    return 1;
  }
  const ylmL_array *d = ylmL_array_check(L, 2);
  if (d->dtype != YLM_DOUBLE || d->axes != 2 || d->shape[1] != 3)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){d->shape[0], 1});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < d->shape[0]; i++)
    ((double *)out->data)[i] = ylm_light_cie_luminance(&s, (const double *)d->data + 3 * i);
  return 1;
}

/* The panorama of an image at 1, float [h][w][3], its mapping at 2 and up at 3. */
static ylm_light_panorama image(lua_State *L) {
  const ylmL_array *a = ylmL_array_check(L, 1);
  if (a->dtype != YLM_FLOAT || a->axes != 3 || a->shape[2] != 3 || a->count == 0 ||
      a->shape[0] > YLM_IMAGE_MAX_SIDE || a->shape[1] > YLM_IMAGE_MAX_SIDE)
    luaL_argerror(L, 1, "a float array [height][width][3] expected");
  return (ylm_light_panorama){.width = (int)a->shape[1],
                              .height = (int)a->shape[0],
                              .texel = a->data,
                              .mapping =
                                  (ylm_mapping)luaL_checkoption(L, 2, NULL, ylmL_mapping_choices),
                              .up = (ylm_up)luaL_checkoption(L, 3, NULL, ylmL_up_choices)};
}

/* panorama_check(texels, mapping, up) -> true | nil, message, code */
static int panorama_check(lua_State *L) {
  ylm_error e = {0};
  ylm_light_panorama p = image(L);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, ylm_light_panorama_check(&p, &e), &e);
}

/* mapping_fits(mapping, width, height) -> whether an image of the sphere may have this size */
static int mapping_fits(lua_State *L) {
  ylm_mapping m = (ylm_mapping)luaL_checkoption(L, 1, NULL, ylmL_mapping_choices);
  lua_pushboolean(L, ylm_mapping_fits(m, (int)luaL_checknumber(L, 2), (int)luaL_checknumber(L, 3)));
  return 1;
}

/* lights_panorama(texels | sky, mapping, up, scale, {records: double array, ..} of kind
                   "environment") -> lights */
static int lights_panorama(lua_State *L) {
  ylm_error e = {0};
  lua_settop(L, 5);
  ylm_light_panorama p = {.width = 0};
  if (lua_istable(L, 1))
    p.cie = sky(L, 1);
  else
    p = image(L);
  p.scale = (double)luaL_checknumber(L, 4);
  luaL_checktype(L, 5, LUA_TTABLE);
  int n = (int)lua_rawlen(L, 5);
  const double **record = lua_newuserdata(L, ((size_t)n + 1) * sizeof *record);
  for (int i = 0; i < n; i++) {
    lua_rawgeti(L, 5, i + 1);
    const ylmL_array *a = ylmL_array_check(L, lua_gettop(L));
    if (a->dtype != YLM_DOUBLE) luaL_argerror(L, 5, "double arrays expected");
    record[i] = a->data;
    lua_pop(L, 1);
  }
  ylm_light_set **set = ylmL_lights_new(L);
  ylm_status s = ylm_light_set_panorama(&p, (size_t)n, record, set, &e);
  if (s == YLM_OK) ylmL_charge(L, (size_t)p.width * (size_t)p.height * 12);
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {{"sky_luminance", sky_luminance},
                                     {"panorama_check", panorama_check},
                                     {"mapping_fits", mapping_fits},
                                     {"lights_panorama", lights_panorama},
                                     {NULL, NULL}};

void ylmL_open_light_sky(lua_State *L) { luaL_setfuncs(L, functions, 0); }
