/* light_polygon.c - ylm.polygons, and ylm.light_sum: the sum of what has a light field. */
#include "../binding.h"

#include <string.h>

#include "ylm_light_device.h"

#define POLYGONS "ylm.polygons"
#define SUM "ylm.light_sum"

static const ylm_field *polygons_field(void *object) {
  ylm_polygons **p = object;
  return *p ? ylm_polygons_field(*p) : NULL;
}

ylm_polygons *ylmL_polygons(lua_State *L, int i) {
  ylm_polygons **p = ylmL_test(L, i, POLYGONS);
  return p ? *p : NULL;
}

static int polygons_gc(lua_State *L) {
  ylm_polygons **p = ylmL_check(L, 1, POLYGONS);
  ylm_polygons_free(*p);
  *p = NULL;
  return 0;
}

/* polygons_create({sides; 0: an ellipse, three rows}, vertices double [..][3], radiance double
   [n][3], exact, horizon [3] | nil) -> polygons */
static int polygons_create(lua_State *L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  size_t n = lua_rawlen(L, 1), total = 0;
  ylmL_array *v = ylmL_array_check(L, 2), *c = ylmL_array_check(L, 3), *h = ylmL_array_opt(L, 5);
  bool exact = lua_toboolean(L, 4);
  ylm_error e = {YLM_OK, ""};
  int *sides = lua_newuserdata(L, (n + 1) * sizeof *sides); /* collected whatever happens */
  for (size_t i = 0; i < n; i++) {
    lua_rawgeti(L, 1, (int)i + 1);
    sides[i] = (int)luaL_checknumber(L, -1);
    lua_pop(L, 1);
    if (sides[i] < 0 || sides[i] > 1000) return ylmL_result(L, 0, YLM_ERANGE, NULL);
    total += sides[i] ? (size_t)sides[i] : 3;
  }
  if (v->count != 3 * total || c->count != 3 * n || (h && h->count != 3))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (v->dtype != YLM_DOUBLE || c->dtype != YLM_DOUBLE || (h && h->dtype != YLM_DOUBLE))
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  ylm_polygons **p = lua_newuserdata(L, sizeof *p);
  *p = NULL;
  luaL_getmetatable(L, POLYGONS);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_polygons_create(n, sides, v->data, c->data, exact, h ? h->data : NULL, p, &e);
  if (s == YLM_OK) ylmL_charge(L, n * 300);
  return ylmL_result(L, 1, s, &e);
}

/* polygons_method(object) -> "exact", "sphere"; nil: these are no polygons */
static int polygons_method(lua_State *L) {
  const ylm_polygons *p = ylmL_polygons(L, 1);
  ylm_polygon_arrays unused;
  if (!p) return 0;
  lua_pushstring(L, ylm_polygons_exact(p, &unused) ? "exact" : "sphere");
  return 1;
}

/* A sum keeps its parts in the registry, by reference: uservalues differ between versions of Lua,
   the registry does not. */
typedef struct sum {
  ylm_field_sum *sum;
  int parts;
} sum;

static const ylm_field *sum_field(void *object) {
  sum *s = object;
  return s->sum ? ylm_field_sum_field(s->sum) : NULL;
}

static int sum_gc(lua_State *L) {
  sum *s = ylmL_check(L, 1, SUM);
  ylm_field_sum_free(s->sum);
  s->sum = NULL;
  luaL_unref(L, LUA_REGISTRYINDEX, s->parts);
  s->parts = LUA_NOREF;
  return 0;
}

/* light_sum({objects with a light field}) -> sum */
static int light_sum(lua_State *L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  lua_settop(L, 1);
  size_t n = lua_rawlen(L, 1);
  if (n > 100000) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  const ylm_field **fields = lua_newuserdata(L, (n + 1) * sizeof *fields);
  lua_createtable(L, (int)n, 0);
  for (size_t i = 0; i < n; i++) {
    lua_rawgeti(L, 1, (int)i + 1);
    fields[i] = ylmL_field_check(L, -1);
    lua_rawseti(L, 3, (int)i + 1);
  }
  sum *s = lua_newuserdata(L, sizeof *s);
  *s = (sum){NULL, LUA_NOREF};
  luaL_getmetatable(L, SUM);
  lua_setmetatable(L, -2);
  lua_pushvalue(L, 3);
  s->parts = luaL_ref(L, LUA_REGISTRYINDEX);
  return ylmL_result(L, 1, ylm_field_sum_create(n, fields, &s->sum), NULL);
}

/* The texture in arguments 1 to 6: texels float [h][w][3], {corner, u, v: 9 numbers}, scale,
 * tolerance, largest. */
static ylm_light_texture read_texture(lua_State *L) {
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
  ylm_light_texture t = read_texture(L);
  size_t n = ylm_light_texture_quads(&t, NULL, NULL);
  ylmL_array *vertices = rows(L, 4 * n, 3), *radiance = vertices ? rows(L, n, 3) : NULL;
  if (!radiance) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  if (n > 0) ylm_light_texture_quads(&t, vertices->data, radiance->data);
  return 2;
}

/* texture_tiles(as texture_quads, across) -> triangles [n][9], radiance [n][3] */
static int texture_tiles(lua_State *L) {
  ylm_light_texture t = read_texture(L);
  size_t across = (size_t)luaL_checknumber(L, 6);
  size_t n = ylm_light_texture_tiles(&t, across, NULL, NULL);
  ylmL_array *triangles = rows(L, n, 9), *radiance = triangles ? rows(L, n, 3) : NULL;
  if (!radiance) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_light_texture_tiles(&t, across, triangles->data, radiance->data);
  return 2;
}

static const luaL_Reg functions[] = {{"polygons_create", polygons_create},
                                     {"polygons_method", polygons_method},
                                     {"light_sum", light_sum},
                                     {"texture_texels", texture_texels},
                                     {"texture_quads", texture_quads},
                                     {"texture_tiles", texture_tiles},
                                     {NULL, NULL}};
static const luaL_Reg polygons_methods[] = {{"__gc", polygons_gc}, {NULL, NULL}};
static const luaL_Reg sum_methods[] = {{"__gc", sum_gc}, {NULL, NULL}};

void ylmL_open_light_polygon(lua_State *L) {
  ylmL_type(L, POLYGONS, polygons_methods);
  ylmL_type_has_field(L, polygons_field);
  ylmL_type(L, SUM, sum_methods);
  ylmL_type_has_field(L, sum_field);
  lua_pop(L, 2);
  luaL_setfuncs(L, functions, 0);
}
