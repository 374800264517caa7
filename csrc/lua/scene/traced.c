/* traced.c - scenes ready to be traced: made of meshes and lamps, looked at, traced. */
#include <string.h>

#include "traced.h"
#include "ylm_geom.h"

#define SCENE "ylm.traced"
#define IMAGE_TILES 8 /* a side, for rays that are aimed at images */

static int scene_close(lua_State *L) {
  ylm_scene **s = ylmL_check(L, 1, SCENE);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_scene_free(*s);
  *s = NULL;
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

/* One mesh from lists of meshes, materials and flags at 1, 2, 3. */
static ylm_scene_mesh read_mesh(lua_State *L, int i) {
  lua_rawgeti(L, 1, i);
  const ylm_mesh *m = ylmL_mesh_check(L, lua_gettop(L));
  lua_rawgeti(L, 2, i);
  const ylm_material *material = ylmL_material_check(L, lua_gettop(L));
  lua_rawgeti(L, 3, i);
  bool occludes = lua_toboolean(L, -1);
  lua_pop(L, 3);
  return (ylm_scene_mesh){m->position, m->normal,    m->uv,    m->vertices,
                          m->index,    m->triangles, material, occludes};
}

static void copy(float *to, const double *from, size_t n) {
  for (size_t k = 0; k < n; k++) to[k] = (float)from[k];
}

/* Radiances and horizons of n patches from rows [n][6]. */
static void split(const double *row, size_t n, float *radiance, float *horizon) {
  for (size_t k = 0; k < n; k++) {
    copy(radiance + 3 * k, row + 6 * k, 3);
    copy(horizon + 3 * k, row + 6 * k + 3, 3);
  }
}

bool ylmL_scene_lamps(lua_State *L, int i, ylm_scene_lamps *lamps) {
  const ylm_light_surfaces *s = ylmL_light_surfaces(L, i, IMAGE_TILES);
  if (!s) return false;
  size_t n = s->spheres, nt = s->triangles, nd = s->disks, flat = 9 * nt + 7 * nd;
  ylmL_array *all = ylmL_array_new(L, YLM_FLOAT, 1, (size_t[]){7 * n + flat + 6 * (nt + nd)});
  if (!all) return false;
  float *sphere = all->data, *radiance = sphere + 4 * n, *shape = radiance + 3 * (n + nt + nd);
  float *horizon = shape + flat;
  for (size_t k = 0; k < n; k++) {
    copy(sphere + 4 * k, s->sphere + 7 * k, 4);
    copy(radiance + 3 * k, s->sphere + 7 * k + 4, 3);
  }
  copy(shape, s->triangle, 9 * nt);
  copy(shape + 9 * nt, s->disk, 7 * nd);
  split(s->triangle_emission, nt, radiance + 3 * n, horizon);
  split(s->disk_emission, nd, radiance + 3 * (n + nt), horizon + 3 * nt);
  *lamps = (ylm_scene_lamps){.shape = {n, nt, nd, sphere, shape, shape + 9 * nt},
                             .radiance = radiance,
                             .horizon = horizon,
                             .images = s->images,
                             .image = s->image,
                             .sky = ylmL_lights_check(L, i)};
  return true;
}

/* scene_create(meshes, materials, occludes, lights, whether distant lights are seen) -> scene */
static int scene_create(lua_State *L) {
  ylm_error e = {0};
  ylm_scene_lamps lamps;
  for (int i = 1; i <= 3; i++) luaL_checktype(L, i, LUA_TTABLE);
  lua_settop(L, 5);
  size_t n = lua_rawlen(L, 1);
  if (!ylmL_scene_lamps(L, 4, &lamps)) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  lamps.sky_is_seen = lua_toboolean(L, 5);
  ylm_scene_mesh *mesh = lua_newuserdata(L, (n + 1) * sizeof *mesh);
  for (size_t i = 0; i < n; i++) mesh[i] = read_mesh(L, (int)i + 1);
  ylm_scene **s = lua_newuserdata(L, sizeof *s);
  *s = NULL;
  luaL_getmetatable(L, SCENE);
  lua_setmetatable(L, -2);
  return ylmL_result(L, 1, ylm_scene_create(n, mesh, &lamps, s, &e), &e);
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
  ylm_scene_bounds(ylmL_scene(L, 1), lo, hi);
  push_three(L, lo);
  push_three(L, hi);
  return 2;
}

/* scene_vertices(scene) -> [n][3] */
static int scene_vertices(lua_State *L) {
  ylm_scene *s = ylmL_scene(L, 1);
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylm_scene_vertices(s, NULL), 3});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_scene_vertices(s, a->data);
  return 1;
}

/*
** scene_trace(scene, rays [n][8]: origin, direction, near, far; float, occlusion) ->
**   occlusion: blocked [n], 1 or 0
**   else:      hits [n][8]: mesh (from 1; 0 nothing, -1 a lamp), element from 1, t, u, v, normal
*/
static int scene_trace(lua_State *L) {
  const ylm_trace *t = ylm_scene_trace(ylmL_scene(L, 1));
  ylmL_array *in = ylmL_array_check(L, 2);
  bool occlusion = lua_toboolean(L, 3);
  size_t n = in->count / 8, shape[2] = {n, 8};
  if (in->dtype != YLM_FLOAT || in->count % 8) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, occlusion ? 1 : 2, shape);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  float *x = out->data;
  const float *f = in->data;
  for (size_t i = 0; i < n; i++, f += 8) {
    ylm_trace_ray r = {{f[0], f[1], f[2]}, f[6], {f[3], f[4], f[5]}, 0, f[7], {0}};
    ylm_trace_hit h;
    if (occlusion) {
      ylm_trace_occluded(t, 1, &r);
      x[i] = r.far < 0;
      continue;
    }
    ylm_trace_intersect(t, 1, &r, false, &h);
    bool none = h.mesh == YLM_TRACE_NOTHING;
    float hit[8] = {none                       ? 0
                    : h.mesh == YLM_TRACE_LAMP ? -1
                                               : (float)h.mesh + 1,
                    none ? 0 : (float)h.element + 1,
                    h.t,
                    h.u,
                    h.v,
                    h.normal[0],
                    h.normal[1],
                    h.normal[2]};
    memcpy(x + 8 * i, hit, sizeof hit);
  }
  return 1;
}

static const luaL_Reg functions[] = {
    {"scene_create", scene_create},     {"scene_bounds", scene_bounds},
    {"scene_vertices", scene_vertices}, {"scene_trace", scene_trace},
    {"scene_close", scene_close},       {NULL, NULL}};

void ylmL_open_traced(lua_State *L) {
  ylmL_type(L, SCENE, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
