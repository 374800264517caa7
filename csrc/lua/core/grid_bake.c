/* grid_bake.c - ylm.grid: baking and updating, also from light fields that are functions.
   lua/ylm/grid/bake.lua. */
#include "grid.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "ylm_light.h"

/* -- light fields written in Lua ---------------------------------------------------------- */

/*
** function(points [n][3], lmax, channels) -> value [n][channels][count], gradient [..][3],
** lambda [n] or nil: an analytic field, called on the calling thread.
*/
typedef struct lua_field {
  ylm_field base;
  lua_State *L;
  int index;   /* of the function */
  bool raised; /* its error is on the stack's top */
} lua_field;

/* Copies array `i` to `to`, which has n numbers; false if it is none or does not fit. */
static bool take(lua_State *L, int i, size_t n, ylm_dtype t, void *to) {
  ylmL_array *a = ylmL_test(L, i, YLM_ARRAY);
  if (!a || !a->data || a->count != n) return false;
  for (size_t k = 0; k < n; k++) ylm_put(t, to, k, ylmL_array_get(a, k));
  return true;
}

/* Lambda from the function (0 where it gives none), norm from the values. */
static bool take_metric(lua_State *L, int i, const ylm_field_query *q, size_t n, size_t width,
                        ylm_field_result *r) {
  bool ok = true;
  if (lua_isnil(L, i))
    memset(r->lambda, 0, n * ylm_dtype_size(q->dtype));
  else
    ok = take(L, i, n, q->dtype, r->lambda);
  for (size_t k = 0; k < n; k++) {
    double sum = 0;
    for (size_t j = 0; j < width; j++) {
      double x = ylm_get(q->dtype, r->value, k * width + j);
      sum += x * x;
    }
    ylm_put(q->dtype, r->norm, k, sqrt(sum));
  }
  return ok;
}

/* Raises where one of n times `width` numbers of a result is not finite, naming the point. */
static void check_finite(lua_State *L, const char *what, size_t n, size_t width,
                         const ylm_field_query *q, const void *points, const void *x) {
  size_t where;
  char place[96];
  if (ylm_all_finite(q->dtype, x, n * width, &where)) return;
  size_t p = 3 * (where / width);
  snprintf(place, sizeof place, "(%g, %g, %g)", ylm_get(q->dtype, points, p),
           ylm_get(q->dtype, points, p + 1), ylm_get(q->dtype, points, p + 2));
  luaL_error(L, "the light field's %s at %s is not finite, or beyond the range of %s", what, place,
             q->dtype == YLM_DOUBLE ? "double" : "float");
}

static void check_results(lua_State *L, const ylm_field_query *q, size_t n, size_t width,
                          const void *points, const ylm_field_result *r) {
  check_finite(L, "first result", n, width, q, points, r->value);
  if (q->want & YLM_WANT_GRADIENT)
    check_finite(L, "second result", n, 3 * width, q, points, r->gradient);
  if (!(q->want & YLM_WANT_METRIC)) return;
  check_finite(L, "third result", n, 1, q, points, r->lambda);
  check_finite(L, "norm", n, 1, q, points, r->norm);
}

/* The call, protected: arguments light field, query, count, points, result. */
typedef struct field_call {
  const lua_field *f;
  const ylm_field_query *q;
  size_t n;
  const void *points;
  ylm_field_result *r;
} field_call;

static int protected_call(lua_State *L) {
  const field_call *c = lua_touserdata(L, 2);
  size_t shape[2] = {c->n, 3}, count = (size_t)(c->q->lmax + 1) * (size_t)(c->q->lmax + 1);
  size_t width = count * (size_t)c->q->channels;
  lua_settop(L, 2);
  lua_pushvalue(L, 1);
  ylmL_array *p = ylmL_array_new(L, c->q->dtype, 2, shape);
  if (!p) return ylmL_no_memory(L, NULL);
  memcpy(p->data, c->points, 3 * c->n * ylm_dtype_size(c->q->dtype));
  lua_pushinteger(L, c->q->lmax);
  lua_pushinteger(L, c->q->channels);
  lua_call(L, 3, 3); /* value, gradient, lambda at 3, 4, 5 */
  if (!take(L, 3, c->n * width, c->q->dtype, c->r->value))
    return luaL_error(L, "the light field's first result must be an array [%d][%d][%d]", (int)c->n,
                      c->q->channels, (int)count);
  if (c->q->want & YLM_WANT_GRADIENT && !take(L, 4, 3 * c->n * width, c->q->dtype, c->r->gradient))
    return luaL_error(L, "the light field's second result must be an array [%d][%d][%d][3]",
                      (int)c->n, c->q->channels, (int)count);
  if (c->q->want & YLM_WANT_METRIC && !take_metric(L, 5, c->q, c->n, width, c->r))
    return luaL_error(L, "the light field's third result must be nil or an array [%d]", (int)c->n);
  check_results(L, c->q, c->n, width, c->points, c->r);
  return 0;
}

static ylm_status lua_field_evaluate(const ylm_field *base, const ylm_field_query *q, size_t n,
                                     const void *points, ylm_field_result *r, ylm_error *e) {
  lua_field *f = (lua_field *)(uintptr_t)base->self;
  lua_State *L = f->L;
  field_call c = {f, q, n, points, r};
  lua_pushcfunction(L, protected_call);
  lua_pushvalue(L, f->index);
  lua_pushlightuserdata(L, &c);
  if (lua_pcall(L, 2, 0, 0) != 0) {
    f->raised = true;
    return ylm_fail(e, YLM_ECANCELLED, "the light field raised an error");
  }
  if (r->inside) memset(r->inside, 0, n);
  r->pairs += n;
  return YLM_OK;
}

/* -- baking ---------------------------------------------------------------------------------- */

/* The source of a bake, from the arguments of grid_bake. A function as light is `own`. */
static ylm_grid_source source_of(lua_State *L, const ylm_grid_form *form, lua_field *own,
                                 ylmL_progress *progress) {
  ylm_grid_source source = ylmL_grid_source(L, progress);
  *own = (lua_field){.base = {.self = own, .evaluate = lua_field_evaluate}, .L = L, .index = 2};
  own->base.quantity = form->quantity;
  source.field = lua_isfunction(L, 2) ? &own->base : ylmL_field_check(L, 2);
  return source;
}

/*
** grid_bake(form table, object with a light field | function, lit places, seed, threads,
**           max_points, progress) -> grid; a dynamic grid is baked from lights
**
** Lit places: points [n][3], a list of meshes, or nil.
*/
static int grid_bake(lua_State *L) {
  lua_settop(L, 7);
  luaL_checkstack(L, 20, "grid_bake");
  ylm_grid_form form = ylmL_grid_form(L, 1);
  ylmL_progress progress;
  lua_field own;
  ylm_grid_source source = source_of(L, &form, &own, &progress);
  if (form.dynamic) source.lights = ylmL_lights_check(L, 2);
  ylm_grid **g = ylmL_grid_new(L);
  ylm_error e = {0};
  ylm_status s = ylm_grid_bake(&form, &source, g, &e);
  if (own.raised) return lua_error(L);
  if (s == YLM_OK) ylmL_charge(L, ylm_grid_look(*g)->stats->bytes);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

static const ylmL_entry bricks_entries[] = {
    YLML(ylm_grid_bricks, folder, "folder", STRING),
    YLML(ylm_grid_bricks, level, "level", INT, .optional = true),
    YLML(ylm_grid_bricks, points, "points", COUNT, .optional = true),
    YLML(ylm_grid_bricks, brick_seconds, "brick_seconds", DOUBLE, .optional = true),
    YLML(ylm_grid_bricks, fresh, "fresh", BOOL),
    YLML(ylm_grid_bricks, seconds, "seconds", DOUBLE, .optional = true),
    {.name = NULL}};

/* grid_bake_bricks(as grid_bake; the form has bricks = {folder, level, points, brick_seconds, fresh, seconds}) -> true */
static int grid_bake_bricks(lua_State *L) {
  enum { BRICKS = 8 };
  lua_settop(L, 7);
  luaL_checktype(L, 1, LUA_TTABLE);
  lua_getfield(L, 1, "bricks");
  luaL_checkstack(L, 20, "grid_bake_bricks");
  ylm_grid_bricks how = {.alone = !ylmL_test(L, 2, YLM_LIGHTS) && !ylmL_light_cut(L, 2)};
  ylmL_read(L, BRICKS, bricks_entries, &how);
  ylm_grid_form form = ylmL_grid_form(L, 1);
  ylmL_progress progress;
  lua_field own;
  ylm_grid_source source = source_of(L, &form, &own, &progress);
  ylm_error e = {0};
  ylm_status s = ylm_grid_bake_bricks(&form, &source, &how, &e);
  if (own.raised) return lua_error(L);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* grid_update(grid, lights, tolerance or -1, threads, progress, everywhere) -> what it did */
static int grid_update(lua_State *L) {
  lua_settop(L, 6);
  ylm_grid *g = ylmL_grid_check(L, 1);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylmL_progress progress;
  ylm_error e = {0};
  ylm_grid_change change = {.lights = ylmL_lights_check(L, 2),
                            .field = ylmL_field_check(L, 2),
                            .tolerance = luaL_checknumber(L, 3),
                            .everywhere = lua_toboolean(L, 6),
                            .threads = (int)luaL_checknumber(L, 4),
                            .progress = ylmL_progress_begin(L, 5, &progress)};
  ylm_status s = ylm_grid_update(g, &change, &e);
  const ylm_grid_contents *v = ylm_grid_look(g);
  if (s == YLM_OK) ylmL_grid_push_update(L, &v->form, v->stats);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* grid_refresh(grid, object with a light field | function, quantity of the function, threads,
   progress) -> points evaluated, seconds */
static int grid_refresh(lua_State *L) {
  lua_settop(L, 5);
  luaL_checkstack(L, 20, "grid_refresh");
  ylm_grid *g = ylmL_grid_check(L, 1);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylmL_progress progress;
  lua_field own = {.base = {.self = &own, .evaluate = lua_field_evaluate}, .L = L, .index = 2};
  own.base.quantity = ylmL_grid_quantity(L, 3);
  const ylm_field *field = lua_isfunction(L, 2) ? &own.base : ylmL_field_check(L, 2);
  if (!lua_isfunction(L, 2) && field->self == g) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  ylm_error e = {0};
  double start = ylm_seconds();
  ylm_status s = ylm_grid_refresh(g, field, (int)luaL_checknumber(L, 4),
                                  ylmL_progress_begin(L, 5, &progress), &e);
  if (own.raised) return lua_error(L);
  ylmL_push_count(L, ylm_grid_look(g)->evaluated);
  lua_pushnumber(L, ylm_seconds() - start);
  return ylmL_result_progress(L, 2, s, &e, &progress);
}

/* grid_split(rows [n][6]) -> points [n][3], normals [n][3] of length 1, of the rows' type; the
   number of the first row without a normal, if there is one */
static int grid_split(lua_State *L) {
  const ylmL_array *a = ylmL_array_check(L, 1);
  size_t n = a->count / 6, shape[2] = {n, 3}, bad = 0;
  ylmL_array *p = ylmL_array_new(L, a->dtype, 2, shape);
  ylmL_array *normal = p ? ylmL_array_new(L, a->dtype, 2, shape) : NULL;
  if (!normal) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++) {
    double x[6], sum = 0;
    for (size_t k = 0; k < 6; k++) x[k] = ylmL_array_get(a, 6 * i + k);
    for (size_t k = 3; k < 6; k++) sum += x[k] * x[k];
    if (!(sum > 0 && isfinite(sum)) && !bad) bad = i + 1;
    for (size_t k = 0; k < 3; k++) {
      ylm_put(a->dtype, p->data, 3 * i + k, x[k]);
      ylm_put(a->dtype, normal->data, 3 * i + k, x[k + 3] / sqrt(sum));
    }
  }
  if (bad) ylmL_push_count(L, bad);
  return bad ? 3 : 2;
}

/* grid_unit(normals [n][3]) -> float [n][3] of length 1, or 0 where theirs is; the number of the first row that is not finite,
   if there is one */
static int grid_unit(lua_State *L) {
  const ylmL_array *a = ylmL_array_check(L, 1);
  size_t n = a->count / 3, bad = 0;
  ylmL_array *unit = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  if (!unit) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  float *out = unit->data;
  for (size_t i = 0; i < n; i++) {
    double x[3], sum = 0;
    for (size_t k = 0; k < 3; k++) x[k] = ylmL_array_get(a, 3 * i + k);
    for (size_t k = 0; k < 3; k++) sum += x[k] * x[k];
    if (!isfinite(sum) && !bad) bad = i + 1;
    for (size_t k = 0; k < 3; k++) out[3 * i + k] = sum > 0 ? (float)(x[k] / sqrt(sum)) : 0;
  }
  if (bad) ylmL_push_count(L, bad);
  return bad ? 2 : 1;
}

/* grid_aside(points [n][3], normals [n][3], distance) -> [n][3] so far off, of the points' type */
static int grid_aside(lua_State *L) {
  const ylmL_array *p = ylmL_array_check(L, 1), *normal = ylmL_array_check(L, 2);
  double distance = luaL_checknumber(L, 3);
  if (p->count != normal->count) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_array_new(L, p->dtype, 2, (size_t[]){p->count / 3, 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < p->count; i++)
    ylm_put(p->dtype, out->data, i, ylmL_array_get(p, i) + distance * ylmL_array_get(normal, i));
  return 1;
}

/* grid_bounds(points [n][3]) -> lowest {x, y, z}, highest */
static int grid_bounds(lua_State *L) {
  const ylmL_array *p = ylmL_array_check(L, 1);
  double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < p->count; i++) {
    double x = ylmL_array_get(p, i);
    if (x < lo[i % 3]) lo[i % 3] = x;
    if (x > hi[i % 3]) hi[i % 3] = x;
  }
  for (int k = 0; k < 2; k++) {
    lua_newtable(L);
    for (int a = 0; a < 3; a++) {
      lua_pushnumber(L, k ? hi[a] : lo[a]);
      lua_rawseti(L, -2, a + 1);
    }
  }
  return 2;
}

/* grid_surface_points(list of meshes, {lowest x, y, z, highest}, seed, n) -> positions [n][3],
   normals, area within the bounds: what held-out points of surfaces are drawn from */
static int grid_surface_points(lua_State *L) {
  double bounds[6];
  size_t meshes, shape[2] = {(size_t)luaL_checknumber(L, 4), 3};
  lua_settop(L, 4);
  for (int i = 0; i < 6; i++) {
    lua_rawgeti(L, 2, i + 1);
    bounds[i] = luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  const ylm_grid_mesh *mesh = ylmL_grid_meshes(L, 1, &meshes);
  ylm_grid_surface *s;
  ylm_error e = {0};
  ylmL_array *p = ylmL_array_new(L, YLM_DOUBLE, 2, shape);
  ylmL_array *normal = p ? ylmL_array_new(L, YLM_DOUBLE, 2, shape) : NULL;
  if (!normal) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status status = ylm_grid_surface_create(meshes, mesh, bounds, 0, &s, &e);
  if (status != YLM_OK) return ylmL_result(L, 0, status, &e);
  for (size_t k = 0; k < shape[0]; k++)
    ylm_grid_surface_draw(s, (uint64_t)lua_tonumber(L, 3), k, shape[0], (double *)p->data + 3 * k,
                          (double *)normal->data + 3 * k);
  lua_pushnumber(L, ylm_grid_surface_area(s));
  ylm_grid_surface_free(s);
  return 3;
}

static const luaL_Reg functions[] = {{"grid_bake", grid_bake},
                                     {"grid_surface_points", grid_surface_points},
                                     {"grid_bake_bricks", grid_bake_bricks},
                                     {"grid_update", grid_update},
                                     {"grid_refresh", grid_refresh},
                                     {"grid_split", grid_split},
                                     {"grid_unit", grid_unit},
                                     {"grid_aside", grid_aside},
                                     {"grid_bounds", grid_bounds},
                                     {NULL, NULL}};

void ylmL_open_grid_bake(lua_State *L) { luaL_setfuncs(L, functions, 0); }
