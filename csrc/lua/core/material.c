/* material.c - materials as objects; lua/ylm/material makes them of forms. */
#include <math.h>

#include "material.h"
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

/* material_create(kind, numbers) -> material */
static int material_create(lua_State *L) {
  float x[YLM_MATERIAL_NUMBERS];
  size_t n;
  ylm_error e = {0};
  int kind = read_numbers(L, &n, x);
  ylm_material **m = ylmL_material_new(L);
  ylm_status s = ylm_material_create(kind, n, x, m, &e);
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

ylmL_array *ylmL_unit_rows(lua_State *L, int i, size_t n, const char *name, bool above) {
  ylmL_array *a = ylmL_array_check(L, i), *to;
  size_t rows = a->count / 3;
  ylm_error e = {0};
  to = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  if (!to) {
    ylmL_result(L, 0, YLM_ENOMEM, NULL);
    return NULL;
  }
  for (size_t k = 0; k < n; k++) {
    double v[3], l = 0;
    for (size_t c = 0; c < 3; c++) {
      v[c] = ylmL_array_get(a, 3 * (rows == 1 ? 0 : k) + c);
      l += v[c] * v[c];
    }
    bool some = l > 0 && l < INFINITY;
    if (!some || (above && v[2] < 0)) {
      ylmL_result(L, 0,
                  ylm_fail(&e, YLM_EDOMAIN, "%s: row %zu %s", name, k + 1,
                           some ? "is below the surface" : "has no direction"),
                  &e);
      return NULL;
    }
    for (size_t c = 0; c < 3; c++) ((float *)to->data)[3 * k + c] = (float)(v[c] / sqrt(l));
  }
  return to;
}

/* The rows of two arrays of rows of three, one of which may have one for all; 0: they differ, or
   there are none. */
static size_t pairs(lua_State *L, int i, int k) {
  size_t a = ylmL_array_check(L, i)->count / 3, b = ylmL_array_check(L, k)->count / 3;
  return a == b || b == 1 ? a : a == 1 ? b : 0;
}

#define ROWS(a) ((const float(*)[3])(a)->data)

/* material_eval(material, wi [n][3], wo [n][3], out [n][3] float | nil) -> f; one of the two may be
   one row for all */
static int material_eval(lua_State *L) {
  const ylm_material *m = ylmL_material_check(L, 1);
  size_t n = pairs(L, 2, 3);
  ylm_status s = YLM_OK;
  lua_settop(L, 4);
  ylmL_array *f = ylmL_array_result(L, 4, YLM_FLOAT, 2, (size_t[]){n, 3}, &s);
  if (!f) return ylmL_result(L, 0, s, NULL);
  ylmL_array *wi = ylmL_unit_rows(L, 2, n, "wi", false),
             *wo = wi ? ylmL_unit_rows(L, 3, n, "wo", false) : NULL;
  if (!wo) return 3;
  ylm_material_eval(m, n, ROWS(wi), ROWS(wo), f->data);
  lua_pushvalue(L, 5);
  return 1;
}

/* material_pdf(material, wi [n][3], wo [n][3], out [n] float | nil) -> pdf */
static int material_pdf(lua_State *L) {
  const ylm_material *m = ylmL_material_check(L, 1);
  size_t n = pairs(L, 2, 3);
  ylm_status s = YLM_OK;
  lua_settop(L, 4);
  ylmL_array *pdf = ylmL_array_result(L, 4, YLM_FLOAT, 1, (size_t[]){n}, &s);
  if (!pdf) return ylmL_result(L, 0, s, NULL);
  ylmL_array *wi = ylmL_unit_rows(L, 2, n, "wi", false),
             *wo = wi ? ylmL_unit_rows(L, 3, n, "wo", false) : NULL;
  if (!wo) return 3;
  ylm_material_pdf(m, n, ROWS(wi), ROWS(wo), pdf->data);
  lua_pushvalue(L, 5);
  return 1;
}

/* material_sample(material, wo [n][3], u [n][3] float, wi, weight, pdf | nil) -> wi [n][3], weight
   [n][3], pdf [n]; wo may be one row for all */
static int material_sample(lua_State *L) {
  const ylm_material *m = ylmL_material_check(L, 1);
  ylmL_array *u = ylmL_array_check(L, 3), *out[3];
  size_t n = u->count / 3, shape[2] = {n, 3};
  ylm_status s = YLM_OK;
  ylm_error e = {0};
  lua_settop(L, 6);
  if (u->dtype != YLM_FLOAT || pairs(L, 3, 2) != n) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  const float *x = u->data;
  for (size_t i = 0; i < u->count; i++)
    if (!(x[i] >= 0 && x[i] < 1))
      return ylmL_result(L, 0,
                         ylm_fail(&e, YLM_EDOMAIN, "u: row %zu has %g: numbers from 0, below 1",
                                  i / 3 + 1, (double)x[i]),
                         &e);
  for (int k = 0; k < 3; k++) {
    out[k] = ylmL_array_result(L, 4 + k, YLM_FLOAT, k < 2 ? 2 : 1, shape, &s);
    if (!out[k]) return ylmL_result(L, 0, s, NULL);
  }
  ylmL_array *wo = ylmL_unit_rows(L, 2, n, "wo", false);
  if (!wo) return 3;
  ylm_material_sample(m, n, ROWS(wo), ROWS(u), out[0]->data, out[1]->data, out[2]->data);
  lua_settop(L, 9);
  return 3;
}

/* material_reflectance(material, wo [n][3]) -> [n][3] */
static int material_reflectance(lua_State *L) {
  const ylm_material *m = ylmL_material_check(L, 1);
  size_t n = ylmL_array_check(L, 2)->count / 3;
  lua_settop(L, 2);
  ylmL_array *wo = ylmL_unit_rows(L, 2, n, "wo", false);
  if (!wo) return 3;
  ylmL_array *to = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  if (!to) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_material_reflectance(m, n, ROWS(wo), to->data);
  return 1;
}

/* material_isotropic(material) -> boolean */
static int material_isotropic(lua_State *L) {
  lua_pushboolean(L, ylm_material_isotropic(ylmL_material_check(L, 1)));
  return 1;
}

/* material_degrees(material, error, most, angles) -> list of degrees */
static int material_degrees(lua_State *L) {
  enum { VIEWS = 90 };
  const ylm_material *m = ylmL_material_check(L, 1);
  double error = (double)luaL_checknumber(L, 2), angle[VIEWS];
  int most = (int)luaL_checknumber(L, 3), degree[VIEWS];
  luaL_checktype(L, 4, LUA_TTABLE);
  size_t n = lua_rawlen(L, 4);
  if (n > VIEWS) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  for (size_t i = 0; i < n; i++) {
    lua_rawgeti(L, 4, (int)i + 1);
    angle[i] = (double)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  ylm_status s = ylm_material_degrees(m, error, most, n, angle, degree);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  lua_createtable(L, (int)n, 0);
  for (size_t i = 0; i < n; i++) {
    ylmL_push_count(L, (uint64_t)degree[i]);
    lua_rawseti(L, -2, (int)i + 1);
  }
  return 1;
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
                                     {"material_check", material_check},
                                     {"material_create", material_create},
                                     {"material_albedo", material_albedo},
                                     {"material_eval", material_eval},
                                     {"material_sample", material_sample},
                                     {"material_pdf", material_pdf},
                                     {"material_reflectance", material_reflectance},
                                     {"material_isotropic", material_isotropic},
                                     {"material_degrees", material_degrees},
                                     {"material_transfer", material_transfer},
                                     {NULL, NULL}};

void ylmL_open_material(lua_State *L) { luaL_setfuncs(L, functions, 0); }
