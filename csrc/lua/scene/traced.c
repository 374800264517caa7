/* traced.c - scenes ready to be traced: made of meshes and lamps, looked at, traced. */
#include <stdio.h>
#include <string.h>

#include "traced.h"
#include "ylm_geom.h"
#include "ylm_light_emitter.h"

#define SCENE "ylm.traced"
#define IMAGE_TILES 8 /* a side, for rays that are aimed at images */

static int scene_close(lua_State *L) {
  ylm_scene **s = ylmL_check(L, 1, SCENE);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_scene_free(*s);
  *s = NULL;
  ylmL_disown(L, 1);
  return 0;
}

static const luaL_Reg methods[] = {{"__gc", scene_close}, {NULL, NULL}};

ylm_scene *ylmL_scene(lua_State *L, int i) {
  ylm_scene **s = ylmL_check(L, i, SCENE);
  if (!*s) luaL_argerror(L, i, "the scene has been closed");
  return *s;
}

void ylmL_scene_numbers(lua_State *L, int i, int n, double *x) {
  luaL_checktype(L, i, LUA_TTABLE);
  for (int k = 0; k < n; k++) {
    lua_rawgeti(L, i, k + 1);
    x[k] = (double)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
}

void ylmL_read_scene(lua_State *L, int i, void *field) {
  *(const ylm_scene **)field = ylmL_scene(L, i);
}

void ylmL_read_camera(lua_State *L, int i, void *field) {
  double c[10];
  ylmL_scene_numbers(L, i, 10, c);
  *(ylm_camera *)field =
      (ylm_camera){{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}, c[9]};
}

/* One mesh from lists of meshes, materials and flags at 1, 2, 3, textures or false at 6. */
static ylm_scene_mesh read_mesh(lua_State *L, int i) {
  lua_rawgeti(L, 1, i);
  const ylm_mesh *m = ylmL_mesh_check(L, lua_gettop(L));
  lua_rawgeti(L, 2, i);
  const ylm_material *material = ylmL_material_check(L, lua_gettop(L));
  lua_rawgeti(L, 3, i);
  bool occludes = lua_toboolean(L, -1);
  lua_rawgeti(L, 6, i);
  const ylm_texture *texture = lua_toboolean(L, -1) ? ylmL_texture_check(L, lua_gettop(L)) : NULL;
  lua_pop(L, 4);
  return (ylm_scene_mesh){m->position, m->normal, m->uv,     m->vertices, m->index, m->triangles,
                          material,    occludes,  m->colour, texture,     m->origin};
}

static void copy(float *to, const double *from, size_t n) {
  for (size_t k = 0; k < n; k++) to[k] = (float)from[k];
}

/* n places, relative to an origin. */
static void enter(float *to, const double *from, size_t n, const double *origin) {
  for (size_t k = 0; k < 3 * n; k++) to[k] = (float)(from[k] - (origin ? origin[k % 3] : 0));
}

/* Radiances and horizons of n patches from rows [n][6]. */
static void split(const double *row, size_t n, float *radiance, float *horizon) {
  for (size_t k = 0; k < n; k++) {
    copy(radiance + 3 * k, row + 6 * k, 3);
    copy(horizon + 3 * k, row + 6 * k + 3, 3);
  }
}

bool ylmL_scene_lamps(lua_State *L, int i, const double *origin, ylm_scene_lamps *lamps) {
  const ylm_light_surfaces *s = ylmL_light_surfaces(L, i, IMAGE_TILES);
  if (!s) return false;
  size_t n = s->spheres, nt = s->triangles, nd = s->disks, flat = 9 * nt + 7 * nd;
  ylmL_array *all = ylmL_array_new(L, YLM_FLOAT, 1, (size_t[]){7 * n + flat + 6 * (nt + nd)});
  if (!all) return false;
  float *sphere = all->data, *radiance = sphere + 4 * n, *shape = radiance + 3 * (n + nt + nd);
  float *horizon = shape + flat;
  for (size_t k = 0; k < n; k++) {
    enter(sphere + 4 * k, s->sphere[k].at, 1, origin);
    sphere[4 * k + 3] = (float)s->sphere[k].radius;
    copy(radiance + 3 * k, s->sphere[k].radiance, 3);
  }
  enter(shape, s->triangle, 3 * nt, origin);
  for (size_t k = 0; k < nd; k++) {
    enter(shape + 9 * nt + 7 * k, s->disk + 7 * k, 1, origin);
    copy(shape + 9 * nt + 7 * k + 3, s->disk + 7 * k + 3, 4);
  }
  split(s->triangle_emission, nt, radiance + 3 * n, horizon);
  split(s->disk_emission, nd, radiance + 3 * (n + nt), horizon + 3 * nt);
  *lamps = (ylm_scene_lamps){.shape = {n, nt, nd, sphere, shape, shape + 9 * nt},
                             .radiance = radiance,
                             .horizon = horizon,
                             .images = s->images,
                             .image = s->image,
                             .directions = s->directions,
                             .directed = s->directed,
                             .sky = ylmL_lights_check(L, i)};
  return true;
}

/* Pushes a scene that is still to be made. */
static ylm_scene **new_scene(lua_State *L) {
  ylm_scene **s = lua_newuserdata(L, sizeof *s);
  *s = NULL;
  luaL_getmetatable(L, SCENE);
  lua_setmetatable(L, -2);
  return s;
}

/* scene_create(meshes, materials, occludes, lights, whether distant lights are seen, textures: of each
   mesh one or false) -> scene */
static int scene_create(lua_State *L) {
  ylm_error e = {0};
  ylm_scene_lamps lamps;
  for (int i = 1; i <= 3; i++) luaL_checktype(L, i, LUA_TTABLE);
  lua_settop(L, 6);
  luaL_checktype(L, 6, LUA_TTABLE);
  size_t n = lua_rawlen(L, 1);
  double origin[3];
  ylm_scene_mesh *mesh = lua_newuserdata(L, (n + 1) * sizeof *mesh);
  for (size_t i = 0; i < n; i++) mesh[i] = read_mesh(L, (int)i + 1);
  ylm_scene_origin_of(n, mesh, origin);
  if (!ylmL_scene_lamps(L, 4, origin, &lamps)) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  lamps.sky_is_seen = lua_toboolean(L, 5);
  ylm_scene **s = new_scene(L);
  return ylmL_result(L, 1, ylm_scene_create(n, mesh, &lamps, s, &e), &e);
}

/* scene_relight(scene, lights, whether distant lights are seen, how many lamps are weighed one by one or
   nil) -> another one with the same meshes */
static int scene_relight(lua_State *L) {
  ylm_error e = {0};
  ylm_scene_lamps lamps;
  const ylm_scene *from = ylmL_scene(L, 1);
  lua_settop(L, 4);
  lua_Integer one_by_one = luaL_optinteger(L, 4, 0);
  if (!ylmL_scene_lamps(L, 2, ylm_scene_origin(from), &lamps))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  lamps.sky_is_seen = lua_toboolean(L, 3);
  lamps.one_by_one = one_by_one > 0 ? (size_t)one_by_one : 0;
  ylm_scene **s = new_scene(L);
  return ylmL_result(L, 1, ylm_scene_relight(from, &lamps, s, &e), &e);
}

/* scene_points(scene) -> the number of its lamps without a size */
static int scene_points(lua_State *L) {
  ylmL_push_count(L, ylm_scene_points(ylmL_scene(L, 1), NULL));
  return 1;
}

static void push_three(lua_State *L, const double x[3]) {
  lua_createtable(L, 3, 0);
  for (int a = 0; a < 3; a++) {
    lua_pushnumber(L, (lua_Number)x[a]);
    lua_rawseti(L, -2, a + 1);
  }
}

/* scene_bounds(scene) -> min, max */
static int scene_bounds(lua_State *L) {
  double lo[3], hi[3];
  const ylm_scene *s = ylmL_scene(L, 1);
  const double *origin = ylm_scene_origin(s);
  ylm_scene_bounds(s, lo, hi);
  for (int a = 0; origin && a < 3; a++) lo[a] += origin[a], hi[a] += origin[a];
  push_three(L, lo);
  push_three(L, hi);
  return 2;
}

/* scene_core(scene, x, y, z) -> min, max: without grounds, where the place is in what is left */
static int scene_core(lua_State *L) {
  double lo[3], hi[3];
  const ylm_scene *s = ylmL_scene(L, 1);
  const double *origin = ylm_scene_origin(s);
  const double world[3] = {luaL_checknumber(L, 2), luaL_checknumber(L, 3), luaL_checknumber(L, 4)};
  float place[1][3];
  ylm_scene_enter(s, world, place[0]);
  ylm_status status = ylm_scene_core(s, 1, (const float(*)[3])place, lo, hi, NULL);
  for (int a = 0; origin && a < 3; a++) lo[a] += origin[a], hi[a] += origin[a];
  push_three(L, lo);
  push_three(L, hi);
  return ylmL_result(L, 2, status, NULL);
}

void ylmL_scene_push_print(lua_State *L, uint64_t print) {
  char text[17];
  snprintf(text, sizeof text, "%016llx", (unsigned long long)print);
  lua_pushstring(L, text);
}

/* scene_print(scene) -> fingerprints of geometry, materials, lights: 16 digits each */
static int scene_print(lua_State *L) {
  ylm_scene_prints p;
  ylm_scene_print(ylmL_scene(L, 1), &p);
  ylmL_scene_push_print(L, p.geometry);
  ylmL_scene_push_print(L, p.materials);
  ylmL_scene_push_print(L, p.lights);
  return 3;
}

/* scene_print_lights(scene) -> 16 digits, the same whether or not the sky is seen */
static int scene_print_lights(lua_State *L) {
  ylmL_scene_push_print(L, ylm_scene_print_lights(ylmL_scene(L, 1)));
  return 1;
}

bool ylmL_scene_push_places(lua_State *L, const double *origin, size_t n, const float *x) {
  size_t shape[] = {n, 3};
  ylmL_array *a = ylmL_array_new(L, origin ? YLM_DOUBLE : YLM_FLOAT, 2, shape);
  if (!a) return false;
  if (!origin)
    ylm_copy(a->data, x, 3 * n * sizeof *x);
  else
    for (size_t k = 0; k < 3 * n; k++) ((double *)a->data)[k] = (double)x[k] + origin[k % 3];
  return true;
}

const float (*ylmL_scene_places(lua_State *L, int i, const double *origin, size_t *n))[3] {
  const ylmL_array *a = ylmL_array_check(L, i);
  if (a->count % 3) luaL_argerror(L, i, "an array [n][3] expected");
  *n = a->count / 3;
  if (a->dtype == YLM_FLOAT && !origin) return (const float(*)[3])a->data;
  float *x = lua_newuserdata(L, (a->count + 1) * sizeof *x);
  for (size_t k = 0; k < a->count; k++)
    x[k] = (float)(ylm_get(a->dtype, a->data, k) - (origin ? origin[k % 3] : 0));
  return (const float(*)[3])x;
}

/* scene_vertices(scene) -> [n][3]; double where the scene is far from 0 */
static int scene_vertices(lua_State *L) {
  const ylm_scene *s = ylmL_scene(L, 1);
  size_t n = ylm_scene_vertices(s, NULL);
  float *x = lua_newuserdata(L, (3 * n + 1) * sizeof *x);
  ylm_scene_vertices(s, x);
  if (!ylmL_scene_push_places(L, ylm_scene_origin(s), n, x))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return 1;
}

/* Rays [n][8] at 2: origin, direction, near, far; NULL if they are not. */
static const ylmL_array *check_rays(lua_State *L, size_t *n) {
  const ylmL_array *in = ylmL_array_check(L, 2);
  *n = in->count / 8;
  return in->count % 8 == 0 ? in : NULL;
}

static ylm_trace_ray read_ray(const ylm_scene *s, const ylmL_array *a, size_t i) {
  double x[8];
  ylm_trace_ray r = {.near = 0};
  for (size_t k = 0; k < 8; k++) x[k] = ylm_get(a->dtype, a->data, 8 * i + k);
  ylm_scene_enter(s, x, r.org);
  for (int k = 0; k < 3; k++) r.dir[k] = (float)x[3 + k];
  r.near = (float)x[6];
  r.far = (float)x[7];
  return r;
}

static void write_hit(const ylm_trace_hit *h, float x[8]) {
  bool none = h->mesh == YLM_TRACE_NOTHING, lamp = h->mesh == YLM_TRACE_LAMP;
  x[0] = none ? 0 : lamp ? -1 : (float)h->mesh + 1;
  x[1] = none ? 0 : (float)h->element + 1;
  x[2] = h->t;
  x[3] = h->u;
  x[4] = h->v;
  memcpy(x + 5, h->normal, sizeof h->normal);
}

enum { FIRST, OCCLUSION, NEAREST };

/*
** scene_trace(scene, rays [n][8]: origin, direction, near, far; kind) ->
**   "occlusion": blocked [n], 1 or 0
**   else:        hits [n][8]: mesh (from 1; 0 nothing, -1 a lamp), element from 1, t, u, v, normal;
**                "first": of meshes and lamps, "nearest": of meshes that occlude
*/
static int scene_trace(lua_State *L) {
  static const char *const kinds[] = {"first", "occlusion", "nearest", NULL};
  const ylm_scene *s = ylmL_scene(L, 1);
  const ylm_trace *t = ylm_scene_trace(s);
  int kind = luaL_checkoption(L, 3, "first", kinds);
  size_t n, width = kind == OCCLUSION ? 1 : 8;
  const ylmL_array *in = check_rays(L, &n);
  if (!in) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, kind == OCCLUSION ? 1 : 2, (size_t[]){n, 8});
  ylm_trace_ray *rays = ylm_alloc(n, sizeof *rays);
  ylm_trace_hit *hits = kind == OCCLUSION ? NULL : ylm_alloc(n, sizeof *hits);
  bool room = out && rays && (hits || kind == OCCLUSION);
  for (size_t i = 0; room && i < n; i++) rays[i] = read_ray(s, in, i);
  if (room && kind == OCCLUSION) ylm_trace_occluded(t, n, rays);
  if (room && kind == FIRST) ylm_trace_intersect(t, n, rays, false, hits);
  if (room && kind == NEAREST) ylm_trace_nearest(t, n, rays, false, hits);
  for (size_t i = 0; room && i < n; i++) {
    float *x = (float *)out->data + width * i;
    if (kind == OCCLUSION)
      x[0] = rays[i].far < 0;
    else
      write_hit(&hits[i], x);
  }
  ylm_free(rays);
  ylm_free(hits);
  return room ? 1 : ylmL_result(L, 0, YLM_ENOMEM, NULL);
}

/* scene_lamps(scene, rays [1][8], n, last distance, last lamp; both nil: from the start) ->
   distances, lamps from 1: of the next n that the first ray meets */
static int scene_lamps(lua_State *L) {
  const ylm_scene *s = ylmL_scene(L, 1);
  const ylm_trace *t = ylm_scene_trace(s);
  lua_Integer n = luaL_checkinteger(L, 3);
  ylm_trace_meeting after = {0}, *met;
  size_t rays, count;
  const ylmL_array *in = check_rays(L, &rays);
  if (!in || rays < 1) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  luaL_argcheck(L, n >= 0 && n <= 1 << 20, 3, "0 .. 2^20");
  bool from_start = lua_isnoneornil(L, 4);
  if (!from_start) {
    after.distance = (float)luaL_checknumber(L, 4);
    after.lamp = (uint32_t)(luaL_checkinteger(L, 5) - 1);
  }
  met = lua_newuserdata(L, (size_t)(n + 1) * sizeof *met);
  ylm_trace_ray ray = read_ray(s, in, 0);
  count = ylm_trace_next_lamps(t, &ray, from_start ? NULL : &after, (size_t)n, met);
  lua_createtable(L, (int)count, 0);
  lua_createtable(L, (int)count, 0);
  for (size_t i = 0; i < count; i++) {
    lua_pushnumber(L, (lua_Number)met[i].distance);
    lua_rawseti(L, -3, (int)i + 1);
    lua_pushinteger(L, (lua_Integer)met[i].lamp + 1);
    lua_rawseti(L, -2, (int)i + 1);
  }
  return 2;
}

static const luaL_Reg functions[] = {{"scene_create", scene_create},
                                     {"scene_relight", scene_relight},
                                     {"scene_bounds", scene_bounds},
                                     {"scene_core", scene_core},
                                     {"scene_points", scene_points},
                                     {"scene_print", scene_print},
                                     {"scene_print_lights", scene_print_lights},
                                     {"scene_vertices", scene_vertices},
                                     {"scene_trace", scene_trace},
                                     {"scene_lamps", scene_lamps},
                                     {"scene_close", scene_close},
                                     {NULL, NULL}};

void ylmL_open_traced(lua_State *L) {
  ylmL_type(L, SCENE, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
