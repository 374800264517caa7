/* surface_map.c - lightmaps as Lua objects. */
#include "ylm_surface_map.h"

#include "transfer.h"

#define YLML_MAP "ylm.lightmap"

static void destroy(void *m) { ylm_surface_map_free(m); }

static ylm_surface_map *check_map(lua_State *L, int i) {
  return ylmL_held_check(L, i, YLML_MAP)->object;
}

typedef struct bake_form {
  ylm_surface_map_form f;
  int progress; /* on the stack */
} bake_form;

static const ylmL_entry entries[] = {
    YLML(bake_form, f.tolerance, "tolerance", DOUBLE),
    YLML(bake_form, f.aim, "aim", DOUBLE),
    YLML(bake_form, f.texels, "texels", COUNT),
    YLML(bake_form, f.even, "even", BOOL),
    YLML(bake_form, f.parts, "parts", BOOL),
    YLML(bake_form, f.smooth, "smooth", BOOL),
    YLML(bake_form, f.directional, "directional", BOOL),
    YLML(bake_form, f.gutter, "gutter", INT),
    YLML(bake_form, f.angle, "angle", DOUBLE),
    YLML(bake_form, f.stretch, "stretch", DOUBLE),
    YLML(bake_form, f.quantity, "quantity", CHOICE, .choices = ylmL_quantity_choices),
    YLML(bake_form, f.journal, "journal", STRING, .optional = true),
    YLML(bake_form, f.words, "words", STRING, .optional = true),
    YLML(bake_form, f.light.indirect, "indirect", BOOL),
    YLML(bake_form, f.light.scene, "scene", READ, .read = ylmL_read_scene, .optional = true),
    YLML(bake_form, f.light.links, "links", INT),
    YLML(bake_form, f.light.light_samples, "light_samples", INT),
    YLML(bake_form, f.light.seed, "seed", UINT64),
    YLML(bake_form, f.light.threads, "threads", INT, .optional = true),
    YLML(bake_form, progress, "progress", VALUE),
    {.name = NULL}};

/* map_bake(radiosity, {tolerance, aim, texels, even, parts, smooth, directional, gutter, angle, stretch, quantity, journal or nil,
   words or nil, indirect, scene whose lamps light directly or nil, links, light_samples, seed, threads, progress}) -> lightmap */
static int map_bake(lua_State *L) {
  bake_form f = {.progress = 0};
  ylm_radiosity *r = ylmL_radiosity(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylm_surface_map *m;
  ylmL_read(L, 2, entries, &f);
  f.f.light.progress = ylmL_progress_begin(L, f.progress, &p);
  ylmL_held *h = ylmL_hold(L, YLML_MAP, destroy, ylmL_held_check(L, 1, YLML_RADIOSITY));
  ylm_status s = YLM_OK;
  if (f.f.light.indirect) s = ylm_radiosity_aim(r, f.f.light.threads, f.f.light.progress);
  if (s == YLM_OK) s = ylm_surface_map_bake(r, &f.f, &m, &e);
  h->object = m;
  if (s == YLM_OK) {
    ylm_surface_map_stats stats;
    ylm_surface_map_look(m, &stats);
    ylmL_charge(L, 12 * stats.charts.width * stats.charts.height);
  }
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* map_stats(lightmap) -> table */
static int map_stats(lua_State *L) {
  ylm_surface_map_stats s;
  ylm_surface_map_look(check_map(L, 1), &s);
  lua_newtable(L);
  ylmL_set_count(L, "charts", s.charts.charts);
  ylmL_set_count(L, "curved", s.charts.curved);
  ylmL_set_count(L, "degenerate", s.charts.degenerate);
  ylmL_set_number(L, "stretch", s.charts.stretch);
  ylmL_set_number(L, "worst", s.charts.worst);
  ylmL_set_count(L, "width", s.charts.width);
  ylmL_set_count(L, "height", s.charts.height);
  ylmL_set_number(L, "density", s.charts.density);
  ylmL_set_number(L, "share", s.charts.share);
  ylmL_set_count(L, "sheets", s.sheets);
  ylmL_set_count(L, "places", s.places);
  ylmL_set_count(L, "rounds", s.rounds);
  ylmL_set_count(L, "rays", s.rays);
  ylmL_set_count(L, "seams", s.seams);
  ylmL_set_number(L, "jump", s.jump[0]);
  ylmL_set_number(L, "jump_1", s.jump[1]);
  ylmL_set_number(L, "jump_2", s.jump[2]);
  ylmL_set_number(L, "noise", s.noise);
  ylmL_set_count(L, "verified", s.verified);
  ylmL_set_count(L, "failed", s.failed);
  ylmL_set_number(L, "error", s.error);
  ylmL_set_number(L, "rms", s.rms);
  ylmL_set_boolean(L, "met", s.met);
  ylmL_set_boolean(L, "spent", s.spent);
  ylmL_set_boolean(L, "stalled", s.stalled);
  ylmL_set_count(L, "bodies", s.bodies);
  ylmL_set_count(L, "noisy", s.noisy);
  ylmL_set_count(L, "edges", s.edges);
  ylmL_set_number(L, "chart_seconds", s.chart_seconds);
  ylmL_set_number(L, "pack_seconds", s.pack_seconds);
  ylmL_set_number(L, "light_seconds", s.light_seconds);
  ylmL_set_number(L, "fit_seconds", s.fit_seconds);
  ylmL_set_number(L, "judge_seconds", s.judge_seconds);
  return 1;
}

/* map_verdict(lightmap, verified, failed, error, rms) */
static int map_verdict(lua_State *L) {
  ylm_surface_map_verdict(check_map(L, 1), (size_t)luaL_checknumber(L, 2),
                          (size_t)luaL_checknumber(L, 3), (double)luaL_checknumber(L, 4),
                          (double)luaL_checknumber(L, 5));
  return 0;
}

/* map_judges(lightmap, radiosity, n, seed) -> points [n][3], normals float [n][3], irradiance float [n][3] */
static int map_judges(lua_State *L) {
  const ylm_surface_map *m = check_map(L, 1);
  const ylm_radiosity *r = ylmL_radiosity(L, 2);
  size_t n = (size_t)luaL_checknumber(L, 3), drawn = 0;
  uint64_t seed = (uint64_t)luaL_checknumber(L, 4);
  ylm_scene_place *place = lua_newuserdata(L, (n + 1) * sizeof *place);
  ylm_status s = ylm_surface_map_draw(m, r, n, seed, place, &drawn);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  bool ok = ylmL_scene_push_surfaces(L, ylm_surface_map_scene(m), drawn, place);
  ylmL_array *E = ok ? ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){drawn, 3}) : NULL;
  if (!E) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_surface_map_irradiance(m, drawn, place, E->data, NULL);
  return 3;
}

/* map_irradiance(lightmap, points [n][3], normals float [n][3]) -> irradiance float [n][3], the numbers from 1 of their charts
   float [n], 0: none */
static int map_irradiance(lua_State *L) {
  const ylm_surface_map *m = check_map(L, 1);
  size_t n;
  const ylm_scene_place *place = ylmL_scene_read_surfaces(L, 2, ylm_surface_map_scene(m), &n);
  if (!place) return 3;
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  ylmL_array *charts = out ? ylmL_array_new(L, YLM_FLOAT, 1, &n) : NULL;
  if (!charts) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_surface_map_irradiance(m, n, place, out->data, charts->data);
  ylmL_from_one(charts);
  return 2;
}

/* map_picture(lightmap, irradiance float [h][w][3], charts float [h][w] or nil): from 1, 0 beyond all */
static int map_picture(lua_State *L) {
  const ylm_surface_map *m = check_map(L, 1);
  ylmL_array *out = ylmL_array_check(L, 2), *charts = ylmL_array_opt(L, 3);
  ylm_surface_map_stats s;
  ylm_surface_map_look(m, &s);
  size_t n = s.charts.width * s.charts.height;
  if (out->dtype != YLM_FLOAT || (charts && charts->dtype != YLM_FLOAT))
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (out->count != 3 * n || (charts && charts->count != n))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  memcpy(out->data, ylm_surface_map_picture(m), 3 * n * sizeof(float));
  ylm_status status = charts ? ylm_unwrap_texels(ylm_surface_map_charts(m), charts->data) : YLM_OK;
  if (charts && status == YLM_OK) ylmL_from_one(charts);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, status, NULL);
}

/* map_flow(lightmap, axis from 1, float [h][w][3]) */
static int map_flow(lua_State *L) {
  const ylm_surface_map *m = check_map(L, 1);
  size_t axis = (size_t)luaL_checknumber(L, 2) - 1;
  ylmL_array *out = ylmL_array_check(L, 3);
  ylm_surface_map_stats s;
  ylm_surface_map_look(m, &s);
  size_t n = 3 * s.charts.width * s.charts.height;
  if (!ylm_surface_map_flow(m) || axis > 2) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  if (out->dtype != YLM_FLOAT) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (out->count != n) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  memcpy(out->data, ylm_surface_map_flow(m) + axis * n, n * sizeof(float));
  return 0;
}

/* map_charts(lightmap) -> errors float [charts], texels a scene unit float [charts] */
static int map_charts(lua_State *L) {
  const ylm_surface_map *m = check_map(L, 1);
  ylm_surface_map_stats s;
  ylm_surface_map_look(m, &s);
  ylmL_array *errors = ylmL_array_new(L, YLM_FLOAT, 1, &s.charts.charts);
  ylmL_array *density = errors ? ylmL_array_new(L, YLM_FLOAT, 1, &s.charts.charts) : NULL;
  if (!density) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < s.charts.charts; i++) {
    ((float *)errors->data)[i] = (float)ylm_surface_map_errors(m)[i];
    ((float *)density->data)[i] = (float)ylm_unwrap_density(ylm_surface_map_charts(m), i);
  }
  return 2;
}

/* map_rgbm(lightmap, float [h][w][4]) -> the range: irradiance is range (a rgb)^2 */
static int map_rgbm(lua_State *L) {
  const ylm_surface_map *m = check_map(L, 1);
  ylmL_array *out = ylmL_array_check(L, 2);
  ylm_surface_map_stats s;
  ylm_surface_map_look(m, &s);
  if (out->dtype != YLM_FLOAT) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (out->count != 4 * s.charts.width * s.charts.height)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  lua_pushnumber(L, (lua_Number)ylm_surface_map_rgbm(m, out->data));
  return 1;
}

/* map_sheet(lightmap, sheet from 1) -> number of the mesh from 1, whether it is its back */
static int map_sheet(lua_State *L) {
  bool back;
  size_t sheet = (size_t)luaL_checknumber(L, 2) - 1;
  ylmL_push_count(L, ylm_surface_map_sheet(check_map(L, 1), sheet, &back) + 1);
  lua_pushboolean(L, back);
  return 2;
}

/* map_split(lightmap, sheet from 1, its mesh) -> mesh, whose triangles face the light, uvs float [n][2] */
static int map_split(lua_State *L) {
  const ylm_surface_map *map = check_map(L, 1);
  size_t sheet = (size_t)luaL_checknumber(L, 2) - 1;
  const ylm_mesh *mesh = ylmL_mesh_check(L, 3);
  float *uv = NULL;
  ylm_error e = {0};
  ylm_mesh **out = ylmL_mesh_new(L);
  ylm_status s = ylm_surface_map_split(map, sheet, mesh, out, &uv, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  size_t n = (*out)->vertices;
  ylmL_array *uvs = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 2});
  if (uvs) memcpy(uvs->data, uv, 2 * n * sizeof *uv);
  ylm_free(uv);
  return ylmL_result(L, 2, uvs ? YLM_OK : YLM_ENOMEM, &e);
}

static const luaL_Reg functions[] = {{"map_bake", map_bake},
                                     {"map_stats", map_stats},
                                     {"map_verdict", map_verdict},
                                     {"map_judges", map_judges},
                                     {"map_sheet", map_sheet},
                                     {"map_split", map_split},
                                     {"map_picture", map_picture},
                                     {"map_irradiance", map_irradiance},
                                     {"map_flow", map_flow},
                                     {"map_rgbm", map_rgbm},
                                     {"map_charts", map_charts},
                                     {"map_close", ylmL_let_go},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};

void ylmL_open_surface_map(lua_State *L) {
  ylmL_type(L, YLML_MAP, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
