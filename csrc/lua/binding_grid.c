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
  return (ylm_grid_interpolation)luaL_checkoption(L, i, NULL, ylmL_interpolation_choices);
}

ylm_quantity ylmL_grid_quantity(lua_State *L, int i) {
  return (ylm_quantity)luaL_checkoption(L, i, ylmL_quantity_choices[0], ylmL_quantity_choices);
}

/* The fingerprint `name` of the table on top, 16 digits; false: it has none. */
static bool print_of(lua_State *L, const char *name, uint64_t *print) {
  lua_getfield(L, -1, name);
  bool is_there = !lua_isnil(L, -1);
  if (is_there) *print = strtoull(luaL_checkstring(L, -1), NULL, 16);
  lua_pop(L, 1);
  return is_there;
}

/* The fingerprints in the table at `i`, or none where nil stands there. */
static void read_prints(lua_State *L, int i, void *field) {
  ylm_grid_prints *p = field;
  if (lua_isnil(L, i)) return;
  lua_pushvalue(L, i);
  if (print_of(L, "geometry", &p->geometry)) p->known |= YLM_GRID_PRINT_GEOMETRY;
  if (print_of(L, "materials", &p->materials)) p->known |= YLM_GRID_PRINT_MATERIALS;
  if (print_of(L, "lights", &p->lights)) p->known |= YLM_GRID_PRINT_LIGHTS;
  lua_pop(L, 1);
}

/* How many channels a word names, of ylmL_metric_channels_choices. */
static const int channels_of[] = {1, 3, 0};

typedef struct form_entry {
  ylm_grid_form f;
  int channels, metric_channels;
  double cells[3], body[5];
  int other; /* entries of the source and of bricks, which others read */
} form_entry;

static const ylmL_entry form_entries[] = {
    YLML(form_entry, f.kind, "kind", CHOICE, .choices = ylmL_grid_form_choices),
    YLML(form_entry, f.bounds, "bounds", NUMBERS),
    YLML(form_entry, f.lmax, "lmax", INT),
    YLML(form_entry, channels, "channels", CHOICE, .choices = ylmL_metric_channels_choices),
    YLML(form_entry, metric_channels, "metric_channels", CHOICE,
         .choices = ylmL_metric_channels_choices),
    YLML(form_entry, f.depth, "depth", INT),
    YLML(form_entry, cells, "cells", NUMBERS),
    YLML(form_entry, f.metric, "metric", CHOICE, .choices = ylmL_metric_choices),
    YLML(form_entry, f.threshold, "threshold", DOUBLE),
    YLML(form_entry, f.tolerance, "tolerance", DOUBLE),
    YLML(form_entry, f.continuous, "continuous", BOOL),
    YLML(form_entry, f.dynamic, "dynamic", BOOL),
    YLML(form_entry, f.measure, "measure", CHOICE, .choices = ylmL_measure_choices,
         .optional = true),
    YLML(form_entry, f.quantity, "quantity", CHOICE, .choices = ylmL_quantity_choices,
         .optional = true),
    YLML(form_entry, f.floor, "floor", DOUBLE, .optional = true),
    YLML(form_entry, body, "body", NUMBERS, .optional = true),
    YLML(form_entry, f.prints, "prints", READ, .read = read_prints),
    YLML(form_entry, other, "normals", VALUE),
    YLML(form_entry, other, "team", VALUE),
    YLML(form_entry, f.sides, "sides", BOOL, .optional = true),
    YLML(form_entry, other, "walls", VALUE),
    YLML(form_entry, other, "budget", VALUE),
    YLML(form_entry, other, "squares", VALUE),
    YLML(form_entry, other, "aim", VALUE),
    YLML(form_entry, other, "within", VALUE),
    YLML(form_entry, other, "like", VALUE),
    YLML(form_entry, other, "bricks", VALUE),
    {.name = NULL}};

ylm_grid_form ylmL_grid_form(lua_State *L, int i) {
  form_entry e = {.other = 0};
  lua_pushvalue(L, i);
  int top = lua_gettop(L);
  ylmL_read(L, top, form_entries, &e);
  lua_settop(L, top - 1);
  for (int a = 0; a < 3; a++) e.f.cells[a] = (uint32_t)e.cells[a];
  e.f.channels = channels_of[e.channels];
  e.f.metric_channels = channels_of[e.metric_channels];
  const double *b = e.body;
  e.f.body = (ylm_grid_body){{b[0], b[1], b[2]}, b[3], b[4]};
  return e.f;
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

const ylm_grid_walls *ylmL_grid_walls(lua_State *L, int i, ylm_grid_walls *walls) {
  size_t size;
  const char *bytes = lua_tolstring(L, i, &size);
  if (!bytes || size != sizeof *walls) return NULL;
  memcpy(walls, bytes, sizeof *walls);
  return walls;
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
  }
  if (surfaces) s.mesh = ylmL_grid_meshes(L, 3, &s.meshes);
  lua_getfield(L, 1, "team");
  s.team = ylmL_team_opt(L, -1); /* the table keeps it */
  lua_pop(L, 1);
  lua_getfield(L, 1, "aim");
  s.aim = (double)lua_tonumber(L, -1);
  lua_pop(L, 1);
  lua_getfield(L, 1, "budget");
  s.budget = (size_t)lua_tonumber(L, -1);
  lua_pop(L, 1);
  lua_getfield(L, 1, "squares");
  s.squares = lua_toboolean(L, -1);
  lua_pop(L, 1);
  lua_getfield(L, 1, "within");
  if (!lua_isnil(L, -1)) {
    double *within = lua_newuserdata(L, 6 * sizeof *within);
    for (int k = 0; k < 6; k++) {
      lua_rawgeti(L, -2, k + 1);
      within[k] = (double)lua_tonumber(L, -1);
      lua_pop(L, 1);
    }
    s.within = within; /* stays on the stack, in place of its list */
    lua_replace(L, -2);
  } else {
    lua_pop(L, 1);
  }
  lua_getfield(L, 1, "walls");
  ylm_grid_walls *walls = lua_newuserdata(L, sizeof *walls); /* stays on the stack */
  s.walls = ylmL_grid_walls(L, -2, walls);
  lua_getfield(L, 1, "like"); /* the form keeps it */
  if (!lua_isnil(L, -1)) s.like = ylmL_grid_check(L, lua_gettop(L));
  lua_pop(L, 1);
  return s;
}
