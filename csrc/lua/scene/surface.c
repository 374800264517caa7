/* surface.c - light on surfaces as a Lua object. */
#include "ylm_surface.h"

#include "shade.h"
#include "transfer.h"
#include "ylm_shade_bounce.h"

#define YLML_SURFACE "ylm.surface_grid"

static void destroy(void *g) { ylm_surface_free(g); }

static ylm_surface_grid *check_surface(lua_State *L, int i) {
  return ylmL_held_check(L, i, YLML_SURFACE)->object;
}

static void charge(lua_State *L, const ylm_surface_grid *g) {
  ylm_surface_stats s;
  ylm_surface_look(g, &s);
  ylmL_charge(L, s.bytes);
}

static void read_like(lua_State *L, int i, void *to) {
  *(const ylm_surface_grid **)to = check_surface(L, i);
}

typedef struct bake_form {
  ylm_surface_form f;
  int progress; /* on the stack */
} bake_form;

static const ylmL_entry bake_entries[] = {
    YLML(bake_form, f.tolerance, "tolerance", DOUBLE),
    YLML(bake_form, f.aim, "aim", DOUBLE),
    YLML(bake_form, f.quantity, "quantity", CHOICE, .choices = ylmL_quantity_choices),
    YLML(bake_form, f.lit, "lit", READ, .read = ylmL_read_scene),
    YLML(bake_form, f.corners, "corners", COUNT, .optional = true),
    YLML(bake_form, f.like, "like", READ, .read = read_like, .optional = true),
    YLML(bake_form, f.light.indirect, "indirect", BOOL),
    YLML(bake_form, f.light.scene, "scene", READ, .read = ylmL_read_scene, .optional = true),
    YLML(bake_form, f.light.links, "links", INT),
    YLML(bake_form, f.light.light_samples, "light_samples", INT),
    YLML(bake_form, f.light.seed, "seed", UINT64),
    YLML(bake_form, f.light.threads, "threads", INT, .optional = true),
    YLML(bake_form, progress, "progress", VALUE),
    {.name = NULL}};

/* surface_bake(radiosity, {tolerance, aim, quantity, lit: the scene whose lamps and materials it is of, corners, like: a surface grid, indirect,
   scene whose lamps light directly or nil, links, light_samples, seed, threads, progress}) -> surface grid, which the radiosity's scene must outlive */
static int surface_bake(lua_State *L) {
  bake_form f = {.progress = 0};
  ylm_radiosity *r = ylmL_radiosity(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylm_surface_grid *g;
  ylmL_read(L, 2, bake_entries, &f);
  f.f.light.progress = ylmL_progress_begin(L, f.progress, &p);
  ylmL_held *h = ylmL_hold(L, YLML_SURFACE, destroy, NULL);
  ylm_status s = YLM_OK;
  if (f.f.light.indirect) s = ylm_radiosity_aim(r, f.f.light.threads, f.f.light.progress);
  if (s == YLM_OK) s = ylm_surface_bake(r, &f.f, &g, &e);
  h->object = g;
  if (s == YLM_OK) charge(L, g);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

static void set_print(lua_State *L, const char *name, uint64_t print) {
  ylmL_scene_push_print(L, print);
  lua_setfield(L, -2, name);
}

/* surface_verdict(surface grid, verified, failed, error, rms) */
static int surface_verdict(lua_State *L) {
  ylm_surface_verdict(check_surface(L, 1), (size_t)luaL_checknumber(L, 2),
                      (size_t)luaL_checknumber(L, 3), (double)luaL_checknumber(L, 4),
                      (double)luaL_checknumber(L, 5));
  return 0;
}

/* Pushes a table of stats, one of fingerprints, the tolerance and the quantity. */
static int push_stats(lua_State *L, const ylm_surface_stats *s) {
  lua_newtable(L);
  ylmL_set_count(L, "charts", s->charts);
  ylmL_set_count(L, "rectangles", s->rectangles);
  ylmL_set_count(L, "corners", s->corners);
  ylmL_set_count(L, "rows", s->rows);
  ylmL_set_count(L, "places", s->places);
  ylmL_set_count(L, "rounds", s->rounds);
  ylmL_set_count(L, "rays", s->rays);
  ylmL_set_count(L, "verified", s->verified);
  ylmL_set_count(L, "failed", s->failed);
  ylmL_set_number(L, "error", s->error);
  ylmL_set_number(L, "rms", s->rms);
  ylmL_set_boolean(L, "met", s->met);
  ylmL_set_boolean(L, "spent", s->spent);
  ylmL_set_count(L, "bytes", s->bytes);
  ylmL_set_number(L, "seconds", s->seconds);
  lua_newtable(L);
  set_print(L, "geometry", s->prints.geometry);
  set_print(L, "materials", s->prints.materials);
  set_print(L, "lights", s->prints.lights);
  lua_pushnumber(L, (lua_Number)s->tolerance);
  lua_pushstring(L, ylm_quantity_name(s->quantity));
  return 4;
}

/* surface_stats(surface grid) -> table, { geometry, materials, lights: fingerprints }, tolerance, quantity */
static int surface_stats(lua_State *L) {
  ylm_surface_stats s;
  ylm_surface_look(check_surface(L, 1), &s);
  return push_stats(L, &s);
}

/* surface_inspect(path) -> as surface_stats, but bytes are those of the file */
static int surface_inspect(lua_State *L) {
  const char *path = luaL_checkstring(L, 1);
  ylm_error e = {0};
  ylm_surface_stats stats;
  unsigned char *bytes;
  size_t size;
  ylm_status s = ylm_file_read(path, (size_t)1 << 40, &bytes, &size, &e);
  if (s == YLM_OK) {
    s = ylm_surface_inspect(bytes, size, path, &stats, &e);
    ylm_free(bytes);
  }
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  stats.bytes = size;
  return push_stats(L, &stats);
}

/* surface_take(surface grid, other): the grid becomes what the other is, which becomes what that was. */
static int surface_take(lua_State *L) {
  ylmL_held *to = ylmL_held_check(L, 1, YLML_SURFACE), *from = ylmL_held_check(L, 2, YLML_SURFACE);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  void *object = to->object;
  to->object = from->object;
  from->object = object;
  lua_pushboolean(L, 1);
  return 1;
}

ylm_scene_place *ylmL_scene_read_surfaces(lua_State *L, int i, const ylm_scene *scene, size_t *n) {
  const ylmL_array *normals = ylmL_array_check(L, i + 1);
  ylm_error e = {0};
  const float(*point)[3] = ylmL_scene_places(L, i, ylm_scene_origin(scene), n);
  ylm_status s = !point                        ? YLM_ENOMEM
                 : normals->dtype != YLM_FLOAT ? YLM_ETYPE
                 : normals->count != 3 * *n    ? YLM_ESHAPE
                                               : YLM_OK;
  const float(*normal)[3] = normals->data;
  ylm_scene_place *place = s == YLM_OK ? lua_newuserdata(L, (*n + 1) * sizeof *place) : NULL;
  for (size_t k = 0; s == YLM_OK && k < *n; k++)
    if (!ylm_surface_place(scene, point[k], normal[k], &place[k]))
      s = ylm_fail(&e, YLM_EINVAL, "point %zu lies on no surface of the scene", k + 1);
  if (s == YLM_OK) return place;
  ylmL_result(L, 0, s, &e);
  return NULL;
}

void ylmL_from_one(ylmL_array *a) {
  uint32_t *number = a->data;
  for (size_t i = 0; i < a->count; i++) {
    float x = number[i] == UINT32_MAX ? 0 : (float)number[i] + 1;
    memcpy(&number[i], &x, sizeof x);
  }
}

/* surface_irradiance(surface grid, points [n][3], normals float [n][3], threads) -> irradiance float [n][3], the numbers
   from 1 of their rectangles float [n], 0: none */
static int surface_irradiance(lua_State *L) {
  const ylm_surface_grid *g = check_surface(L, 1);
  int threads = (int)luaL_optnumber(L, 4, 0);
  size_t n;
  const ylm_scene_place *place = ylmL_scene_read_surfaces(L, 2, ylm_surface_scene(g), &n);
  if (!place) return 3;
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  ylmL_array *numbers = out ? ylmL_array_new(L, YLM_FLOAT, 1, &n) : NULL;
  if (!numbers) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_surface_irradiance(g, n, place, out->data, numbers->data, threads);
  ylmL_from_one(numbers);
  return 2;
}

bool ylmL_scene_push_surfaces(lua_State *L, const ylm_scene *scene, size_t n,
                              const ylm_scene_place *place) {
  ylm_scene_surface *at = lua_newuserdata(L, (n + 1) * sizeof *at);
  float(*x)[3] = lua_newuserdata(L, (n + 1) * sizeof *x);
  ylm_scene_surfaces(scene, n, place, at);
  for (size_t i = 0; i < n; i++) memcpy(x[i], at[i].position, sizeof x[i]);
  if (!ylmL_scene_push_places(L, ylm_scene_origin(scene), n, x[0])) return false;
  ylmL_array *normals = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  for (size_t i = 0; normals && i < n; i++)
    memcpy((float *)normals->data + 3 * i, at[i].normal, 12);
  return normals != NULL;
}

/* surface_judges(surface grid, radiosity, n, seed, threads) -> points [n][3], normals float [n][3], irradiance float [n][3] */
static int surface_judges(lua_State *L) {
  const ylm_surface_grid *g = check_surface(L, 1);
  const ylm_radiosity *r = ylmL_radiosity(L, 2);
  size_t n = (size_t)luaL_checknumber(L, 3), drawn = 0;
  uint64_t seed = (uint64_t)luaL_checknumber(L, 4);
  int threads = (int)luaL_optnumber(L, 5, 0);
  ylm_scene_place *place = lua_newuserdata(L, (n + 1) * sizeof *place);
  ylm_status s = ylm_surface_draw(g, r, n, seed, place, &drawn);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  bool ok = ylmL_scene_push_surfaces(L, ylm_surface_scene(g), drawn, place);
  ylmL_array *E = ok ? ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){drawn, 3}) : NULL;
  if (!E) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_surface_irradiance(g, drawn, place, E->data, NULL, threads);
  return 3;
}

/* surface_rectangles(surface grid) -> corners float [n][4][3] relative to the scene's origin, irradiance float [n][4][3] */
static int surface_rectangles(lua_State *L) {
  const ylm_surface_grid *g = check_surface(L, 1);
  ylm_surface_stats s;
  ylm_surface_look(g, &s);
  ylmL_array *a[2];
  for (int i = 0; i < 2; i++) {
    a[i] = ylmL_array_new(L, YLM_FLOAT, 3, (size_t[]){s.rectangles, 4, 3});
    if (!a[i]) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  }
  float(*corner)[4][3] = a[0]->data, (*value)[4][3] = a[1]->data;
  for (size_t i = 0; i < s.rectangles; i++) ylm_surface_rectangle(g, i, corner[i], value[i]);
  return 2;
}

/* surface_write(surface grid, path) -> true */
static int surface_write(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = ylm_surface_write(check_surface(L, 1), luaL_checkstring(L, 2), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* surface_read(scene, path) -> surface grid, which the scene must outlive */
static int surface_read(lua_State *L) {
  const ylm_scene *scene = ylmL_scene(L, 1);
  const char *path = luaL_checkstring(L, 2);
  ylm_error e = {0};
  unsigned char *bytes;
  size_t size;
  ylmL_held *h = ylmL_hold(L, YLML_SURFACE, destroy, NULL);
  ylm_surface_grid *g = NULL;
  ylm_status s = ylm_file_read(path, (size_t)1 << 40, &bytes, &size, &e);
  if (s == YLM_OK) {
    s = ylm_surface_read(scene, bytes, size, path, &g, &e);
    ylm_free(bytes);
  }
  h->object = g;
  if (s == YLM_OK) charge(L, g);
  return ylmL_result(L, 1, s, &e);
}

/* shade_surfaces(view, surface grid, threads) -> irradiance float [n][3] at its points, the numbers from 1 of their
   rectangles float [n], 0: none */
static int shade_surfaces(lua_State *L) {
  const ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_surface_grid *g = check_surface(L, 2);
  size_t n = ylmL_shade_points(v);
  ylm_error e = {0};
  ylmL_array *E = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  ylmL_array *numbers = E ? ylmL_array_new(L, YLM_FLOAT, 1, &n) : NULL;
  if (!numbers) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_shade_surfaces(v, g, (int)luaL_optnumber(L, 3, 0), E->data, numbers->data, &e);
  if (s == YLM_OK) ylmL_from_one(numbers);
  return ylmL_result(L, 2, s, &e);
}

static const luaL_Reg functions[] = {{"surface_bake", surface_bake},
                                     {"surface_stats", surface_stats},
                                     {"surface_inspect", surface_inspect},
                                     {"surface_take", surface_take},
                                     {"surface_verdict", surface_verdict},
                                     {"surface_irradiance", surface_irradiance},
                                     {"surface_judges", surface_judges},
                                     {"surface_rectangles", surface_rectangles},
                                     {"surface_write", surface_write},
                                     {"surface_read", surface_read},
                                     {"surface_close", ylmL_let_go},
                                     {"shade_surfaces", shade_surfaces},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};

void ylmL_open_surface(lua_State *L) {
  ylmL_type(L, YLML_SURFACE, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
