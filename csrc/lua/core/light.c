/* light.c - ylm.lights: sets of lights, and the evaluation of any object's light field. */
#include "../binding.h"

#include <string.h>

#include "ylm_light.h"

#define LIGHTS "ylm.lights"

static ylm_lights *check_lights(lua_State *L, int i) {
  ylm_lights **l = ylmL_check(L, i, LIGHTS);
  if (!*l) luaL_argerror(L, i, "the lights have been closed");
  return *l;
}

static const ylm_field *field_of(void *object) {
  ylm_lights **l = object;
  return *l ? ylm_lights_field(*l) : NULL;
}

static int push_lights(lua_State *L, size_t n, const double *at, const double *radius,
                       const double *rgb) {
  ylm_error e = {0};
  ylm_lights **l = lua_newuserdata(L, sizeof *l);
  *l = NULL;
  luaL_getmetatable(L, LIGHTS);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_lights_create(n, at, radius, rgb, l, &e);
  if (s == YLM_OK) ylmL_charge(L, n * 160);
  return ylmL_result(L, 1, s, &e);
}

/* The double array at stack index i; raises otherwise. */
static const ylmL_array *doubles(lua_State *L, int i) {
  const ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_DOUBLE) luaL_argerror(L, i, "a double array expected");
  return a;
}

/*
** lights_create(at [n][3], radius [n] or [1], radiance [n][3], or [3] for all, [n] or [1] of grey)
** -> lights. Arrays are double.
*/
static int lights_create(lua_State *L) {
  const ylmL_array *at = doubles(L, 1), *r = doubles(L, 2), *c = doubles(L, 3);
  size_t n = at->count / 3;
  bool rows = c->axes == 2;
  if (at->count % 3 || (r->count != 1 && r->count != n) ||
      (rows ? c->count != 3 * n : c->count != 1 && c->count != 3 && c->count != n))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *all = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 4}); /* collected by Lua */
  if (!all) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *radius = all->data, *rgb = radius + n;
  const double *radii = r->data, *colours = c->data;
  for (size_t i = 0; i < n; i++) {
    radius[i] = radii[r->count == 1 ? 0 : i];
    for (size_t a = 0; a < 3; a++)
      rgb[3 * i + a] = colours[rows ? 3 * i + a : c->count == 3 ? a : c->count == 1 ? 0 : i];
  }
  return push_lights(L, n, at->data, radius, rgb);
}

static int lights_close(lua_State *L) {
  ylm_lights **l = ylmL_check(L, 1, LIGHTS);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_lights_free(*l);
  *l = NULL;
  return 0;
}

/* lights_count(lights) -> number, or nil once closed */
static int lights_count(lua_State *L) {
  ylm_lights **l = ylmL_check(L, 1, LIGHTS);
  if (!*l) return 0;
  ylmL_push_count(L, ylm_lights_count(*l));
  return 1;
}

/* lights_arrays(lights) -> copies of at [n][3], radius [n], radiance [n][3] */
static int lights_arrays(lua_State *L) {
  const ylm_lights *l = check_lights(L, 1);
  const double *from[3];
  ylm_lights_arrays(l, &from[0], &from[1], &from[2]);
  size_t shape[2] = {ylm_lights_count(l), 3};
  for (int i = 0; i < 3; i++) {
    ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, i == 1 ? 1 : 2, shape);
    if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
    memcpy(a->data, from[i], a->count * sizeof(double));
  }
  return 3;
}

/* lights_join(list of lights) -> all of them as one, in that order */
static int lights_join(lua_State *L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  int parts = (int)lua_rawlen(L, 1);
  size_t n = 0, k = 0;
  for (int i = 1; i <= parts; i++) {
    lua_rawgeti(L, 1, i);
    n += ylm_lights_count(check_lights(L, -1));
    lua_pop(L, 1);
  }
  size_t shape[2] = {n, 7};
  ylmL_array *all = ylmL_array_new(L, YLM_DOUBLE, 2, shape); /* collected whatever happens */
  if (!all) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *at = all->data, *radius = at + 3 * n, *rgb = at + 4 * n;
  for (int i = 1; i <= parts; i++) {
    const double *from[3];
    lua_rawgeti(L, 1, i);
    const ylm_lights *l = check_lights(L, -1);
    size_t m = ylm_lights_count(l);
    ylm_lights_arrays(l, &from[0], &from[1], &from[2]);
    memcpy(at + 3 * k, from[0], 3 * m * sizeof(double));
    memcpy(radius + k, from[1], m * sizeof(double));
    memcpy(rgb + 3 * k, from[2], 3 * m * sizeof(double));
    k += m;
    lua_pop(L, 1);
  }
  return push_lights(L, n, at, radius, rgb);
}

/* has_field(value) -> true for an object with a light field */
static int has_field(lua_State *L) {
  bool yes = lua_type(L, 1) == LUA_TUSERDATA && luaL_getmetafield(L, 1, "__field");
  lua_pushboolean(L, yes);
  return 1;
}

enum {
  OBJECT = 1,
  LMAX,
  POINTS,
  CHANNELS,
  WANT,
  METRIC_CHANNELS,
  THREADS,
  PROGRESS,
  OUT_VALUE,
  OUT_GRADIENT,
  OUT_HESSIAN,
  ISA,
  ARGUMENTS = ISA
};

static ylm_isa check_isa(lua_State *L, int i) {
  const char *name = luaL_checkstring(L, i);
  for (int k = 0; k < YLM_ISA_COUNT; k++)
    if (strcmp(name, ylm_isa_name((ylm_isa)k)) == 0) return (ylm_isa)k;
  luaL_argerror(L, i, "no such instruction set");
  return YLM_ISA_reference;
}

/* Calls the field, or lights by the kernels of a given instruction set (for specs and
   benchmarks). */
static ylm_status call_field(lua_State *L, const ylm_field *f, const ylm_field_query *q, size_t n,
                             const void *points, ylm_field_result *r, ylm_error *e) {
  if (lua_isnil(L, ISA)) return f->evaluate(f, q, n, points, r, e);
  ylm_polygons *p = ylmL_polygons(L, OBJECT);
  if (p) return ylm_polygons_evaluate(p, check_isa(L, ISA), q, n, points, r, e);
  if (ylmL_test(L, OBJECT, "ylm.light_cut"))
    return ylm_light_cut_evaluate(f->self, check_isa(L, ISA), q, n, points, r, e);
  return ylm_lights_evaluate(check_lights(L, OBJECT), check_isa(L, ISA), q, n, points, r, e);
}

/*
** field_evaluate(object, lmax, points [n][3], channels, want, metric_channels, threads, progress,
**                out value, out gradient, out hessian, isa)
**   -> value, gradient, hessian, lambda [n], norm [n], inside [n] of 0 and 1, pairs; nil where not
**   wanted
** The dtype is that of the points.
*/
static int field_evaluate(lua_State *L) {
  lua_settop(L, ARGUMENTS);
  luaL_checkstack(L, 20, "field_evaluate");
  const ylm_field *f = ylmL_field_check(L, OBJECT);
  ylmL_array *points = ylmL_array_check(L, POINTS);
  size_t n = points->count / 3;
  ylmL_progress progress;
  ylm_field_query q = {.lmax = (int)luaL_checknumber(L, LMAX),
                       .channels = (int)luaL_checknumber(L, CHANNELS),
                       .want = (int)luaL_checknumber(L, WANT),
                       .metric_channels = (int)luaL_checknumber(L, METRIC_CHANNELS),
                       .dtype = points->dtype,
                       .threads = (int)luaL_checknumber(L, THREADS),
                       .progress = ylmL_progress_begin(L, PROGRESS, &progress)};
  if (points->axes != 2 || points->shape[1] != 3 || q.lmax < 0 || q.lmax > 10000)
    return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t shape[4] = {n, (size_t)q.channels, (size_t)(q.lmax + 1) * (size_t)(q.lmax + 1), 0};
  ylm_status s = YLM_OK;
  ylm_field_result r = {0};
  void **slots[3] = {&r.value, &r.gradient, &r.hessian};
  for (int i = 0; i < 3; i++) {
    shape[3] = i == 1 ? 3 : 6;
    if (q.want & (1 << i)) {
      ylmL_array *a = ylmL_array_result(L, OUT_VALUE + i, q.dtype, i ? 4 : 3, shape, &s);
      *slots[i] = a ? a->data : NULL;
    } else
      lua_pushnil(L);
  }
  for (int i = 0; i < 2; i++) {
    lua_pushnil(L);
    if (q.want & YLM_WANT_METRIC) {
      ylmL_array *a = ylmL_array_result(L, lua_gettop(L), q.dtype, 1, shape, &s);
      lua_remove(L, -2);
      *(i ? &r.norm : &r.lambda) = a ? a->data : NULL;
    }
  }
  uint8_t *inside = lua_newuserdata(L, n + 1); /* collected whatever happens */
  r.inside = inside;
  ylm_error e = {0};
  if (s == YLM_OK) s = call_field(L, f, &q, n, points->data, &r, &e);
  if (s != YLM_OK) return ylmL_result_progress(L, 0, s, &e, &progress);
  ylmL_array *flags = ylmL_array_new(L, YLM_FLOAT, 1, shape);
  if (!flags) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++) ((float *)flags->data)[i] = inside[i];
  lua_remove(L, -2);
  ylmL_push_count(L, r.pairs);
  return ylmL_result_progress(L, 7, YLM_OK, &e, &progress);
}

/* field_crosses(object, boxes [n][6] of double: min, max) -> array [n] of 0 and 1 */
static int field_crosses(lua_State *L) {
  const ylm_field *f = ylmL_field_check(L, 1);
  const ylmL_array *boxes = doubles(L, 2);
  if (boxes->axes != 2 || boxes->shape[1] != 6) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = boxes->shape[0];
  uint8_t *out = lua_newuserdata(L, n + 1);
  ylm_status s = f->crosses(f, n, boxes->data, out);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  ylmL_array *flags = ylmL_array_new(L, YLM_FLOAT, 1, boxes->shape);
  if (!flags) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++) ((float *)flags->data)[i] = out[i];
  return 1;
}

static const luaL_Reg functions[] = {{"lights_create", lights_create},
                                     {"lights_join", lights_join},
                                     {"lights_close", lights_close},
                                     {"lights_count", lights_count},
                                     {"lights_arrays", lights_arrays},
                                     {"has_field", has_field},
                                     {"field_evaluate", field_evaluate},
                                     {"field_crosses", field_crosses},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", lights_close}, {NULL, NULL}};

void ylmL_open_light(lua_State *L) {
  ylmL_type(L, LIGHTS, methods);
  ylmL_type_has_field(L, field_of);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
