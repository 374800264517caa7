/* binding_grid.c - how a bake is asked for: the form, its source, the object that is to be the
 * grid. */
#include <stdlib.h>
#include <string.h>

#include "binding_grid.h"
#include "ylm_geom.h"

ylm_grid **ylmL_grid_new(lua_State *L) {
  ylm_grid **g = lua_newuserdata(L, sizeof *g);
  *g = NULL;
  luaL_getmetatable(L, YLM_GRID_TYPE);
  lua_setmetatable(L, -2);
  return g;
}

ylm_grid *ylmL_grid_check(lua_State *L, int i) {
  ylm_grid **g = ylmL_check(L, i, YLM_GRID_TYPE);
  if (!*g) luaL_argerror(L, i, "the grid has been closed");
  if (ylm_grid_spent(*g)) luaL_argerror(L, i, "the grid is spent: an update ran out of memory");
  if (ylm_grid_updating(*g)) luaL_argerror(L, i, "the grid is being updated");
  return *g;
}

ylm_grid_interpolation ylmL_grid_interpolation(lua_State *L, int i) {
  static const char *const names[] = {"hermite", "taylor", "linear", NULL};
  return (ylm_grid_interpolation)luaL_checkoption(L, i, NULL, names);
}

ylm_quantity ylmL_grid_quantity(lua_State *L, int i) {
  static const char *const names[] = {
#define X(name) #name,
      YLM_QUANTITY_LIST(X)
#undef X
          NULL};
  return (ylm_quantity)luaL_checkoption(L, i, names[0], names);
}

/* The place of entry `name` in `words`, the first where there is none. */
static int choice(lua_State *L, int table, const char *name, const char *const *words) {
  lua_getfield(L, table, name);
  int k = luaL_checkoption(L, -1, words[0], words);
  lua_pop(L, 1);
  return k;
}

static bool boolean(lua_State *L, int table, const char *name) {
  lua_getfield(L, table, name);
  bool yes = lua_toboolean(L, -1);
  lua_pop(L, 1);
  return yes;
}

static double number(lua_State *L, int table, const char *name) {
  lua_getfield(L, table, name);
  double x = luaL_checknumber(L, -1);
  lua_pop(L, 1);
  return x;
}

/* Numbers 1 .. n of list `name` in the table. */
static void list(lua_State *L, int table, const char *name, int n, double *out) {
  lua_getfield(L, table, name);
  luaL_checktype(L, -1, LUA_TTABLE);
  for (int i = 0; i < n; i++) {
    lua_rawgeti(L, -1, i + 1);
    out[i] = luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
}

/* The fingerprint `name` of the table on top, 16 digits; false: it has none. */
static bool print_of(lua_State *L, const char *name, uint64_t *print) {
  lua_getfield(L, -1, name);
  bool is_there = !lua_isnil(L, -1);
  if (is_there) *print = strtoull(luaL_checkstring(L, -1), NULL, 16);
  lua_pop(L, 1);
  return is_there;
}

/* The fingerprints in the table's field `prints`, which may be missing. */
static ylm_grid_prints prints_of(lua_State *L, int table) {
  ylm_grid_prints p = {0};
  lua_getfield(L, table, "prints");
  if (lua_istable(L, -1)) {
    if (print_of(L, "geometry", &p.geometry)) p.known |= YLM_GRID_PRINT_GEOMETRY;
    if (print_of(L, "materials", &p.materials)) p.known |= YLM_GRID_PRINT_MATERIALS;
    if (print_of(L, "lights", &p.lights)) p.known |= YLM_GRID_PRINT_LIGHTS;
  }
  lua_pop(L, 1);
  return p;
}

ylm_grid_form ylmL_grid_form(lua_State *L, int i) {
  static const char *const kinds[] = {"adaptive_grid", "uniform_grid", NULL};
  static const char *const metrics[] = {"absolute", "relative", NULL};
  static const char *const channels[] = {"none", "luminance", "rgb", NULL};
  static const int numbers[] = {0, 1, 3};
  ylm_grid_form f = {0};
  double cells[3];
  luaL_checktype(L, i, LUA_TTABLE);
  f.kind = (ylm_grid_kind)choice(L, i, "kind", kinds);
  list(L, i, "bounds", 6, f.bounds);
  f.lmax = (int)number(L, i, "lmax");
  f.channels = numbers[choice(L, i, "channels", channels)];
  f.metric_channels = numbers[choice(L, i, "metric_channels", channels)];
  f.depth = (int)number(L, i, "depth");
  list(L, i, "cells", 3, cells);
  for (int a = 0; a < 3; a++) f.cells[a] = (uint32_t)cells[a];
  f.metric = (ylm_grid_metric)choice(L, i, "metric", metrics);
  f.threshold = number(L, i, "threshold");
  f.tolerance = number(L, i, "tolerance");
  f.continuous = boolean(L, i, "continuous");
  f.dynamic = boolean(L, i, "dynamic");
  static const char *const measures[] = {"coefficients", "irradiance", NULL};
  f.measure = (ylm_grid_measure)choice(L, i, "measure", measures);
  lua_getfield(L, i, "quantity");
  f.quantity = ylmL_grid_quantity(L, -1);
  lua_pop(L, 1);
  lua_getfield(L, i, "bias");
  f.bias = luaL_optnumber(L, -1, 0);
  lua_pop(L, 1);
  lua_getfield(L, i, "floor");
  f.floor = luaL_optnumber(L, -1, 0);
  lua_pop(L, 1);
  lua_getfield(L, i, "body");
  if (!lua_isnil(L, -1)) {
    double body[5];
    lua_pop(L, 1);
    list(L, i, "body", 5, body);
    f.body = (ylm_grid_body){{body[0], body[1], body[2]}, body[3], body[4]};
  } else
    lua_pop(L, 1);
  f.prints = prints_of(L, i);
  return f;
}

const ylm_grid_mesh *ylmL_grid_meshes(lua_State *L, int i, size_t *n) {
  size_t far = 0; /* numbers of meshes far from 0, which are taken in double */
  *n = lua_rawlen(L, i);
  ylm_grid_mesh *mesh = lua_newuserdata(L, (*n + 1) * sizeof *mesh);
  for (size_t k = 0; k < *n; k++) {
    lua_rawgeti(L, i, (int)k + 1);
    const ylm_mesh *m = ylmL_mesh_check(L, lua_gettop(L));
    mesh[k] = (ylm_grid_mesh){m->vertices, m->triangles, YLM_FLOAT, m->position, m->index};
    lua_pop(L, 1); /* the list keeps it */
    far += ylm_mesh_is_far(m) ? 3 * m->vertices : 0;
  }
  double *place = far ? lua_newuserdata(L, far * sizeof *place) : NULL;
  for (size_t k = 0; place && k < *n; k++) {
    lua_rawgeti(L, i, (int)k + 1);
    const ylm_mesh *m = ylmL_mesh_check(L, lua_gettop(L));
    lua_pop(L, 1);
    if (!ylm_mesh_is_far(m)) continue;
    for (size_t v = 0; v < m->vertices; v++) ylm_mesh_place(m, v, place + 3 * v);
    mesh[k].dtype = YLM_DOUBLE;
    mesh[k].position = place;
    place += 3 * m->vertices;
  }
  return mesh;
}

const ylm_grid_reach *ylmL_grid_reach(lua_State *L, int i, ylm_grid_reach *reach) {
  size_t size;
  const char *bytes = lua_tolstring(L, i, &size);
  if (!bytes || size != sizeof *reach) return NULL;
  memcpy(reach, bytes, sizeof *reach);
  return reach;
}

/* The array `name` of the table, which keeps it, or NULL. */
static const ylmL_array *named_array(lua_State *L, int table, const char *name) {
  lua_getfield(L, table, name);
  const ylmL_array *a = ylmL_array_opt(L, lua_gettop(L));
  lua_pop(L, 1);
  return a;
}

ylm_grid_source ylmL_grid_source(lua_State *L, ylmL_progress *progress) {
  bool surfaces = lua_istable(L, 3);
  const ylmL_array *occupied = surfaces ? NULL : ylmL_array_opt(L, 3);
  ylm_grid_source s = {.seed = (uint64_t)luaL_checknumber(L, 4),
                       .threads = (int)luaL_checknumber(L, 5),
                       .max_points = (size_t)luaL_checknumber(L, 6),
                       .progress = ylmL_progress_begin(L, 7, progress)};
  if (occupied) {
    s.occupied = occupied->count / 3;
    s.occupied_points = occupied->data;
    s.occupied_dtype = occupied->dtype;
    const ylmL_array *normals = named_array(L, 1, "normals");
    if (normals && normals->count == occupied->count && normals->dtype == occupied->dtype)
      s.normals = normals->data;
    const ylmL_array *limits = named_array(L, 1, "limits");
    if (limits && limits->dtype == YLM_FLOAT && limits->count == s.occupied)
      s.limits = limits->data;
  }
  if (surfaces) s.mesh = ylmL_grid_meshes(L, 3, &s.meshes);
  lua_getfield(L, 1, "team");
  s.team = ylmL_team_opt(L, -1); /* the table keeps it */
  lua_pop(L, 1);
  lua_getfield(L, 1, "reach");
  ylm_grid_reach *room = lua_newuserdata(L, sizeof *room); /* stays on the stack */
  s.reach = ylmL_grid_reach(L, -2, room);
  lua_getfield(L, 1, "like"); /* the form keeps it */
  if (!lua_isnil(L, -1)) s.like = ylmL_grid_check(L, lua_gettop(L));
  lua_pop(L, 1);
  return s;
}
