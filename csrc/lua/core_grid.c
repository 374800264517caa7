/* core_grid.c - ylm.grid: baking, sampling, looking inside, files. Methods are in lua/ylm/grid.lua.
 */
#include "binding_grid.h"

#include <math.h>
#include <string.h>

#define GRID YLM_GRID_TYPE

static ylm_grid *check_grid(lua_State *L, int i) {
  ylm_grid **g = ylmL_check(L, i, GRID);
  if (!*g) luaL_argerror(L, i, "the grid has been closed");
  if (ylm_grid_updating(*g)) luaL_argerror(L, i, "the grid is being updated");
  return *g;
}

static const ylm_field *field_of(void *object) {
  ylm_grid **g = object;
  return *g && !ylm_grid_updating(*g) ? ylm_grid_field(*g) : NULL;
}

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
  for (size_t k = 0; k < n; k++) {
    double x = a->dtype == YLM_DOUBLE ? ((double *)a->data)[k] : (double)((float *)a->data)[k];
    if (t == YLM_DOUBLE)
      ((double *)to)[k] = x;
    else
      ((float *)to)[k] = (float)x;
  }
  return true;
}

static void put(ylm_dtype t, void *to, size_t i, double x) {
  if (t == YLM_DOUBLE)
    ((double *)to)[i] = x;
  else
    ((float *)to)[i] = (float)x;
}

static double get(ylm_dtype t, const void *from, size_t i) {
  return t == YLM_DOUBLE ? ((const double *)from)[i] : (double)((const float *)from)[i];
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
      double x = get(q->dtype, r->value, k * width + j);
      sum += x * x;
    }
    put(q->dtype, r->norm, k, sqrt(sum));
  }
  return ok;
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
  if (!p) return luaL_error(L, "memory ran out");
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

/* The sphere lights at `i`, or NULL. */
static const ylm_lights *test_lights(lua_State *L, int i) {
  ylm_lights **l = ylmL_test(L, i, "ylm.lights");
  return l ? *l : NULL;
}

/*
** grid_bake(form table, object with a light field | function, occupied [n][3] | nil, seed, threads,
**           max_points, progress) -> grid
*/
static int grid_bake(lua_State *L) {
  lua_settop(L, 7);
  luaL_checkstack(L, 20, "grid_bake");
  ylm_grid_form form = ylmL_grid_form(L, 1);
  ylmL_progress progress;
  lua_field own = {.base = {.self = &own, .evaluate = lua_field_evaluate}, .L = L, .index = 2};
  ylm_grid_source source = ylmL_grid_source(L, &progress);
  source.field = lua_isfunction(L, 2) ? &own.base : ylmL_field_check(L, 2);
  source.lights = test_lights(L, 2);
  ylm_grid **g = ylmL_grid_new(L);
  ylm_error e = {0};
  ylm_status s = ylm_grid_bake(&form, &source, g, &e);
  if (own.raised) return lua_error(L);
  if (s == YLM_OK) ylmL_charge(L, ylm_grid_look(*g)->stats->bytes);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

static void set_boolean(lua_State *L, const char *name, bool x) {
  lua_pushboolean(L, x);
  lua_setfield(L, -2, name);
}

/* What the last update did, as a table. */
static void push_update(lua_State *L, const ylm_grid_update_stats *u) {
  lua_newtable(L);
#define COUNT(name) ylmL_set_count(L, #name, u->name)
  COUNT(updates);
  COUNT(lights);
  COUNT(points);
  COUNT(exact);
  COUNT(skipped);
  COUNT(added);
  COUNT(removed);
  COUNT(pairs);
  COUNT(verified);
#undef COUNT
  ylmL_set_number(L, "seconds", u->seconds);
  ylmL_set_number(L, "field_seconds", u->field_seconds);
  ylmL_set_number(L, "tree_seconds", u->tree_seconds);
  if (u->verified) {
    ylmL_set_number(L, "error", u->error);
    set_boolean(L, "met", u->met);
  }
  set_boolean(L, "rebaked", u->rebaked);
}

/* grid_update(grid, lights, tolerance or -1, threads, progress, everywhere) -> what it did */
static int grid_update(lua_State *L) {
  lua_settop(L, 6);
  ylm_grid *g = check_grid(L, 1);
  ylmL_progress progress;
  ylm_error e = {0};
  ylm_grid_change change = {.lights = test_lights(L, 2),
                            .field = ylmL_field_check(L, 2),
                            .tolerance = luaL_checknumber(L, 3),
                            .everywhere = lua_toboolean(L, 6),
                            .threads = (int)luaL_checknumber(L, 4),
                            .progress = ylmL_progress_begin(L, 5, &progress)};
  if (!change.lights) return luaL_argerror(L, 2, "lights expected");
  ylm_status s = ylm_grid_update(g, &change, &e);
  if (s == YLM_OK) push_update(L, &ylm_grid_look(g)->stats->update);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* grid_bounds(points [n][3]) -> lowest {x, y, z}, highest */
static int grid_bounds(lua_State *L) {
  const ylmL_array *p = ylmL_array_check(L, 1);
  double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < p->count; i++) {
    double x = get(p->dtype, p->data, i);
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

/* -- sampling --------------------------------------------------------------------------------- */

/*
** grid_sample(grid, points [n][3], interpolation number, derivatives, nan outside, dtype, threads,
**             progress, out value | nil, out gradient | nil) -> value, gradient | nil, outside,
*unbaked, seconds
*/
static int grid_sample(lua_State *L) {
  static const char *const dtypes[] = {"float", "double", NULL};
  lua_settop(L, 10);
  const ylm_grid_view *v = ylm_grid_look(check_grid(L, 1));
  ylmL_array *points = ylmL_array_check(L, 2), *value, *gradient = NULL;
  ylmL_progress progress;
  ylm_grid_query q = {.interpolation = (ylm_grid_interpolation)(int)luaL_checknumber(L, 3),
                      .nan_outside = lua_toboolean(L, 5),
                      .point_dtype = points->dtype,
                      .dtype = (ylm_dtype)luaL_checkoption(L, 6, NULL, dtypes),
                      .threads = (int)luaL_checknumber(L, 7),
                      .progress = ylmL_progress_begin(L, 8, &progress)};
  size_t shape[4] = {points->count / 3, (size_t)v->form.channels, (size_t)v->count, 3};
  ylm_grid_report report = {0};
  ylm_error e = {0};
  ylm_status s = YLM_OK;
  value = ylmL_array_result(L, 9, q.dtype, 3, shape, &s);
  if (luaL_checknumber(L, 4) > 0)
    gradient = ylmL_array_result(L, 10, q.dtype, 4, shape, &s);
  else
    lua_pushnil(L);
  if (s == YLM_OK)
    s = ylm_grid_sample(check_grid(L, 1), &q, shape[0], points->data, value->data,
                        gradient ? gradient->data : NULL, &report, &e);
  if (s == YLM_OK) {
    ylmL_push_count(L, report.outside);
    ylmL_push_count(L, report.unbaked);
    lua_pushnumber(L, report.seconds);
  }
  return ylmL_result_progress(L, 5, s, &e, &progress);
}

/* -- looking inside ------------------------------------------------------------------------------
 */

/* grid_stats(grid) -> table of numbers and booleans */
static int grid_stats(lua_State *L) {
  const ylm_grid_view *v = ylm_grid_look(check_grid(L, 1));
  const ylm_grid_stats *s = v->stats;
  lua_newtable(L);
#define COUNT(name) ylmL_set_count(L, #name, s->name)
  COUNT(points);
  COUNT(tested);
  COUNT(interpolated);
  COUNT(cells);
  COUNT(leaves);
  COUNT(occupied);
  COUNT(continuity);
  COUNT(levels);
  COUNT(pairs);
  COUNT(invalid);
  COUNT(outside);
  COUNT(bytes);
#undef COUNT
  ylmL_set_number(L, "seconds", s->seconds);
  ylmL_set_number(L, "field_seconds", s->field_seconds);
  ylmL_set_number(L, "verify_seconds", s->verify_seconds);
  ylmL_set_number(L, "occupancy_seconds", s->occupancy_seconds);
  ylmL_set_number(L, "lattice_seconds", s->lattice_seconds);
  ylmL_set_number(L, "residual_seconds", s->residual_seconds);
  ylmL_set_number(L, "continuity_seconds", s->continuity_seconds);
  if (s->update.updates) {
    push_update(L, &s->update);
    lua_setfield(L, -2, "update");
  }
  if (v->form.kind == YLM_GRID_UNIFORM) return 1;
  if (!(v->form.tolerance > 0)) {
    ylmL_set_number(L, "threshold", v->form.threshold);
    return 1;
  }
  ylmL_set_number(L, "tolerance", v->form.tolerance);
  ylmL_set_count(L, "verified", s->verified);
  ylmL_set_count(L, "rounds", s->rounds);
  ylmL_set_number(L, "error", s->error);
  ylmL_set_number(L, "largest_error", s->largest_error);
  set_boolean(L, "met", s->met);
  set_boolean(L, "limited", s->limited);
  return 1;
}

/* grid_form(grid) -> table: kind, lmax, channels, bounds, resolution, depth, metric, ... */
static int grid_form(lua_State *L) {
  const ylm_grid_view *view = ylm_grid_look(check_grid(L, 1));
  const ylm_grid_form *f = &view->form;
  lua_newtable(L);
  bool adaptive = f->kind == YLM_GRID_ADAPTIVE;
  lua_pushstring(L, adaptive ? "adaptive" : "uniform");
  lua_setfield(L, -2, "kind");
  ylmL_set_count(L, "lmax", f->lmax);
  ylmL_set_count(L, "channels", f->channels);
  static const char *const of_what[] = {"none", "luminance", "", "rgb"};
  lua_pushstring(L, of_what[f->metric_channels & 3]);
  lua_setfield(L, -2, "metric_channels");
  lua_newtable(L);
  for (int i = 0; i < 2; i++) {
    lua_newtable(L);
    for (int a = 0; a < 3; a++) {
      lua_pushnumber(L, f->bounds[3 * i + a]);
      lua_rawseti(L, -2, a + 1);
    }
    lua_rawseti(L, -2, i + 1);
  }
  lua_setfield(L, -2, "bounds");
  set_boolean(L, "dynamic", f->dynamic);
  lua_newtable(L);
  for (int a = 0; a < 3; a++) {
    ylmL_push_count(L, (uint64_t)view->resolution[a]);
    lua_rawseti(L, -2, a + 1);
  }
  lua_setfield(L, -2, "resolution");
  if (adaptive) {
    ylmL_set_count(L, "depth", f->depth);
    set_boolean(L, "continuous", f->continuous);
    lua_pushstring(L, f->metric == YLM_GRID_RELATIVE ? "relative" : "absolute");
    lua_setfield(L, -2, "metric");
    ylmL_set_number(L, f->tolerance > 0 ? "tolerance" : "threshold",
                    f->tolerance > 0 ? f->tolerance : f->threshold);
  }
  return 1;
}

/* A new array as field `name` of the table on top; raises without memory. */
static void *set_array(lua_State *L, const char *name, ylm_dtype t, int axes, const size_t *shape) {
  ylmL_array *a = ylmL_array_new(L, t, axes, shape);
  if (!a) luaL_error(L, "memory ran out");
  lua_setfield(L, -2, name);
  return a->data;
}

/* grid_points(grid) -> table of arrays, one row per point: evaluated ones first */
static int grid_points(lua_State *L) {
  const ylm_grid *g = check_grid(L, 1);
  const ylm_grid_view *v = ylm_grid_look(g);
  size_t n = v->points, c = (size_t)v->form.channels, k = (size_t)v->count, w = c * k;
  lua_newtable(L);
  double *position = set_array(L, "position", YLM_DOUBLE, 2, (size_t[]){n, 3});
  float *value = set_array(L, "value", YLM_FLOAT, 3, (size_t[]){n, c, k});
  float *gradient = set_array(L, "gradient", YLM_FLOAT, 4, (size_t[]){n, c, k, 3});
  float *lambda = set_array(L, "lambda", YLM_FLOAT, 1, &n);
  float *norm = set_array(L, "norm", YLM_FLOAT, 1, &n);
  float *invalid = set_array(L, "invalid", YLM_FLOAT, 1, &n);
  float *interpolated = set_array(L, "interpolated", YLM_FLOAT, 1, &n);
  for (size_t i = 0; i < n; i++) {
    const float *row = v->data + 4 * i * v->stride;
    ylm_grid_position(g, v->lattice + 3 * i, position + 3 * i);
    memcpy(value + i * w, row, w * sizeof *value);
    for (size_t j = 0; j < w; j++)
      for (size_t a = 0; a < 3; a++) gradient[3 * (i * w + j) + a] = row[(a + 1) * v->stride + j];
    lambda[i] = v->lambda[i];
    norm[i] = v->norm[i];
    invalid[i] = (v->flags[i] & YLM_GRID_POINT_INVALID) != 0;
    interpolated[i] = (v->flags[i] & YLM_GRID_POINT_INTERPOLATED) != 0;
  }
  return 1;
}

/* grid_cells(grid, with added ones) -> table of arrays, one row per cell */
static int grid_cells(lua_State *L) {
  static const struct {
    const char *name;
    int flag;
  } flags[] = {{"leaf", YLM_GRID_LEAF},
               {"occupied", YLM_GRID_OCCUPIED},
               {"baked", YLM_GRID_BAKED},
               {"crossed", YLM_GRID_CROSSED},
               {"added", YLM_GRID_ADDED}};
  const ylm_grid *g = check_grid(L, 1);
  const ylm_grid_view *v = ylm_grid_look(g);
  size_t n = lua_toboolean(L, 2) ? v->cells : v->octree_cells;
  lua_newtable(L);
  double *origin = set_array(L, "origin", YLM_DOUBLE, 2, (size_t[]){n, 3});
  double *size = set_array(L, "size", YLM_DOUBLE, 2, (size_t[]){n, 3});
  float *level = set_array(L, "level", YLM_FLOAT, 1, &n);
  float *error = set_array(L, "error", YLM_FLOAT, 1, &n);
  float *residual = set_array(L, "residual", YLM_FLOAT, 1, &n);
  double *corners = set_array(L, "corners", YLM_DOUBLE, 2, (size_t[]){n, 8});
  float *flag[5];
  for (int k = 0; k < 5; k++) flag[k] = set_array(L, flags[k].name, YLM_FLOAT, 1, &n);
  for (size_t i = 0; i < n; i++) {
    const ylm_grid_cell *c = &v->cell[i];
    double box[6];
    ylm_grid_box(g, i, box);
    for (int a = 0; a < 3; a++) {
      origin[3 * i + (size_t)a] = box[a];
      size[3 * i + (size_t)a] = box[a + 3] - box[a];
    }
    for (size_t k = 0; k < 8; k++)
      corners[8 * i + k] = c->corner[k] == YLM_GRID_NONE ? 0 : (double)c->corner[k] + 1;
    level[i] = c->level;
    error[i] = c->error;
    residual[i] = c->residual;
    for (int k = 0; k < 5; k++) flag[k][i] = (c->flags & flags[k].flag) != 0;
  }
  return 1;
}

/* grid_locate(grid, x, y, z, finest) -> one-based cell or nil, table of what it knows, outside */
static int grid_locate(lua_State *L) {
  const ylm_grid *g = check_grid(L, 1);
  const ylm_grid_view *v = ylm_grid_look(g);
  double p[3] = {luaL_checknumber(L, 2), luaL_checknumber(L, 3), luaL_checknumber(L, 4)}, box[6];
  bool outside;
  uint32_t i = ylm_grid_locate(g, p, lua_toboolean(L, 5), &outside);
  if (i == YLM_GRID_NONE) return 0;
  const ylm_grid_cell *c = &v->cell[i];
  ylm_grid_box(g, i, box);
  lua_newtable(L);
  ylmL_set_count(L, "index", i + 1);
  ylmL_set_count(L, "level", c->level);
  if (!isnan(c->error)) ylmL_set_number(L, "error", (double)c->error);
  if (!isnan(c->residual)) ylmL_set_number(L, "residual", (double)c->residual);
  set_boolean(L, "leaf", c->flags & YLM_GRID_LEAF);
  set_boolean(L, "occupied", c->flags & YLM_GRID_OCCUPIED);
  set_boolean(L, "baked", c->flags & YLM_GRID_BAKED);
  set_boolean(L, "crossed", c->flags & YLM_GRID_CROSSED);
  set_boolean(L, "outside", outside);
  lua_newtable(L);
  lua_newtable(L);
  lua_newtable(L);
  for (int a = 0; a < 3; a++) {
    lua_pushnumber(L, box[a]);
    lua_rawseti(L, -4, a + 1);
    lua_pushnumber(L, box[a + 3] - box[a]);
    lua_rawseti(L, -3, a + 1);
  }
  for (int k = 0; k < 8; k++) {
    ylmL_push_count(L, c->corner[k] == YLM_GRID_NONE ? 0 : (uint64_t)c->corner[k] + 1);
    lua_rawseti(L, -2, k + 1);
  }
  lua_setfield(L, -4, "corners");
  lua_setfield(L, -3, "size");
  lua_setfield(L, -2, "origin");
  return 1;
}

/* -- files ----------------------------------------------------------------------------------------
 */

static int grid_write(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = ylm_grid_write(check_grid(L, 1), luaL_checkstring(L, 2), lua_toboolean(L, 3), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static int grid_read(lua_State *L) {
  ylm_error e = {0};
  ylm_grid **g = ylmL_grid_new(L);
  ylm_status s = ylm_grid_read(luaL_checkstring(L, 1), g, &e);
  if (s == YLM_OK) ylmL_charge(L, ylm_grid_look(*g)->stats->bytes);
  return ylmL_result(L, 1, s, &e);
}

/* grid_encode(grid, swapped) -> the bytes of the file */
static int grid_encode(lua_State *L) {
  ylm_error e = {0};
  unsigned char *data = NULL;
  size_t size = 0;
  ylm_status s = ylm_grid_encode(check_grid(L, 1), lua_toboolean(L, 2), &data, &size, &e);
  if (s == YLM_OK) lua_pushlstring(L, (const char *)data, size);
  ylm_free(data);
  return ylmL_result(L, 1, s, &e);
}

/* grid_decode(bytes) -> grid */
static int grid_decode(lua_State *L) {
  ylm_error e = {0};
  size_t size;
  const char *data = luaL_checklstring(L, 1, &size);
  ylm_grid **g = ylmL_grid_new(L);
  return ylmL_result(L, 1, ylm_grid_decode((const unsigned char *)data, size, "grid", g, &e), &e);
}

/* grid_refuses(bytes) -> how many of all single-bit flips and truncations are accepted (0 is right)
 */
static int grid_accepted_damage(lua_State *L) {
  ylm_error e = {0};
  size_t size, accepted = 0;
  const char *data = luaL_checklstring(L, 1, &size);
  unsigned char *copy = lua_newuserdata(L, size + 1);
  memcpy(copy, data, size);
  ylm_grid *g = NULL;
  for (size_t bit = 0; bit < 8 * size; bit++) {
    copy[bit >> 3] ^= (unsigned char)(1u << (bit & 7));
    accepted += ylm_grid_decode(copy, size, "grid", &g, &e) == YLM_OK;
    ylm_grid_free(g);
    copy[bit >> 3] ^= (unsigned char)(1u << (bit & 7));
  }
  for (size_t n = 0; n < size; n++) {
    accepted += ylm_grid_decode(copy, n, "grid", &g, &e) == YLM_OK;
    ylm_grid_free(g);
  }
  lua_pushnumber(L, (lua_Number)accepted);
  return 1;
}

/* grid_is_open(value) -> true for a grid that has not been closed, false for a closed one, else
   nil; whether it is being updated */
static int grid_is_open(lua_State *L) {
  ylm_grid **g = ylmL_test(L, 1, GRID);
  if (!g) return 0;
  lua_pushboolean(L, *g != NULL);
  lua_pushboolean(L, *g && ylm_grid_updating(*g));
  return 2;
}

static int grid_close(lua_State *L) {
  ylm_grid **g = ylmL_check(L, 1, GRID);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_grid_free(*g);
  *g = NULL;
  return 0;
}

static const luaL_Reg functions[] = {{"grid_bake", grid_bake},
                                     {"grid_update", grid_update},
                                     {"grid_bounds", grid_bounds},
                                     {"grid_sample", grid_sample},
                                     {"grid_stats", grid_stats},
                                     {"grid_form", grid_form},
                                     {"grid_points", grid_points},
                                     {"grid_cells", grid_cells},
                                     {"grid_locate", grid_locate},
                                     {"grid_write", grid_write},
                                     {"grid_read", grid_read},
                                     {"grid_encode", grid_encode},
                                     {"grid_decode", grid_decode},
                                     {"grid_accepted_damage", grid_accepted_damage},
                                     {"grid_is_open", grid_is_open},
                                     {"grid_close", grid_close},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", grid_close}, {NULL, NULL}};

void ylmL_open_grid(lua_State *L) {
  ylmL_type(L, GRID, methods);
  ylmL_type_has_field(L, field_of);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
