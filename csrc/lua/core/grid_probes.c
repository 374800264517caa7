/* grid_probes.c - ylm.probes: a grid's light as engines take it. lua/ylm/grid/parted.lua. */
#include "grid.h"

#define PROBES_TYPE "ylm.probes"

static ylm_grid_probes *probes_check(lua_State *L, int i) {
  ylm_grid_probes **p = ylmL_check(L, i, PROBES_TYPE);
  return *p;
}

static ylm_grid_probes **probes_new(lua_State *L) {
  ylm_grid_probes **p = lua_newuserdata(L, sizeof *p);
  *p = NULL;
  luaL_getmetatable(L, PROBES_TYPE);
  lua_setmetatable(L, -2);
  return p;
}

/* probes_size(probes, bits) -> { bounds, roots, cells, bricks, points, lmax, bytes of its file, of these rest beside points and names,
   names } */
static int probes_size(lua_State *L) {
  const ylm_grid_probes *p = probes_check(L, 1);
  ylm_grid_probes_size s = ylm_grid_probes_look(p);
  ylm_grid_probes_bytes b;
  ylm_status status = ylm_grid_probes_measure(p, (int)luaL_checknumber(L, 2), &b);
  if (status != YLM_OK) return ylmL_result(L, 0, status, NULL);
  lua_newtable(L);
  ylmL_set_count(L, "cells", s.cells);
  ylmL_set_count(L, "leaves_of_several", s.leaves_of_several);
  ylmL_set_count(L, "bricks", s.bricks);
  ylmL_set_count(L, "points", s.points);
  ylmL_set_count(L, "means", b.means);
  ylmL_set_count(L, "names", b.names);
  ylmL_set_count(L, "rest", b.rest);
  ylmL_set_count(L, "lmax", (uint64_t)s.lmax);
  ylmL_set_count(L, "bytes", b.all);
  lua_createtable(L, 2, 0);
  for (int side = 0; side < 2; side++) {
    lua_createtable(L, 3, 0);
    for (int a = 0; a < 3; a++) {
      lua_pushnumber(L, s.bounds[3 * side + a]);
      lua_rawseti(L, -2, a + 1);
    }
    lua_rawseti(L, -2, side + 1);
  }
  lua_setfield(L, -2, "bounds");
  lua_createtable(L, 3, 0);
  for (int a = 0; a < 3; a++) {
    ylmL_push_count(L, s.roots[a]);
    lua_rawseti(L, -2, a + 1);
  }
  lua_setfield(L, -2, "roots");
  return 1;
}

static const void *rows(lua_State *L, ylmL_array *a, ylm_dtype t, size_t count) {
  if (!a || a->dtype != t || a->count != count) luaL_error(L, "another array expected");
  return a->data;
}

/* probes_irradiance(probes, points [n][3] double, normals [n][3] float) -> [n][3] */
static int probes_irradiance(lua_State *L) {
  const ylm_grid_probes *p = probes_check(L, 1);
  ylmL_array *points = ylmL_array_check(L, 2), *normals = ylmL_array_check(L, 3);
  size_t shape[2] = {points->shape[0], 3}, n = shape[0];
  const void *x = rows(L, points, YLM_DOUBLE, 3 * n), *q = rows(L, normals, YLM_FLOAT, 3 * n);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, shape);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_grid_probes_irradiance(p, n, x, q, out->data);
  return 1;
}

typedef struct places_arguments {
  ylmL_array *points, *normals, *wanted, *weight;
  ylm_grid_probes_places at;
} places_arguments;

static const ylmL_entry places_entries[] = {
    YLML(places_arguments, points, "points", ARRAY),
    YLML(places_arguments, normals, "normals", ARRAY),
    YLML(places_arguments, wanted, "wanted", ARRAY),
    YLML(places_arguments, weight, "weight", ARRAY),
    YLML(places_arguments, at.hold, "hold", DOUBLE),
    YLML(places_arguments, at.hold_ghosts, "hold_ghosts", DOUBLE),
    YLML(places_arguments, at.quick, "quick", BOOL, .optional = true),
    YLML(places_arguments, at.threads, "threads", INT, .optional = true),
    {.name = NULL}};

static ylm_grid_probes_places read_places(lua_State *L, int i) {
  places_arguments x = {.points = NULL};
  ylmL_read(L, i, places_entries, &x);
  size_t n = x.at.n = x.points->shape[0];
  x.at.point = rows(L, x.points, YLM_DOUBLE, 3 * n);
  x.at.normal = rows(L, x.normals, YLM_FLOAT, 3 * n);
  x.at.wanted = rows(L, x.wanted, YLM_FLOAT, 3 * n);
  x.at.weight = rows(L, x.weight, YLM_FLOAT, n);
  return x.at;
}

/* probes_make(grid, lmax, cuts, bytes of ylm_grid_walls | nil, places as of probes_fit | nil) -> probes */
static int probes_make(lua_State *L) {
  ylm_error e = {0};
  const ylm_grid *g = ylmL_grid_check(L, 1);
  int lmax = (int)luaL_checknumber(L, 2), cuts = (int)luaL_checknumber(L, 3);
  ylm_grid_walls room;
  const ylm_grid_walls *walls = ylmL_grid_walls(L, 4, &room);
  bool placed = lua_istable(L, 5);
  ylm_grid_probes_places at = {.n = 0};
  if (placed) at = read_places(L, 5);
  ylm_grid_probes **p = probes_new(L);
  return ylmL_result(L, 1, ylm_grid_probes_make(g, lmax, cuts, walls, placed ? &at : NULL, p, &e),
                     &e);
}

/* probes_fit(probes, { points, normals, wanted, weight, hold, hold_ghosts, quick, threads }): the probes change -> true */
static int probes_fit(lua_State *L) {
  ylm_grid_probes *p = probes_check(L, 1);
  ylm_grid_probes_places at = read_places(L, 2);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, ylm_grid_probes_fit(p, &at), NULL);
}

/* probes_copy(probes) -> another of the same */
static int probes_copy(lua_State *L) {
  const ylm_grid_probes *p = probes_check(L, 1);
  return ylmL_result(L, 1, ylm_grid_probes_copy(p, probes_new(L)), NULL);
}

/* probes_thin(probes, places as of probes_fit, points): the probes change -> true */
static int probes_thin(lua_State *L) {
  ylm_grid_probes *p = probes_check(L, 1);
  size_t points = (size_t)luaL_checknumber(L, 3);
  lua_settop(L, 2);
  ylm_grid_probes_places at = read_places(L, 2);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, ylm_grid_probes_thin(p, &at, points), NULL);
}

/* probes_encode(probes, bits) -> the bytes of the file */
static int probes_encode(lua_State *L) {
  ylm_error e = {0};
  unsigned char *data = NULL;
  size_t size = 0;
  ylm_status s =
      ylm_grid_probes_encode(probes_check(L, 1), (int)luaL_checknumber(L, 2), &data, &size, &e);
  if (s == YLM_OK) lua_pushlstring(L, (const char *)data, size);
  ylm_free(data);
  return ylmL_result(L, 1, s, &e);
}

/* probes_decode(bytes, name) -> probes */
static int probes_decode(lua_State *L) {
  ylm_error e = {0};
  size_t size;
  const char *data = luaL_checklstring(L, 1, &size), *name = luaL_checkstring(L, 2);
  ylm_grid_probes **p = probes_new(L);
  return ylmL_result(L, 1, ylm_grid_probes_decode((const unsigned char *)data, size, name, p, &e),
                     &e);
}

static int probes_close(lua_State *L) {
  ylm_grid_probes **p = ylmL_check(L, 1, PROBES_TYPE);
  ylm_grid_probes_free(*p);
  *p = NULL;
  return 0;
}

static const luaL_Reg functions[] = {{"probes_make", probes_make},
                                     {"probes_size", probes_size},
                                     {"probes_irradiance", probes_irradiance},
                                     {"probes_fit", probes_fit},
                                     {"probes_thin", probes_thin},
                                     {"probes_copy", probes_copy},
                                     {"probes_encode", probes_encode},
                                     {"probes_decode", probes_decode},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", probes_close}, {NULL, NULL}};

void ylmL_open_grid_probes(lua_State *L) {
  ylmL_type(L, PROBES_TYPE, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
