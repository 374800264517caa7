/* material.c - materials as objects; lua/ylm/material makes them of forms. */
#include "../binding.h"
#include "ylm_material.h"

/* material_kinds() -> list of names */
static int material_kinds(lua_State *L) {
  lua_newtable(L);
  for (int i = 0; i < ylm_material_kinds(); i++) {
    lua_pushstring(L, ylm_material_kind_name(i));
    lua_rawseti(L, -2, i + 1);
  }
  return 1;
}

/* The kind named at 1 and the numbers in the table at 2. */
static int read_numbers(lua_State *L, size_t *n, float x[YLM_MATERIAL_NUMBERS]) {
  int kind = ylm_material_kind_find(luaL_checkstring(L, 1));
  luaL_checktype(L, 2, LUA_TTABLE);
  *n = lua_rawlen(L, 2);
  for (size_t i = 0; i < *n && i < YLM_MATERIAL_NUMBERS; i++) {
    lua_rawgeti(L, 2, (int)i + 1);
    x[i] = (float)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  return kind;
}

/* material_check(kind, numbers) -> true */
static int material_check(lua_State *L) {
  float x[YLM_MATERIAL_NUMBERS];
  size_t n;
  ylm_error e = {0};
  int kind = read_numbers(L, &n, x);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, ylm_material_check(kind, n, x, &e), &e);
}

/* material_create(kind, numbers [, bytes of a file, its name]) -> material */
static int material_create(lua_State *L) {
  float x[YLM_MATERIAL_NUMBERS];
  size_t n, size = 0;
  ylm_error e = {0};
  int kind = read_numbers(L, &n, x);
  const char *bytes = luaL_optlstring(L, 3, NULL, &size), *name = luaL_optstring(L, 4, "the file");
  ylm_material **m = ylmL_material_new(L);
  ylm_status s = bytes ? ylm_material_load(kind, n, x, bytes, size, name, m, &e)
                       : ylm_material_create(kind, n, x, m, &e);
  if (s == YLM_OK) ylmL_charge(L, ylm_material_bytes(*m));
  return ylmL_result(L, 1, s, &e);
}

/* material_albedo(material) -> red, green, blue */
static int material_albedo(lua_State *L) {
  float albedo[3];
  ylm_material_albedo(ylmL_material_check(L, 1), albedo);
  for (int c = 0; c < 3; c++) lua_pushnumber(L, (lua_Number)albedo[c]);
  return 3;
}

/* material_transfer(kind, lmax) -> [lmax+1] */
static int material_transfer(lua_State *L) {
  int kind = ylm_material_kind_find(luaL_checkstring(L, 1));
  double lmax = (double)luaL_checknumber(L, 2);
  if (kind < 0) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  if (!(lmax >= 0 && lmax <= YLM_MATERIAL_LMAX)) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 1, (size_t[]){(size_t)lmax + 1});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 1, ylm_material_transfer(kind, (int)lmax, a->data), NULL);
}

static const luaL_Reg functions[] = {
    {"material_kinds", material_kinds},       {"material_check", material_check},
    {"material_create", material_create},     {"material_albedo", material_albedo},
    {"material_transfer", material_transfer}, {NULL, NULL}};

void ylmL_open_material(lua_State *L) { luaL_setfuncs(L, functions, 0); }
