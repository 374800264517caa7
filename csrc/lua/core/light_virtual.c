/* light_virtual.c - ylm.virtual_lights: sets of virtual lights. */
#include "../binding.h"

#include <math.h>
#include <string.h>

#include "ylm_light_virtual.h"

/* The virtual lights that the set at `i` is; raises for another. */
static ylm_light_virtual *lights_at(lua_State *L, int i) {
  ylm_light_virtual *v = ylm_light_set_virtuals(ylmL_lights_check(L, i));
  if (!v) luaL_argerror(L, i, "virtual lights expected");
  return v;
}

/* A set of lights, whose use is given up, on the stack. */
static int push_set(lua_State *L, ylm_light_virtual *v) {
  ylm_error e = {0};
  ylm_status s = ylm_light_set_virtual(v, ylmL_lights_new(L), &e);
  if (s == YLM_OK) ylmL_charge(L, ylm_light_virtual_bytes(v));
  ylm_light_virtual_free(v);
  return s == YLM_OK ? 1 : ylmL_result(L, 0, s, &e);
}

/* The double array at `i`; raises otherwise. */
static const ylmL_array *doubles(lua_State *L, int i) {
  const ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_DOUBLE) luaL_argerror(L, i, "a double array expected");
  return a;
}

/* n rows of `wide` numbers from the array at `i`, NULL where nil stands there and may. */
static const double *rows(lua_State *L, int i, size_t n, size_t wide, bool needed) {
  if (!needed && lua_isnil(L, i)) return NULL;
  const ylmL_array *a = doubles(L, i);
  if (a->count != n * wide) luaL_argerror(L, i, "an array of another shape expected");
  return a->data;
}

/* n numbers at `to` from the array at `i`, which may have one for all; nil: 0. */
static void spread(lua_State *L, int i, size_t n, double *to) {
  bool none = lua_isnil(L, i);
  const ylmL_array *a = none ? NULL : doubles(L, i);
  if (a && a->count != 1 && a->count != n) luaL_argerror(L, i, "one number or n expected");
  for (size_t k = 0; k < n; k++)
    to[k] = none ? 0 : ((const double *)a->data)[a->count == 1 ? 0 : k];
}

/* Intensities [n][3], [n], [3] or [1] as emissions of degree 0, [n][3]. */
static void spread_colours(lua_State *L, int i, size_t n, double *to) {
  const ylmL_array *a = doubles(L, i);
  const double *c = a->data;
  bool wide = a->axes == 2;
  if (wide ? a->count != 3 * n : a->count != 1 && a->count != 3 && a->count != n)
    luaL_argerror(L, i, "an array of another shape expected");
  for (size_t k = 0; k < n; k++)
    for (size_t x = 0; x < 3; x++)
      to[3 * k + x] = sqrt(4 * YLM_PI) * c[wide            ? 3 * k + x
                                           : a->count == 3 ? x
                                           : a->count == 1 ? 0
                                                           : k];
}

static ylm_light_virtual_profile profile_at(lua_State *L, int i) {
  ylm_light_virtual_profile p = ylm_light_virtual_profile_of(luaL_checkstring(L, i));
  if (p == YLM_LIGHT_VIRTUAL_PROFILE_COUNT) luaL_argerror(L, i, "no such profile");
  return p;
}

/*
** lights_virtual(at [n][3], normal [n][3] | nil, radius [n] or [1] | nil, shift likewise, degree,
**                emission [n][3][(degree+1)^2], profile) -> lights
** degree nil: instead of an emission an intensity [n][3], [3], [n] or [1]. Arrays are double.
*/
static int lights_virtual(lua_State *L) {
  ylm_error e = {0};
  ylm_light_virtual *v;
  const ylmL_array *at = doubles(L, 1);
  bool plain = lua_isnil(L, 5);
  int degree = plain ? 0 : (int)luaL_checknumber(L, 5);
  size_t n = at->count / 3, wide = 3 * YLM_LIGHT_VIRTUAL_NUMBERS(degree);
  if (degree < 0 || degree > YLM_LIGHT_VIRTUAL_DEGREE) return luaL_argerror(L, 5, "no such degree");
  ylmL_array *all = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 5}); /* collected by Lua */
  if (!all) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *radius = all->data, *shift = radius + n, *colour = shift + n;
  spread(L, 3, n, radius);
  spread(L, 4, n, shift);
  if (plain) spread_colours(L, 6, n, colour);
  ylm_light_virtual_form f = {.n = n,
                              .at = rows(L, 1, n, 3, true),
                              .normal = rows(L, 2, n, 3, false),
                              .radius = radius,
                              .shift = shift,
                              .degree = degree,
                              .emission = plain ? colour : rows(L, 6, n, wide, true),
                              .profile = profile_at(L, 7)};
  ylm_status s = ylm_light_virtual_create(&f, &v, &e);
  return s == YLM_OK ? push_set(L, v) : ylmL_result(L, 0, s, &e);
}

/* lights_virtual_info(lights) -> { count, degree, profile, core | nil, bytes, power = {r, g, b},
   radius = { mean, max } } */
static int lights_virtual_info(lua_State *L) {
  ylm_light_virtual *v = lights_at(L, 1);
  ylm_light_virtual_form f;
  double power[3], largest = 0, sum = 0;
  ylm_light_virtual_get(v, &f);
  ylm_light_virtual_power(v, power);
  for (size_t i = 0; i < f.n; i++) {
    largest = f.radius[i] > largest ? f.radius[i] : largest;
    sum += f.radius[i];
  }
  lua_createtable(L, 0, 8);
  ylmL_set_count(L, "count", f.n);
  ylmL_set_count(L, "degree", (uint64_t)f.degree);
  ylmL_set_count(L, "bytes", ylm_light_virtual_bytes(v));
  lua_createtable(L, 0, 2);
  ylmL_set_number(L, "mean", f.n ? sum / (double)f.n : 0);
  ylmL_set_number(L, "max", largest);
  lua_setfield(L, -2, "radius");
  if (f.core > 0) ylmL_set_number(L, "core", f.core);
  lua_pushstring(L, ylm_light_virtual_profile_name(f.profile));
  lua_setfield(L, -2, "profile");
  lua_createtable(L, 3, 0);
  for (int c = 0; c < 3; c++) {
    lua_pushnumber(L, power[c]);
    lua_rawseti(L, -2, c + 1);
  }
  lua_setfield(L, -2, "power");
  return 1;
}

static bool push_numbers(lua_State *L, const double *x, int axes, const size_t *shape) {
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, axes, shape);
  if (a) ylm_copy(a->data, x, a->count * sizeof *x);
  return a != NULL;
}

/* lights_virtual_arrays(lights) -> at [n][3], normal [n][3], radius [n],
   emission [n][3][(degree+1)^2], shift [n]: new double arrays */
static int lights_virtual_arrays(lua_State *L) {
  ylm_light_virtual_form f;
  ylm_light_virtual_get(lights_at(L, 1), &f);
  size_t shape[3] = {f.n, 3, YLM_LIGHT_VIRTUAL_NUMBERS(f.degree)};
  bool ok = push_numbers(L, f.at, 2, shape) && push_numbers(L, f.normal, 2, shape) &&
            push_numbers(L, f.radius, 1, shape) && push_numbers(L, f.emission, 3, shape) &&
            push_numbers(L, f.shift, 1, shape);
  return ok ? 5 : ylmL_result(L, 0, YLM_ENOMEM, NULL);
}

/* lights_virtual_split(lights, core) -> far, near */
static int lights_virtual_split(lua_State *L) {
  ylm_error e = {0};
  ylm_light_virtual *far, *near;
  ylm_light_set **sets[2];
  ylm_light_virtual *v = lights_at(L, 1);
  sets[0] = ylmL_lights_new(L);
  sets[1] = ylmL_lights_new(L);
  ylm_status s = ylm_light_virtual_split(v, (double)luaL_checknumber(L, 2), &far, &near, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  s = ylm_light_set_virtual(far, sets[0], &e);
  if (s == YLM_OK) s = ylm_light_set_virtual(near, sets[1], &e);
  ylmL_charge(L, 2 * ylm_light_virtual_bytes(far));
  ylm_light_virtual_free(far);
  ylm_light_virtual_free(near);
  return ylmL_result(L, 2, s, &e);
}

/* The float array at `i`; raises otherwise. */
static const ylmL_array *floats(lua_State *L, int i) {
  const ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_FLOAT) luaL_argerror(L, i, "a float array expected");
  return a;
}

/* lights_virtual_near(lights, lmax, points [n][3], normals [n][3] | nil, threads, out) -> pairs. Adds to
   out, with normals [n][3] irradiance, else [n][3][(lmax+1)^2] coefficients; arrays are float. */
static int lights_virtual_near(lua_State *L) {
  ylm_error e = {0};
  const ylm_light_virtual *v = lights_at(L, 1);
  int lmax = (int)luaL_checknumber(L, 2), threads = (int)luaL_checknumber(L, 5);
  const ylmL_array *points = floats(L, 3), *out = floats(L, 6);
  const ylmL_array *normals = lua_isnil(L, 4) ? NULL : floats(L, 4);
  uint64_t pairs = 0;
  size_t n = points->count / 3, wide = normals ? 3 : 3 * YLM_LIGHT_VIRTUAL_NUMBERS(lmax);
  if (lmax < 0 || (normals && normals->count != 3 * n) || out->count != n * wide)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_status s = normals
                     ? ylm_light_virtual_near_irradiance(v, lmax, n, points->data, normals->data,
                                                         threads, NULL, out->data, &pairs, &e)
                     : ylm_light_virtual_near_value(v, lmax, n, points->data, threads, NULL,
                                                    out->data, &pairs, &e);
  ylmL_push_count(L, pairs);
  return ylmL_result(L, 1, s, &e);
}

typedef struct irradiance_form {
  ylm_light_virtual_levels o;
  int part, onto, progress; /* onto, progress: on the stack */
} irradiance_form;

enum { BOTH, NEAR, FAR };

static const ylmL_entry irradiance_entries[] = {
    YLML(irradiance_form, o.core, "core", DOUBLE),
    YLML(irradiance_form, o.voxel, "voxel", DOUBLE),
    YLML(irradiance_form, o.merge, "merge", DOUBLE),
    YLML(irradiance_form, o.lmax, "lmax", INT),
    YLML(irradiance_form, part, "part", CHOICE, .choices = ylmL_near_far_choices, .optional = true),
    YLML(irradiance_form, onto, "onto", VALUE),
    YLML(irradiance_form, o.threads, "threads", INT, .optional = true),
    YLML(irradiance_form, progress, "progress", VALUE),
    {.name = NULL}};

static void push_levels(lua_State *L, const ylm_light_virtual_levels_report *r) {
  lua_newtable(L);
  ylmL_set_count(L, "levels", (uint64_t)r->levels);
  ylmL_set_count(L, "corners", r->corners);
  ylmL_set_count(L, "cells", r->cells);
  ylmL_set_count(L, "bytes", r->bytes);
  ylmL_set_count(L, "merged", r->merged);
  ylmL_set_number(L, "cell", r->cell);
  ylmL_set_count(L, "pairs", r->pairs);
  ylmL_set_count(L, "far_pairs", r->far_pairs);
  ylmL_set_number(L, "sorting", r->seconds[0]);
  ylmL_set_number(L, "merging", r->seconds[1]);
  ylmL_set_number(L, "baking", r->seconds[2]);
  ylmL_set_number(L, "far", r->seconds[3]);
  ylmL_set_number(L, "near", r->seconds[4]);
}

/* lights_virtual_irradiance(lights, points [n][3], normals [n][3], {core, voxel, merge, lmax, part, onto [n][3],
   threads, progress}) ->
   irradiance [n][3], {levels, corners, cells, bytes, merged, cell, pairs, far_pairs, sorting, merging, baking, far, near}; arrays
   are float. */
static int lights_virtual_irradiance(lua_State *L) {
  irradiance_form f = {.part = BOTH};
  const ylm_light_virtual *v = lights_at(L, 1);
  const ylmL_array *points = floats(L, 2), *normals = floats(L, 3);
  const size_t n = points->count / 3;
  if (points->count != 3 * n || normals->count != 3 * n) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_read(L, 4, irradiance_entries, &f);
  ylm_error e = {0};
  ylmL_progress p;
  const ylmL_array *onto = lua_isnil(L, f.onto) ? NULL : floats(L, f.onto);
  if (onto && onto->count != 3 * n) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  f.o.near = f.part != FAR;
  f.o.far = f.part != NEAR;
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  if (onto)
    ylm_copy(out->data, onto->data, 3 * n * sizeof(float));
  else
    ylm_zero(out->data, 3 * n * sizeof(float));
  ylm_light_virtual_levels_report r;
  ylm_status s =
      ylm_light_virtual_irradiance(v, &f.o, n, points->data, normals->data, out->data, &r, &e);
  push_levels(L, &r);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* lights_has_virtual(lights) -> boolean */
static int lights_has_virtual(lua_State *L) {
  lua_pushboolean(L, ylm_light_set_has_virtual(ylmL_lights_check(L, 1)));
  return 1;
}

static const luaL_Reg functions[] = {{"lights_virtual", lights_virtual},
                                     {"lights_virtual_info", lights_virtual_info},
                                     {"lights_virtual_arrays", lights_virtual_arrays},
                                     {"lights_virtual_split", lights_virtual_split},
                                     {"lights_virtual_near", lights_virtual_near},
                                     {"lights_virtual_irradiance", lights_virtual_irradiance},
                                     {"lights_has_virtual", lights_has_virtual},
                                     {NULL, NULL}};

void ylmL_open_light_virtual(lua_State *L) { luaL_setfuncs(L, functions, 0); }
