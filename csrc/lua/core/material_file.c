/* material_file.c - materials from and to files, and the bins that a function fills. */
#include <math.h>

#include "../binding.h"
#include "ylm_material.h"

#define BINS ((size_t)YLM_MERL_THETA_D * YLM_MERL_PHI_D)

/* A larger file is no material. */
#define LARGEST_FILE ((size_t)1 << 30)

/* material_read(kind, number, path) -> material, of kinds that a file and one number describe */
static int material_read(lua_State *L) {
  int kind = ylm_material_kind_find(luaL_checkstring(L, 1));
  float x = (float)luaL_checknumber(L, 2);
  const char *path = luaL_checkstring(L, 3);
  ylm_error e = {0};
  ylm_material **m = ylmL_material_new(L);
  unsigned char *bytes;
  size_t size;
  ylm_status s = ylm_material_check(kind, 1, &x, &e);
  if (s == YLM_OK) s = ylm_file_read(path, LARGEST_FILE, &bytes, &size, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  s = ylm_material_load(kind, 1, &x, bytes, size, path, m, &e);
  ylm_free(bytes);
  if (s == YLM_OK) ylmL_charge(L, ylm_material_bytes(*m));
  return ylmL_result(L, 1, s, &e);
}

/* material_write(material, path) -> true, as one of MERL's files */
static int material_write(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = ylm_material_write_merl(ylmL_material_check(L, 1), luaL_checkstring(L, 2), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static void set_fact(void *to, const char *name, double x) { ylmL_set_number(to, name, x); }

/* material_facts(material) -> table of the numbers that say what its tables hold */
static int material_facts(lua_State *L) {
  const ylm_material *m = ylmL_material_check(L, 1);
  lua_newtable(L);
  ylm_material_facts(m, set_fact, L);
  return 1;
}

/* material_bins() -> extents of the bins: theta_h, theta_d, phi_d */
static int material_bins(lua_State *L) {
  lua_pushinteger(L, YLM_MERL_THETA_H);
  lua_pushinteger(L, YLM_MERL_THETA_D);
  lua_pushinteger(L, YLM_MERL_PHI_D);
  return 3;
}

static double elevation(const double d[3]) { return atan2(hypot(d[0], d[1]), d[2]); }

/* material_bin_angles(theta_h) -> list of theta_i, theta_o, phi_i - phi_o of the bins at theta_h,
   counted from 0; theta_i is -1 where a direction is not above the surface */
static int material_bin_angles(lua_State *L) {
  int theta_h = (int)luaL_checkinteger(L, 1), n = 0;
  lua_createtable(L, 3 * (int)BINS, 0);
  for (int d = 0; d < YLM_MERL_THETA_D; d++)
    for (int p = 0; p < YLM_MERL_PHI_D; p++) {
      double wi[3], wo[3];
      bool above = ylm_material_merl_centre(theta_h, d, p, wi, wo);
      double across = wo[0] * wi[1] - wo[1] * wi[0], along = wo[0] * wi[0] + wo[1] * wi[1];
      double angles[3] = {above ? elevation(wi) : -1, elevation(wo), atan2(across, along)};
      for (int a = 0; a < 3; a++) {
        lua_pushnumber(L, (lua_Number)angles[a]);
        lua_rawseti(L, -2, ++n);
      }
    }
  return 1;
}

/* material_fill_bins(array float [theta_h][theta_d][phi_d][3], theta_h, list of numbers) -> true */
static int material_fill_bins(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  size_t theta_h = (size_t)luaL_checkinteger(L, 2);
  luaL_checktype(L, 3, LUA_TTABLE);
  if (a->dtype != YLM_FLOAT || theta_h >= YLM_MERL_THETA_H ||
      a->count != YLM_MERL_THETA_H * BINS * 3)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  float *out = (float *)a->data + theta_h * BINS * 3;
  for (size_t i = 0; i < 3 * BINS; i++) {
    lua_rawgeti(L, 3, (int)i + 1);
    out[i] = (float)lua_tonumber(L, -1);
    lua_pop(L, 1);
  }
  lua_pushboolean(L, 1);
  return 1;
}

/* material_tabulate(array float [theta_h][theta_d][phi_d][3]) -> material */
static int material_tabulate(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  if (a->dtype != YLM_FLOAT) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  ylm_error e = {0};
  float none = 0;
  ylm_material **m = ylmL_material_new(L);
  ylm_status s = ylm_material_load(ylm_material_kind_find("tabulated"), 0, &none, a->data,
                                   a->count * sizeof(float), "the table", m, &e);
  if (s == YLM_OK) ylmL_charge(L, ylm_material_bytes(*m));
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {{"material_read", material_read},
                                     {"material_write", material_write},
                                     {"material_facts", material_facts},
                                     {"material_bins", material_bins},
                                     {"material_bin_angles", material_bin_angles},
                                     {"material_fill_bins", material_fill_bins},
                                     {"material_tabulate", material_tabulate},
                                     {NULL, NULL}};

void ylmL_open_material_file(lua_State *L) { luaL_setfuncs(L, functions, 0); }
