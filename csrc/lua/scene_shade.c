/* scene_shade.c - scenes ready to be traced, views of them, shading; lua/ylm/render.lua drives it.
 */
#include <string.h>

#include "binding.h"
#include "scene_shade.h"
#include "ylm_geom.h"

#define SCENE "ylm.shade_scene"

static int scene_close(lua_State *L) {
  ylm_shade_scene **s = ylmL_check(L, 1, SCENE);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_shade_scene_free(*s);
  *s = NULL;
  return 0;
}

static int view_close(lua_State *L) {
  ylm_shade_view **v = ylmL_check(L, 1, YLML_SHADE_VIEW);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_shade_view_free(*v);
  *v = NULL;
  return 0;
}

static const luaL_Reg scene_methods[] = {{"__gc", scene_close}, {NULL, NULL}};
static const luaL_Reg view_methods[] = {{"__gc", view_close}, {NULL, NULL}};

static ylm_shade_scene *check_scene(lua_State *L, int i) {
  ylm_shade_scene **s = ylmL_check(L, i, SCENE);
  if (!*s) luaL_argerror(L, i, "the scene has been closed");
  return *s;
}

ylm_shade_view *ylmL_shade_view(lua_State *L, int i) {
  ylm_shade_view **v = ylmL_check(L, i, YLML_SHADE_VIEW);
  if (!*v) luaL_argerror(L, i, "the prepared view has been closed");
  return *v;
}

ylmL_array *ylmL_shade_result(lua_State *L, int i, int axes, const size_t *shape, ylm_status *s) {
  if (lua_isnoneornil(L, i)) {
    ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, axes, shape);
    if (!a) *s = YLM_ENOMEM;
    return a;
  }
  ylmL_array *a = ylmL_array_check(L, i);
  size_t count;
  if (a->dtype != YLM_FLOAT)
    *s = YLM_ETYPE;
  else if (!ylm_shape_count(axes, shape, &count) || count != a->count)
    *s = YLM_ESHAPE;
  lua_pushvalue(L, i);
  return *s == YLM_OK ? a : NULL;
}

/* The n numbers of the table at `i`. */
static void numbers(lua_State *L, int i, int n, double *x) {
  luaL_checktype(L, i, LUA_TTABLE);
  for (int k = 0; k < n; k++) {
    lua_rawgeti(L, i, k + 1);
    x[k] = (double)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
}

/* One mesh from lists of meshes, albedos and flags at 1, 2, 3. */
static ylm_shade_mesh read_mesh(lua_State *L, int i) {
  double albedo[3];
  lua_rawgeti(L, 1, i);
  const ylm_mesh *m = ylmL_mesh_check(L, lua_gettop(L));
  lua_rawgeti(L, 2, i);
  numbers(L, lua_gettop(L), 3, albedo);
  lua_rawgeti(L, 3, i);
  bool occludes = lua_toboolean(L, -1);
  lua_pop(L, 3);
  return (ylm_shade_mesh){m->position,  m->normal,
                          m->vertices,  m->index,
                          m->triangles, {{(float)albedo[0], (float)albedo[1], (float)albedo[2]}},
                          occludes};
}

bool ylmL_shade_lamps(lua_State *L, int i, ylm_shade_lamps *lamps) {
  ylmL_array *at = ylmL_array_check(L, i), *r = ylmL_array_check(L, i + 1);
  ylmL_array *c = ylmL_array_check(L, i + 2);
  size_t n = r->count;
  if (at->dtype != YLM_DOUBLE || r->dtype != YLM_DOUBLE || c->dtype != YLM_DOUBLE ||
      at->count != 3 * n || c->count != 3 * n)
    luaL_argerror(L, i, "double arrays [n][3], [n], [n][3] expected");
  ylmL_array *t = ylmL_array_opt(L, i + 3), *d = ylmL_array_opt(L, i + 4),
             *more = ylmL_array_opt(L, i + 5);
  size_t nt = t ? t->count / 9 : 0, nd = d ? d->count / 7 : 0, flat = 9 * nt + 7 * nd;
  if ((more ? more->count : 0) != 6 * (nt + nd) || (t && t->dtype != YLM_DOUBLE) ||
      (d && d->dtype != YLM_DOUBLE) || (more && more->dtype != YLM_DOUBLE))
    luaL_argerror(L, i + 3, "double arrays [t][9], [d][7], [t+d][6] expected");
  ylmL_array *all = ylmL_array_new(L, YLM_FLOAT, 1, (size_t[]){7 * n + flat + 6 * (nt + nd)});
  if (!all) return false;
  float *sphere = all->data, *radiance = sphere + 4 * n, *shape = radiance + 3 * (n + nt + nd);
  for (size_t k = 0; k < 9 * nt; k++) shape[k] = (float)((const double *)t->data)[k];
  for (size_t k = 0; k < 7 * nd; k++) shape[9 * nt + k] = (float)((const double *)d->data)[k];
  float *horizon = shape + flat;
  for (size_t k = 0; k < nt + nd; k++)
    for (size_t a = 0; a < 3; a++) {
      radiance[3 * (n + k) + a] = (float)((const double *)more->data)[6 * k + a];
      horizon[3 * k + a] = (float)((const double *)more->data)[6 * k + 3 + a];
    }
  for (size_t k = 0; k < n; k++) {
    for (size_t a = 0; a < 3; a++) {
      sphere[4 * k + a] = (float)((const double *)at->data)[3 * k + a];
      radiance[3 * k + a] = (float)((const double *)c->data)[3 * k + a];
    }
    sphere[4 * k + 3] = (float)((const double *)r->data)[k];
  }
  *lamps =
      (ylm_shade_lamps){{n, nt, nd, sphere, shape, shape + 9 * nt}, radiance, horizon, 0, NULL};
  return true;
}

/* Adds the list of textures at `i` to the lamps: { texels float [h][w][3], {corner, u, v: 9
   numbers}, scale, triangles }. Leaves values on the stack that keep them alive. */
static void read_textures(lua_State *L, int i, ylm_shade_lamps *lamps) {
  size_t n = lua_isnoneornil(L, i) ? 0 : lua_rawlen(L, i);
  ylm_shade_texture *list = lua_newuserdata(L, (n + 1) * sizeof *list);
  for (size_t k = 0; k < n; k++) {
    double x[11];
    lua_rawgeti(L, i, (int)k + 1);
    lua_rawgeti(L, -1, 1);
    ylmL_array *a = ylmL_array_check(L, -1);
    lua_rawgeti(L, -2, 2);
    numbers(L, lua_gettop(L), 9, x);
    for (int c = 3; c <= 4; c++) {
      lua_rawgeti(L, -c, c); /* the entry moves down by one each time */
      x[c + 6] = (double)luaL_checknumber(L, -1);
    }
    if (a->dtype != YLM_FLOAT || a->axes != 3 || a->shape[2] != 3)
      luaL_argerror(L, i, "float arrays [height][width][3] expected");
    list[k] = (ylm_shade_texture){.width = a->shape[1],
                                  .height = a->shape[0],
                                  .texel = a->data,
                                  .scale = x[9],
                                  .triangles = (size_t)x[10]};
    memcpy(list[k].corner, x, sizeof list[k].corner);
    memcpy(list[k].u, x + 3, sizeof list[k].u);
    memcpy(list[k].v, x + 6, sizeof list[k].v);
    lua_pop(L, 5); /* the list itself keeps the arrays */
  }
  lamps->textures = n;
  lamps->texture = list;
}

/* shade_scene(meshes, albedos, occludes, at, radius, radiance, triangles, disks, radiance and
   horizon of these [..][6], textures) -> scene; the last four may be nil */
static int shade_scene(lua_State *L) {
  ylm_error e = {0};
  ylm_shade_lamps lamps;
  for (int i = 1; i <= 3; i++) luaL_checktype(L, i, LUA_TTABLE);
  lua_settop(L, 10);
  size_t n = lua_rawlen(L, 1);
  if (!ylmL_shade_lamps(L, 4, &lamps)) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  read_textures(L, 10, &lamps);
  ylm_shade_mesh *mesh = lua_newuserdata(L, (n + 1) * sizeof *mesh);
  for (size_t i = 0; i < n; i++) mesh[i] = read_mesh(L, (int)i + 1);
  ylm_shade_scene **s = lua_newuserdata(L, sizeof *s);
  *s = NULL;
  luaL_getmetatable(L, SCENE);
  lua_setmetatable(L, -2);
  return ylmL_result(L, 1, ylm_shade_scene_create(n, mesh, &lamps, s, &e), &e);
}

static void push_three(lua_State *L, const double x[3]) {
  lua_createtable(L, 3, 0);
  for (int a = 0; a < 3; a++) {
    lua_pushnumber(L, (lua_Number)x[a]);
    lua_rawseti(L, -2, a + 1);
  }
}

/* shade_bounds(scene) -> min, max */
static int shade_bounds(lua_State *L) {
  double lo[3], hi[3];
  ylm_shade_scene_bounds(check_scene(L, 1), lo, hi);
  push_three(L, lo);
  push_three(L, hi);
  return 2;
}

/* shade_vertices(scene) -> [n][3] */
static int shade_vertices(lua_State *L) {
  ylm_shade_scene *s = check_scene(L, 1);
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylm_shade_scene_vertices(s, NULL), 3});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_shade_scene_vertices(s, a->data);
  return 1;
}

/* shade_difference(a, b, out): out = |a - b|; float arrays of one size */
static int shade_difference(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1), *b = ylmL_array_check(L, 2), *c = ylmL_array_check(L, 3);
  if (a->dtype != YLM_FLOAT || b->dtype != YLM_FLOAT || c->dtype != YLM_FLOAT)
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (a->count != b->count || a->count != c->count) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  const float *x = a->data, *y = b->data;
  for (size_t i = 0; i < a->count; i++)
    ((float *)c->data)[i] = x[i] > y[i] ? x[i] - y[i] : y[i] - x[i];
  lua_pushvalue(L, 3);
  return 1;
}

/*
** shade_trace(scene, rays [n][8]: origin, direction, near, far; float, occlusion) ->
**   occlusion: blocked [n], 1 or 0
**   else:      hits [n][8]: mesh (from 1; 0 nothing, -1 a lamp), element from 1, t, u, v, normal
*/
static int shade_trace(lua_State *L) {
  const ylm_trace *t = ylm_shade_scene_trace(check_scene(L, 1));
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

enum {
  VIEW_SCENE = 1,
  CAMERA,
  WIDTH,
  HEIGHT,
  SAMPLES,
  LMAX,
  PER_VERTEX,
  VISIBILITY,
  TRANSFER,
  DISTANCE,
  SHARE,
  SEED,
  THREADS,
  PROGRESS
};

/* shade_view(scene, {from, at, up, fov: 10 numbers}, width, height, samples, lmax, per vertex,
   "none" | "pixel" | "vertex", transfer samples, occlusion distance, share, seed, threads,
   progress) -> view */
static int shade_view(lua_State *L) {
  static const char *const names[] = {"none", "pixel", "vertex", NULL};
  const ylm_shade_scene *scene = check_scene(L, VIEW_SCENE);
  ylm_error e = {0};
  ylmL_progress p;
  double c[10];
  numbers(L, CAMERA, 10, c);
  lua_settop(L, PROGRESS);
  ylm_camera camera = {{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}, c[9]};
  ylm_shade_options o = {.width = (int)luaL_checknumber(L, WIDTH),
                         .height = (int)luaL_checknumber(L, HEIGHT),
                         .samples = (int)luaL_checknumber(L, SAMPLES),
                         .lmax = (int)luaL_checknumber(L, LMAX),
                         .per_vertex = lua_toboolean(L, PER_VERTEX),
                         .visibility =
                             (ylm_shade_visibility)luaL_checkoption(L, VISIBILITY, "pixel", names),
                         .transfer_samples = (int)luaL_checknumber(L, TRANSFER),
                         .occlusion_distance = (double)luaL_checknumber(L, DISTANCE),
                         .share = (double)luaL_checknumber(L, SHARE),
                         .seed = (uint64_t)luaL_checknumber(L, SEED),
                         .threads = (int)luaL_checknumber(L, THREADS),
                         .progress = ylmL_progress_begin(L, PROGRESS, &p)};
  ylm_shade_view **v = lua_newuserdata(L, sizeof *v);
  *v = NULL;
  luaL_getmetatable(L, YLML_SHADE_VIEW);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_shade_view_create(scene, &camera, &o, v, &e);
  ylm_shade_stats stats = {0};
  if (s == YLM_OK) ylm_shade_view_stats(*v, &stats);
  ylmL_charge(L, stats.bytes);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* shade_stats(view) -> table */
static int shade_stats(lua_State *L) {
  ylm_shade_stats s;
  ylm_shade_view_stats(ylmL_shade_view(L, 1), &s);
  lua_newtable(L);
  ylmL_set_count(L, "points", s.points);
  ylmL_set_count(L, "hits", s.hits);
  ylmL_set_count(L, "pixels", s.pixels);
  ylmL_set_count(L, "primary_rays", s.primary_rays);
  ylmL_set_count(L, "occlusion_rays", s.occlusion_rays);
  ylmL_set_number(L, "primary_seconds", s.primary_seconds);
  ylmL_set_number(L, "transfer_seconds", s.transfer_seconds);
  ylmL_set_count(L, "bytes", s.bytes);
  return 1;
}

/* shade_points(view) -> position [n][3], normal [n][3], albedo [n][3], object [n] from 1 */
static int shade_points(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_stats stats;
  ylm_shade_view_stats(v, &stats);
  ylmL_array *a[4];
  for (int i = 0; i < 4; i++) {
    a[i] = ylmL_array_new(L, YLM_FLOAT, i < 3 ? 2 : 1, (size_t[]){stats.points, 3});
    if (!a[i]) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  }
  if (stats.points) {
    memcpy(a[0]->data, ylm_shade_view_positions(v), stats.points * 12);
    memcpy(a[1]->data, ylm_shade_view_normals(v), stats.points * 12);
    ylm_shade_view_surface(v, a[2]->data, a[3]->data);
  }
  for (size_t i = 0; i < stats.points; i++) ((float *)a[3]->data)[i] += 1;
  return 4;
}

/* shade_positions(view) -> [n][3] */
static int shade_positions(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_stats stats;
  ylm_shade_view_stats(v, &stats);
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){stats.points, 3});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_copy(a->data, ylm_shade_view_positions(v), stats.points * 12);
  return 1;
}

/* shade_transfer(view) -> [n][count] */
static int shade_transfer(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_stats stats;
  ylm_shade_view_stats(v, &stats);
  size_t l = (size_t)ylm_shade_view_options(v)->lmax + 1;
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){stats.points, l * l});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  memcpy(a->data, ylm_shade_view_transfer(v), a->count * sizeof(float));
  return 1;
}

static size_t point_count(const ylm_shade_view *v) {
  ylm_shade_stats stats;
  ylm_shade_view_stats(v, &stats);
  return stats.points;
}

/* shade_field(view, object, "float" | "double", threads, progress) -> radiance [n][3], pairs */
static int shade_field(lua_State *L) {
  static const char *const names[] = {"float", "double", NULL};
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_field *field = ylmL_field_check(L, 2);
  ylm_dtype t = (ylm_dtype)luaL_checkoption(L, 3, "float", names);
  int threads = (int)luaL_checknumber(L, 4);
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 5);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){point_count(v), 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  uint64_t pairs = 0;
  const ylm_progress *progress = ylmL_progress_begin(L, 5, &p);
  ylm_status s = ylm_shade_field(v, field, t, threads, progress, out->data, &pairs, &e);
  if (s == YLM_OK) ylmL_push_count(L, pairs);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* shade_coefficients(view, first from 1, L [n][channels][count], threads, out [n][3] or nil) -> out
 */
static int shade_coefficients(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  double first = (double)luaL_checknumber(L, 2);
  ylmL_array *c = ylmL_array_check(L, 3);
  int threads = (int)luaL_checknumber(L, 4), lmax = 0;
  ylm_status s = YLM_OK;
  lua_settop(L, 5);
  if (c->axes != 3 || !(first >= 1)) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  while ((size_t)(lmax + 1) * (size_t)(lmax + 1) < c->shape[2]) lmax++;
  if ((size_t)(lmax + 1) * (size_t)(lmax + 1) != c->shape[2])
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_shade_result(L, 5, 2, (size_t[]){c->shape[0], 3}, &s);
  if (s == YLM_OK)
    s = ylm_shade_coefficients(v, (size_t)first - 1, c->shape[0], (int)c->shape[1], lmax, c->dtype,
                               c->data, threads, out->data);
  return ylmL_result(L, 1, s, NULL);
}

/* shade_raycast(view, samples, shadows, seed, threads, progress) -> radiance [n][3], rays */
static int shade_raycast(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  int samples = (int)luaL_checknumber(L, 2), threads = (int)luaL_checknumber(L, 5);
  bool shadows = lua_toboolean(L, 3);
  uint64_t seed = (uint64_t)luaL_checknumber(L, 4), rays = 0;
  ylmL_progress p;
  lua_settop(L, 6);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){point_count(v), 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  const ylm_progress *progress = ylmL_progress_begin(L, 6, &p);
  ylm_status s = ylm_shade_raycast(v, samples, shadows, seed, threads, progress, out->data, &rays);
  if (s == YLM_OK) ylmL_push_count(L, rays);
  return ylmL_result_progress(L, 2, s, NULL, &p);
}

/* shade_resolve(view, values [n][c] or [n], fill or nil, covered, threads, out [h][w][c] or nil)
   -> out; fill is a table of c numbers */
static int shade_resolve(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylmL_array *values = ylmL_array_check(L, 2);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  double fill[4] = {0};
  float fills[4];
  ylm_status s = YLM_OK;
  size_t channels = values->axes > 1 ? values->shape[values->axes - 1] : 1;
  bool covered = lua_toboolean(L, 4);
  int threads = (int)luaL_checknumber(L, 5);
  lua_settop(L, 6);
  if (channels < 1 || channels > 4 || values->dtype != YLM_FLOAT ||
      values->count != point_count(v) * channels)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (!lua_isnil(L, 3)) numbers(L, 3, (int)channels, fill);
  for (int c = 0; c < 4; c++) fills[c] = (float)fill[c];
  ylmL_array *out =
      ylmL_shade_result(L, 6, 3, (size_t[]){(size_t)o->height, (size_t)o->width, channels}, &s);
  if (s == YLM_OK)
    s = ylm_shade_resolve(v, (int)channels, values->data, fills, covered, threads, out->data);
  return ylmL_result(L, 1, s, NULL);
}

/* shade_compose(view, colours [n][3], background {r, g, b}, threads, out [h][w][3] or nil) -> out
 */
static int shade_compose(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylmL_array *colours = ylmL_array_check(L, 2);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  double b[3];
  ylm_status s = YLM_OK;
  numbers(L, 3, 3, b);
  int threads = (int)luaL_checknumber(L, 4);
  lua_settop(L, 5);
  if (colours->dtype != YLM_FLOAT || colours->count != 3 * point_count(v))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out =
      ylmL_shade_result(L, 5, 3, (size_t[]){(size_t)o->height, (size_t)o->width, 3}, &s);
  if (s == YLM_OK)
    s = ylm_shade_compose(v, colours->data, (float[]){(float)b[0], (float)b[1], (float)b[2]},
                          threads, out->data);
  return ylmL_result(L, 1, s, NULL);
}

/* shade_layer(view, name, threads, out or nil) -> out [h][w][c] */
static int shade_layer(lua_State *L) {
  static const char *const names[] = {"lamps",  "depth",    "coverage", "emitter",
                                      "normal", "position", "albedo",   NULL};
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_layer layer = (ylm_shade_layer)luaL_checkoption(L, 2, NULL, names);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  int threads = (int)luaL_checknumber(L, 3);
  ylm_status s = YLM_OK;
  lua_settop(L, 4);
  size_t shape[3] = {(size_t)o->height, (size_t)o->width, (size_t)ylm_shade_layer_channels(layer)};
  ylmL_array *out = ylmL_shade_result(L, 4, 3, shape, &s);
  if (s == YLM_OK) s = ylm_shade_layer_write(v, layer, threads, out->data);
  return ylmL_result(L, 1, s, NULL);
}

/* material_cosine(lmax) -> [lmax+1] */
static int material_cosine(lua_State *L) {
  double lmax = (double)luaL_checknumber(L, 1);
  if (!(lmax >= 0 && lmax <= YLM_MATERIAL_LMAX)) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 1, (size_t[]){(size_t)lmax + 1});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 1, ylm_material_cosine((int)lmax, a->data), NULL);
}

static const luaL_Reg functions[] = {{"shade_scene", shade_scene},
                                     {"shade_close_scene", scene_close},
                                     {"shade_bounds", shade_bounds},
                                     {"shade_vertices", shade_vertices},
                                     {"shade_difference", shade_difference},
                                     {"shade_trace", shade_trace},
                                     {"shade_view", shade_view},
                                     {"shade_close_view", view_close},
                                     {"shade_stats", shade_stats},
                                     {"shade_points", shade_points},
                                     {"shade_positions", shade_positions},
                                     {"shade_transfer", shade_transfer},
                                     {"shade_field", shade_field},
                                     {"shade_coefficients", shade_coefficients},
                                     {"shade_raycast", shade_raycast},
                                     {"shade_resolve", shade_resolve},
                                     {"shade_compose", shade_compose},
                                     {"shade_layer", shade_layer},
                                     {"material_cosine", material_cosine},
                                     {NULL, NULL}};

void ylmL_open_shade(lua_State *L) {
  ylmL_type(L, SCENE, scene_methods);
  ylmL_type(L, YLML_SHADE_VIEW, view_methods);
  lua_pop(L, 2);
  luaL_setfuncs(L, functions, 0);
}
