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

/* material_create(kind, numbers) -> material */
static int material_create(lua_State *L) {
  float x[YLM_MATERIAL_NUMBERS];
  ylm_error e = {0};
  int kind = ylm_material_kind_find(luaL_checkstring(L, 1));
  luaL_checktype(L, 2, LUA_TTABLE);
  size_t n = lua_rawlen(L, 2);
  for (size_t i = 0; i < n && i < YLM_MATERIAL_NUMBERS; i++) {
    lua_rawgeti(L, 2, (int)i + 1);
    x[i] = (float)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  ylm_material **m = ylmL_material_new(L);
  return ylmL_result(L, 1, ylm_material_create(kind, n, x, m, &e), &e);
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

static const luaL_Reg functions[] = {{"material_kinds", material_kinds},
                                     {"material_create", material_create},
                                     {"material_albedo", material_albedo},
                                     {"material_transfer", material_transfer},
                                     {NULL, NULL}};

void ylmL_open_material(lua_State *L) { luaL_setfuncs(L, functions, 0); }
