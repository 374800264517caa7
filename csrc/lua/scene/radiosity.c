/* radiosity.c - light on elements as a Lua object. */
#include "transfer.h"

#include "../binding_grid.h"

ylm_radiosity *ylmL_radiosity(lua_State *L, int i) {
  return ylmL_held_check(L, i, YLML_RADIOSITY)->object;
}

/* The grid at `i`, or NULL where another object is. */
static const ylm_grid *grid_at(lua_State *L, int i) {
  return ylmL_test(L, i, YLM_GRID_TYPE) ? ylmL_grid_check(L, i) : NULL;
}

static void destroy(void *r) { ylm_radiosity_free(r); }

/* radiosity_create(transfer) -> radiosity, dark */
static int radiosity_create(lua_State *L) {
  ylmL_held *of = ylmL_held_check(L, 1, YLML_TRANSFER);
  ylmL_held *h = ylmL_hold(L, YLML_RADIOSITY, destroy, of);
  ylm_radiosity *r;
  ylm_status s = ylm_radiosity_create(of->object, &r);
  h->object = r;
  if (s == YLM_OK) ylmL_charge(L, 64 * ylm_transfer_count(of->object));
  return ylmL_result(L, 1, s, NULL);
}

/* radiosity_rays(radiosity, scene, light_samples, seed, threads, progress) -> radiosity */
static int radiosity_rays(lua_State *L) {
  ylm_radiosity *r = ylmL_radiosity(L, 1);
  const ylm_scene *scene = ylmL_scene(L, 2);
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 6);
  if (ylmL_radiosity_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_status s =
      ylm_radiosity_rays(r, scene, (int)luaL_checknumber(L, 3), (uint64_t)luaL_checknumber(L, 4),
                         (int)luaL_optnumber(L, 5, 0), ylmL_progress_begin(L, 6, &p), &e);
  lua_pushvalue(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* radiosity_field(radiosity, object with a field, lmax, threads, progress) -> radiosity */
static int radiosity_field(lua_State *L) {
  ylm_radiosity *r = ylmL_radiosity(L, 1);
  const ylm_field *field = ylmL_field_check(L, 2);
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 5);
  if (ylmL_radiosity_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_status s =
      ylm_radiosity_field(r, field, grid_at(L, 2), (int)luaL_checknumber(L, 3),
                          (int)luaL_optnumber(L, 4, 0), ylmL_progress_begin(L, 5, &p), &e);
  lua_pushvalue(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* radiosity_set(radiosity, float [n][3]) -> radiosity */
static int radiosity_set(lua_State *L) {
  ylm_radiosity *r = ylmL_radiosity(L, 1);
  ylmL_array *a = ylmL_array_check(L, 2);
  if (ylmL_radiosity_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  if (a->dtype != YLM_FLOAT) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (a->count != 3 * ylm_transfer_count(ylm_radiosity_transfer(r)))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_radiosity_set(r, a->data);
  lua_pushvalue(L, 1);
  return 1;
}

static void set_three(lua_State *L, const char *name, const double x[3]) {
  lua_createtable(L, 3, 0);
  for (int c = 0; c < 3; c++) {
    lua_pushnumber(L, (lua_Number)x[c]);
    lua_rawseti(L, -2, c + 1);
  }
  lua_setfield(L, -2, name);
}

static void push_stats(lua_State *L, const ylm_radiosity_stats *s) {
  lua_newtable(L);
  ylmL_set_count(L, "bounces", (uint64_t)s->bounces);
  ylmL_set_boolean(L, "closed", s->closed);
  ylmL_set_number(L, "residual", s->residual);
  ylmL_set_number(L, "shrink", s->shrink);
  set_three(L, "emitted", s->emitted);
  set_three(L, "absorbed", s->absorbed);
  set_three(L, "escaped", s->escaped);
  ylmL_set_number(L, "balance", s->balance);
  ylmL_set_number(L, "close", s->close);
  ylmL_set_count(L, "rays", s->rays);
  ylmL_set_number(L, "direct_seconds", s->direct_seconds);
  ylmL_set_number(L, "solve_seconds", s->solve_seconds);
}

/* radiosity_solve(radiosity, bounces (-1: all), residual, closure, threads, progress) -> stats */
static int radiosity_solve(lua_State *L) {
  ylm_radiosity *r = ylmL_radiosity(L, 1);
  ylm_radiosity_stats stats;
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 6);
  if (ylmL_radiosity_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_status s = ylm_radiosity_solve(r, (int)luaL_checknumber(L, 2), (double)luaL_checknumber(L, 3),
                                     lua_toboolean(L, 4), (int)luaL_optnumber(L, 5, 0),
                                     ylmL_progress_begin(L, 6, &p), &stats, &e);
  if (s == YLM_OK) push_stats(L, &stats);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* radiosity_coarse(radiosity, bounces (-1: all), residual, closure, threads, into: another radiosity or nil) -> change */
static int radiosity_coarse(lua_State *L) {
  lua_settop(L, 6);
  ylm_radiosity *into = lua_isnil(L, 6) ? NULL : ylmL_radiosity(L, 6);
  double change = 0;
  ylm_error e = {0};
  if (into && ylmL_radiosity_busy(L, 6) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_status s = ylm_radiosity_coarse(ylmL_radiosity(L, 1), (int)luaL_checknumber(L, 2),
                                      (double)luaL_checknumber(L, 3), lua_toboolean(L, 4),
                                      (int)luaL_optnumber(L, 5, 0), into, &change, &e);
  lua_pushnumber(L, (lua_Number)change);
  return ylmL_result(L, 1, s, &e);
}

/* radiosity_values(radiosity, "direct" | "irradiance" | "leaving") -> float [n][3] */
static int radiosity_values(lua_State *L) {
  static const char *const names[] = {"direct", "irradiance", "leaving", NULL};
  const ylm_radiosity *r = ylmL_radiosity(L, 1);
  int which = luaL_checkoption(L, 2, NULL, names);
  const float *rows = which == 0   ? ylm_radiosity_direct(r)
                      : which == 1 ? ylm_radiosity_irradiance(r)
                                   : ylm_radiosity_leaving(r);
  size_t n = ylm_transfer_count(ylm_radiosity_transfer(r));
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++) memcpy((float *)a->data + 3 * i, rows + 4 * i, 12);
  return 1;
}

/* radiosity_write(radiosity, path) -> true */
static int radiosity_write(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = ylm_radiosity_write_ply(ylmL_radiosity(L, 1), luaL_checkstring(L, 2), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* radiosity_map(radiosity, {mesh from 1, side: "front", "back" or nil, uvs float [n][2], out float [h][w][3],
   coverage float [h][w], indirect, scene or nil, field or nil, lmax, links, light_samples, gutter, seed, threads,
   progress}) -> how many texels more than one triangle has */
static int radiosity_map(lua_State *L) {
  static const char *const names[] = {
      "mesh", "side",  "uvs",           "out",    "coverage", "indirect", "scene",    "field",
      "lmax", "links", "light_samples", "gutter", "seed",     "threads",  "progress", NULL};
  enum {
    MESH = 3,
    SIDE,
    UVS,
    OUT,
    COVERAGE,
    INDIRECT,
    SCENE,
    FIELD,
    LMAX,
    LINKS,
    SAMPLES,
    GUTTER,
    SEED,
    THREADS,
    PROGRESS
  };
  static const char *const sides[] = {"front", "back", NULL};
  const ylm_radiosity *r = ylmL_radiosity(L, 1);
  const ylm_transfer *t = ylm_radiosity_transfer(r);
  const ylm_scene *own = ylm_transfer_scene(t);
  ylm_error e = {0};
  ylmL_progress p;
  size_t overlaps = 0;
  ylmL_named(L, 2, names);
  ylmL_array *uvs = ylmL_array_check(L, UVS), *out = ylmL_array_check(L, OUT);
  ylmL_array *coverage = ylmL_array_check(L, COVERAGE);
  size_t mesh = (size_t)luaL_checknumber(L, MESH) - 1, vertices = 0;
  if (mesh < ylm_scene_meshes(own))
    vertices = ylm_scene_first_vertex(own, mesh + 1) - ylm_scene_first_vertex(own, mesh);
  if (uvs->dtype != YLM_FLOAT || out->dtype != YLM_FLOAT || coverage->dtype != YLM_FLOAT)
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (uvs->count != 2 * vertices || out->count != 3 * coverage->count || coverage->axes < 2)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_radiosity_map m = {.mesh = mesh,
                         .uvs = uvs->data,
                         .width = (int)coverage->shape[1],
                         .height = (int)coverage->shape[0],
                         .indirect = lua_toboolean(L, INDIRECT),
                         .scene = lua_isnil(L, SCENE) ? NULL : ylmL_scene(L, SCENE),
                         .field = lua_isnil(L, FIELD) ? NULL : ylmL_field_check(L, FIELD),
                         .links = (int)luaL_checknumber(L, LINKS),
                         .light_samples = (int)luaL_checknumber(L, SAMPLES),
                         .gutter = (int)luaL_checknumber(L, GUTTER),
                         .seed = (uint64_t)luaL_checknumber(L, SEED),
                         .threads = (int)luaL_optnumber(L, THREADS, 0),
                         .progress = ylmL_progress_begin(L, PROGRESS, &p)};
  ylm_scene_place front = {.mesh = (uint32_t)mesh};
  if (!lua_isnil(L, SIDE))
    m.back = luaL_checkoption(L, SIDE, NULL, sides) == 1;
  else if (vertices > 0 && ylm_scene_triangles(own, mesh) > 0)
    m.back = ylm_transfer_element(t, &front) == ylm_transfer_count(t);
  ylm_status s = ylm_radiosity_lightmap(r, &m, out->data, coverage->data, &overlaps, &e);
  ylmL_push_count(L, overlaps);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

static const luaL_Reg functions[] = {{"radiosity_create", radiosity_create},
                                     {"radiosity_rays", radiosity_rays},
                                     {"radiosity_field", radiosity_field},
                                     {"radiosity_set", radiosity_set},
                                     {"radiosity_solve", radiosity_solve},
                                     {"radiosity_values", radiosity_values},
                                     {"radiosity_write", radiosity_write},
                                     {"radiosity_map", radiosity_map},
                                     {"radiosity_close", ylmL_let_go},
                                     {"radiosity_coarse", radiosity_coarse},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};

void ylmL_open_radiosity(lua_State *L) {
  ylmL_type(L, YLML_RADIOSITY, methods);
  ylmL_type_has_field(L, ylmL_radiosity_default);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
