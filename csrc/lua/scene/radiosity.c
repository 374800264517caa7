/* radiosity.c - light on elements as a Lua object. */
#include "transfer.h"

ylm_radiosity *ylmL_radiosity(lua_State *L, int i) {
  return ylmL_held_check(L, i, YLML_RADIOSITY)->object;
}

void ylmL_read_radiosity(lua_State *L, int i, void *field) {
  *(const ylm_radiosity **)field = ylmL_radiosity(L, i);
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

/* radiosity_rays(radiosity, scene, light_samples, guides, seed, threads, progress) -> radiosity */
static int radiosity_rays(lua_State *L) {
  ylm_radiosity *r = ylmL_radiosity(L, 1);
  const ylm_scene *scene = ylmL_scene(L, 2);
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 7);
  if (ylmL_radiosity_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_status s = ylm_radiosity_rays(r, scene, (int)luaL_checknumber(L, 3), lua_toboolean(L, 4),
                                    (uint64_t)luaL_checknumber(L, 5), (int)luaL_optnumber(L, 6, 0),
                                    ylmL_progress_begin(L, 7, &p), &e);
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
      ylm_radiosity_field(r, field, (int)luaL_checknumber(L, 3), (int)luaL_optnumber(L, 4, 0),
                          ylmL_progress_begin(L, 5, &p), &e);
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
  if (s->guides > 0) ylmL_set_count(L, "guides", s->guides);
  if (s->guides > 0) ylmL_set_count(L, "guide_rays", s->guide_rays);
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

/* radiosity_values(radiosity, "direct" | "irradiance" | "leaving" | "averaged") -> float [n][3] */
static int radiosity_values(lua_State *L) {
  static const char *const names[] = {"direct", "irradiance", "leaving", "averaged", NULL};
  ylm_radiosity *r = ylmL_radiosity(L, 1);
  int which = luaL_checkoption(L, 2, NULL, names);
  const float *rows = which == 0   ? ylm_radiosity_direct(r)
                      : which == 1 ? ylm_radiosity_irradiance(r)
                                   : ylm_radiosity_leaving(r);
  ylm_status s = which == 3 ? ylm_radiosity_averaged(r, 0, &rows) : YLM_OK;
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
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

typedef struct map_form {
  ylm_radiosity_map m;
  ylmL_array *uvs, *out, *coverage;
  double lmax;  /* is asked for, and not used */
  int side;     /* SIDE_UNKNOWN where it is to be found */
  int progress; /* on the stack */
} map_form;

enum { SIDE_UNKNOWN = -1 };

static const ylmL_entry map_entries[] = {
    YLML(map_form, m.mesh, "mesh", COUNT, .least = 1, .most = 1e9),
    YLML(map_form, side, "side", CHOICE, .choices = ylmL_side_choices, .optional = true),
    YLML(map_form, uvs, "uvs", ARRAY),
    YLML(map_form, out, "out", ARRAY),
    YLML(map_form, coverage, "coverage", ARRAY),
    YLML(map_form, m.indirect, "indirect", BOOL),
    YLML(map_form, m.scene, "scene", READ, .read = ylmL_read_scene, .optional = true),
    YLML(map_form, m.field, "field", FIELD, .optional = true),
    YLML(map_form, lmax, "lmax", DOUBLE, .optional = true),
    YLML(map_form, m.links, "links", INT),
    YLML(map_form, m.light_samples, "light_samples", INT),
    YLML(map_form, m.gutter, "gutter", INT),
    YLML(map_form, m.seed, "seed", UINT64),
    YLML(map_form, m.threads, "threads", INT, .optional = true),
    YLML(map_form, progress, "progress", VALUE),
    {.name = NULL}};

/* Is the back of the mesh the side that has elements, of front and back? */
static bool is_back(const ylm_transfer *t, size_t mesh, size_t vertices) {
  ylm_scene_place front = {.mesh = (uint32_t)mesh};
  return vertices > 0 && ylm_scene_triangles(ylm_transfer_scene(t), mesh) > 0 &&
         ylm_transfer_element(t, &front) == ylm_transfer_count(t);
}

/* radiosity_map(radiosity, {mesh from 1, side: "front", "back" or nil, uvs float [n][2], out float [h][w][3],
   coverage float [h][w], indirect, scene or nil, field or nil, lmax, links, light_samples, gutter, seed, threads,
   progress}) -> how many texels more than one triangle has */
static int radiosity_map(lua_State *L) {
  map_form f = {.side = SIDE_UNKNOWN};
  ylm_radiosity *r = ylmL_radiosity(L, 1);
  const ylm_transfer *t = ylm_radiosity_transfer(r);
  const ylm_scene *own = ylm_transfer_scene(t);
  ylm_error e = {0};
  ylmL_progress p;
  size_t overlaps = 0, vertices = 0;
  ylmL_read(L, 2, map_entries, &f);
  const ylmL_array *uvs = f.uvs, *out = f.out, *coverage = f.coverage;
  size_t mesh = f.m.mesh -= 1;
  if (mesh < ylm_scene_meshes(own))
    vertices = ylm_scene_first_vertex(own, mesh + 1) - ylm_scene_first_vertex(own, mesh);
  if (uvs->dtype != YLM_FLOAT || out->dtype != YLM_FLOAT || coverage->dtype != YLM_FLOAT)
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (uvs->count != 2 * vertices || out->count != 3 * coverage->count || coverage->axes < 2)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  f.m.uvs = uvs->data;
  f.m.width = (int)coverage->shape[1];
  f.m.height = (int)coverage->shape[0];
  f.m.back = f.side == SIDE_UNKNOWN ? is_back(t, mesh, vertices) : f.side;
  f.m.progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_status s = YLM_OK;
  if (f.m.indirect) s = ylm_radiosity_aim(r, f.m.threads, f.m.progress);
  if (s == YLM_OK) s = ylm_radiosity_lightmap(r, &f.m, out->data, coverage->data, &overlaps, &e);
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
