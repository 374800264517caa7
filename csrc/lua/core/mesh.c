/* mesh.c - meshes: shapes, transforms, files, their numbers as arrays. */
#include <math.h>

#include "../binding.h"
#include "ylm_geom.h"

/* The n numbers of the table at `i`. */
static void numbers(lua_State *L, int i, int n, double *x) {
  luaL_checktype(L, i, LUA_TTABLE);
  for (int k = 0; k < n; k++) {
    lua_rawgeti(L, i, k + 1);
    if (lua_type(L, -1) != LUA_TNUMBER) luaL_argerror(L, i, "a table of numbers expected");
    x[k] = (double)lua_tonumber(L, -1);
    lua_pop(L, 1);
  }
}

static int integer(lua_State *L, int i) {
  double x = (double)luaL_checknumber(L, i);
  return x > 2e9 ? 2000000000 : x < -2e9 ? -2000000000 : (int)x;
}

/* mesh_quad(corner, u, v, nu, nv) -> mesh */
static int mesh_quad(lua_State *L) {
  double corner[3], u[3], v[3];
  ylm_error e = {0};
  numbers(L, 1, 3, corner);
  numbers(L, 2, 3, u);
  numbers(L, 3, 3, v);
  int nu = integer(L, 4), nv = integer(L, 5);
  ylm_mesh **m = ylmL_mesh_new(L);
  return ylmL_result(L, 1, ylm_mesh_quad(corner, u, v, nu, nv, m, &e), &e);
}

/* mesh_sphere(radius, around, rings) -> mesh */
static int mesh_sphere(lua_State *L) {
  ylm_error e = {0};
  double r = (double)luaL_checknumber(L, 1);
  int around = integer(L, 2), rings = integer(L, 3);
  ylm_mesh **m = ylmL_mesh_new(L);
  return ylmL_result(L, 1, ylm_mesh_sphere(r, around, rings, m, &e), &e);
}

/* mesh_box(lower, upper, n) -> mesh */
static int mesh_box(lua_State *L) {
  double lo[3], hi[3];
  ylm_error e = {0};
  numbers(L, 1, 3, lo);
  numbers(L, 2, 3, hi);
  int n = integer(L, 3);
  ylm_mesh **m = ylmL_mesh_new(L);
  return ylmL_result(L, 1, ylm_mesh_box(lo, hi, n, m, &e), &e);
}

/* mesh_torus(radius, tube, around, across) -> mesh */
static int mesh_torus(lua_State *L) {
  ylm_error e = {0};
  double radius = (double)luaL_checknumber(L, 1), tube = (double)luaL_checknumber(L, 2);
  int around = integer(L, 3), across = integer(L, 4);
  ylm_mesh **m = ylmL_mesh_new(L);
  return ylmL_result(L, 1, ylm_mesh_torus(radius, tube, around, across, m, &e), &e);
}

/* mesh_knot(p, q, radius, minor, tube, along, across) -> mesh */
static int mesh_knot(lua_State *L) {
  ylm_error e = {0};
  int p = integer(L, 1), q = integer(L, 2), along = integer(L, 6), across = integer(L, 7);
  double radius = (double)luaL_checknumber(L, 3), minor = (double)luaL_checknumber(L, 4);
  double tube = (double)luaL_checknumber(L, 5);
  ylm_mesh **m = ylmL_mesh_new(L);
  return ylmL_result(L, 1, ylm_mesh_knot(p, q, radius, minor, tube, along, across, m, &e), &e);
}

/* Copies finite numbers; false if one of them is not. */
static bool copy_floats(const ylmL_array *a, float *out) {
  size_t where;
  for (size_t i = 0; i < a->count; i++) out[i] = (float)ylmL_array_get(a, i);
  return ylm_all_finite(YLM_FLOAT, out, a->count, &where);
}

/* Takes places from an array, whatever its type. */
static ylm_status copy_places(const ylmL_array *a, ylm_mesh *m, ylm_error *e) {
  double *place = ylm_alloc(a->count, sizeof *place);
  bool finite = true;
  if (!place) return ylm_no_memory(e);
  for (size_t i = 0; i < a->count; i++) {
    place[i] = ylmL_array_get(a, i);
    finite = finite && isfinite((float)place[i]);
  }
  if (finite) ylm_mesh_set_places(m, place);
  ylm_free(place);
  return finite ? YLM_OK : ylm_fail(e, YLM_EDOMAIN, "a vertex is not finite");
}

/* Gives a mesh the colours [vertices][3], each number from 0 to 1. */
static ylm_status copy_colours(const ylmL_array *a, size_t vertices, ylm_mesh *m, ylm_error *e) {
  m->colour = ylm_alloc(3 * vertices, sizeof(float));
  if (!m->colour) return ylm_no_memory(e);
  for (size_t i = 0; i < a->count; i++) {
    m->colour[i] = (float)ylmL_array_get(a, i);
    if (!(m->colour[i] >= 0 && m->colour[i] <= 1))
      return ylm_fail(e, YLM_EDOMAIN, "colours: row %zu has %g, numbers from 0 to 1 are wanted",
                      i / 3 + 1, (double)m->colour[i]);
  }
  return YLM_OK;
}

/* Fills an empty mesh from arrays; indices are one-based. */
static ylm_status from_arrays(const ylmL_array *p, const ylmL_array *t, const ylmL_array *n,
                              const ylmL_array *uv, const ylmL_array *colour, double crease,
                              ylm_mesh **m, ylm_error *e) {
  size_t vertices = p->count / 3, triangles = t->count / 3;
  ylm_status s = ylm_mesh_create(vertices, triangles, n != NULL, uv != NULL, m, e);
  if (s != YLM_OK) return s;
  if ((s = copy_places(p, *m, e)) != YLM_OK) return s;
  if (n && !copy_floats(n, (*m)->normal)) return ylm_fail(e, YLM_EDOMAIN, "a normal is not finite");
  if (uv && !copy_floats(uv, (*m)->uv))
    return ylm_fail(e, YLM_EDOMAIN, "a texture coordinate is not finite");
  if (colour) s = copy_colours(colour, vertices, *m, e);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < t->count; i++) {
    double k = ylmL_array_get(t, i);
    if (!(k >= 1 && k <= (double)vertices) || k != (double)(uint32_t)k)
      return ylm_fail(e, YLM_ERANGE, "triangle %zu: index %g is not an integer from 1 to %zu",
                      i / 3 + 1, k, vertices);
    (*m)->index[i] = (uint32_t)k - 1;
  }
  return n ? YLM_OK : ylm_mesh_make_creased_normals(*m, crease, NULL);
}

/* mesh_from(vertices [n][3], triangles [m][3], normals, uvs, colours: each may be nil, crease in degrees or nil: none) -> mesh */
static int mesh_from(lua_State *L) {
  ylmL_array *p = ylmL_array_check(L, 1), *t = ylmL_array_check(L, 2);
  ylmL_array *n = ylmL_array_opt(L, 3), *uv = ylmL_array_opt(L, 4), *c = ylmL_array_opt(L, 5);
  double crease = luaL_optnumber(L, 6, 180);
  ylm_error e = {0};
  if (p->count % 3 || t->count % 3 || (n && n->count != p->count) ||
      (uv && uv->count / 2 != p->count / 3) || (c && c->count != p->count))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_mesh **m = ylmL_mesh_new(L);
  return ylmL_result(L, 1, from_arrays(p, t, n, uv, c, crease, m, &e), &e);
}

/* mesh_read(path) -> mesh */
static int mesh_read(lua_State *L) {
  ylm_error e = {0};
  const char *path = luaL_checkstring(L, 1);
  ylm_mesh **m = ylmL_mesh_new(L);
  return ylmL_result(L, 1, ylm_mesh_read(path, YLM_MESH_CREASE, m, &e), &e);
}

/* mesh_write(mesh, path) -> true */
static int mesh_write(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = ylm_mesh_write_ply(ylmL_mesh_check(L, 1), luaL_checkstring(L, 2), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* mesh_transform(mesh, twelve numbers) -> true */
static int mesh_transform(lua_State *L) {
  ylm_error e = {0};
  double m[12];
  numbers(L, 2, 12, m);
  ylm_status s = ylm_mesh_transform(ylmL_mesh_check(L, 1), m, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* mesh_rotation(axis, radians) -> twelve numbers */
static int mesh_rotation(lua_State *L) {
  double axis[3], m[12];
  numbers(L, 1, 3, axis);
  ylm_transform_rotate(m, axis, (double)luaL_checknumber(L, 2));
  lua_createtable(L, 12, 0);
  for (int i = 0; i < 12; i++) {
    lua_pushnumber(L, (lua_Number)m[i]);
    lua_rawseti(L, -2, i + 1);
  }
  return 1;
}

static void push_three(lua_State *L, const double x[3]) {
  lua_createtable(L, 3, 0);
  for (int i = 0; i < 3; i++) {
    lua_pushnumber(L, (lua_Number)x[i]);
    lua_rawseti(L, -2, i + 1);
  }
}

/* mesh_info(mesh) -> number of vertices, of triangles, lower corner, upper corner, area */
static int mesh_info(lua_State *L) {
  ylm_mesh *m = ylmL_mesh_check(L, 1);
  double lo[3], hi[3];
  ylm_mesh_bounds(m, lo, hi);
  lua_pushinteger(L, (lua_Integer)m->vertices);
  lua_pushinteger(L, (lua_Integer)m->triangles);
  push_three(L, lo);
  push_three(L, hi);
  lua_pushnumber(L, (lua_Number)ylm_mesh_area(m));
  return 5;
}

static int push_floats(lua_State *L, float *data, size_t rows, size_t width) {
  size_t shape[2] = {rows, width};
  if (!data) return 0;
  ylmL_object_array(L, 1, YLM_FLOAT, 2, shape, data);
  return 1;
}

/* mesh_vertices(mesh) -> float [n][3] that the mesh shares, or double [n][3] of a mesh far from 0 */
static int mesh_vertices(lua_State *L) {
  ylm_mesh *m = ylmL_mesh_check(L, 1);
  if (!ylm_mesh_is_far(m)) return push_floats(L, m->position, m->vertices, 3);
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){m->vertices, 3});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < m->vertices; i++) ylm_mesh_place(m, i, (double *)a->data + 3 * i);
  return 1;
}

static int mesh_normals(lua_State *L) {
  ylm_mesh *m = ylmL_mesh_check(L, 1);
  return push_floats(L, m->normal, m->vertices, 3);
}

static int mesh_uvs(lua_State *L) {
  ylm_mesh *m = ylmL_mesh_check(L, 1);
  return push_floats(L, m->uv, m->vertices, 2);
}

static int mesh_colours(lua_State *L) {
  ylm_mesh *m = ylmL_mesh_check(L, 1);
  return push_floats(L, m->colour, m->vertices, 3);
}

/* mesh_triangles(mesh) -> a new array of one-based indices, int32 [m][3] */
static int mesh_triangles(lua_State *L) {
  ylm_mesh *m = ylmL_mesh_check(L, 1);
  size_t shape[2] = {m->triangles, 3};
  ylmL_array *a = ylmL_array_new(L, YLM_INT32, 2, shape);
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < a->count; i++) ((int32_t *)a->data)[i] = (int32_t)m->index[i] + 1;
  return 1;
}

/* mesh_sphere_set(mesh, count, at double [count][3], radius double [count], progress) -> count, volume, outside, uncovered,
   step */
static int mesh_sphere_set(lua_State *L) {
  const ylm_mesh *m = ylmL_mesh_check(L, 1);
  size_t count = (size_t)luaL_checknumber(L, 2);
  const ylmL_array *at = ylmL_array_check(L, 3), *radius = ylmL_array_check(L, 4);
  ylm_error e = {YLM_OK, ""};
  ylm_sphere_set set;
  if (at->dtype != YLM_DOUBLE || radius->dtype != YLM_DOUBLE || at->count != 3 * count ||
      radius->count != count)
    return luaL_argerror(L, 3, "double arrays of another shape expected");
  ylmL_progress progress;
  const ylm_progress *report = ylmL_progress_begin(L, 5, &progress);
  ylm_status s = ylm_mesh_sphere_set(m, count, at->data, radius->data, &set, report, &e);
  lua_pushnumber(L, (lua_Number)set.count);
  lua_pushnumber(L, set.volume);
  lua_pushnumber(L, set.outside);
  lua_pushnumber(L, set.uncovered);
  lua_pushnumber(L, set.step);
  return ylmL_result_progress(L, 5, s, &e, &progress);
}

static const luaL_Reg functions[] = {{"mesh_quad", mesh_quad},
                                     {"mesh_sphere", mesh_sphere},
                                     {"mesh_box", mesh_box},
                                     {"mesh_torus", mesh_torus},
                                     {"mesh_knot", mesh_knot},
                                     {"mesh_from", mesh_from},
                                     {"mesh_read", mesh_read},
                                     {"mesh_write", mesh_write},
                                     {"mesh_transform", mesh_transform},
                                     {"mesh_rotation", mesh_rotation},
                                     {"mesh_info", mesh_info},
                                     {"mesh_vertices", mesh_vertices},
                                     {"mesh_normals", mesh_normals},
                                     {"mesh_uvs", mesh_uvs},
                                     {"mesh_colours", mesh_colours},
                                     {"mesh_triangles", mesh_triangles},
                                     {"mesh_sphere_set", mesh_sphere_set},
                                     {NULL, NULL}};

void ylmL_open_mesh(lua_State *L) {
  ylmL_mesh_new(L); /* registers the type */
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
