/* grid_look.c - ylm.grid: what a grid was described with, what was done, its points and cells.
   lua/ylm/grid/look.lua. */
#include "grid.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The verdict about a promised tolerance, into the table on top. */
static void set_promise(lua_State *L, const ylm_grid_stats *s) {
  ylmL_set_count(L, "verified", s->verified);
  ylmL_set_number(L, "error", s->error);
  if (s->verified && s->confidence > 0) {
    ylmL_set_count(L, "failed", s->failed);
  }
  if (s->confidence > 0) ylmL_set_number(L, "confidence", s->confidence);
  ylmL_set_boolean(L, "met", s->met);
  ylmL_set_boolean(L, "limited", s->limited);
}

void ylmL_grid_push_update(lua_State *L, const ylm_grid_form *f, const ylm_grid_stats *s) {
  const ylm_grid_update_stats *u = &s->update;
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
#undef COUNT
  ylmL_set_number(L, "seconds", u->seconds);
  ylmL_set_number(L, "field_seconds", u->field_seconds);
  ylmL_set_number(L, "tree_seconds", u->tree_seconds);
  if (f->kind == YLM_GRID_ADAPTIVE && f->tolerance > 0) set_promise(L, s);
  ylmL_set_boolean(L, "rebaked", u->rebaked);
}

void ylmL_grid_push_stats(lua_State *L, const ylm_grid_form *f, const ylm_grid_stats *s) {
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
  if (f->sides) {
    COUNT(crossed_leaves);
    COUNT(parts);
    COUNT(ghosts);
    COUNT(joined);
    ylmL_set_boolean(L, "spent", s->spent);
  }
#undef COUNT
#define TIME(name)                                                                                 \
  if (!isnan(s->name)) ylmL_set_number(L, #name, s->name)
  TIME(seconds);
  TIME(field_seconds);
  TIME(verify_seconds);
  TIME(occupancy_seconds);
  TIME(lattice_seconds);
  TIME(residual_seconds);
  TIME(continuity_seconds);
#undef TIME
  if (s->update.updates) {
    ylmL_grid_push_update(L, f, s);
    lua_setfield(L, -2, "update");
  }
  if (f->kind == YLM_GRID_UNIFORM) return;
  if (!(f->tolerance > 0)) {
    ylmL_set_number(L, "threshold", f->threshold);
    return;
  }
  ylmL_set_number(L, "tolerance", f->tolerance);
  lua_pushstring(L, f->measure == YLM_GRID_IRRADIANCE ? "irradiance" : "coefficients");
  lua_setfield(L, -2, "measure");
  ylmL_set_count(L, "rounds", s->rounds);
  ylmL_set_number(L, "largest_error", s->largest_error);
  set_promise(L, s);
}

/* grid_stats(grid) -> table of numbers and booleans */
static int grid_stats(lua_State *L) {
  const ylm_grid_contents *v = ylm_grid_look(ylmL_grid_check(L, 1));
  ylmL_grid_push_stats(L, &v->form, v->stats);
  return 1;
}

static void push_body(lua_State *L, const ylm_grid_body *b) {
  lua_newtable(L);
  lua_newtable(L);
  for (int a = 0; a < 3; a++) {
    lua_pushnumber(L, b->at[a]);
    lua_rawseti(L, -2, a + 1);
  }
  lua_setfield(L, -2, "at");
  ylmL_set_number(L, "radius", b->radius);
  ylmL_set_number(L, "area", b->area);
}

static void set_print(lua_State *L, const char *name, uint64_t print) {
  char text[17];
  snprintf(text, sizeof text, "%016llx", (unsigned long long)print);
  lua_pushstring(L, text);
  lua_setfield(L, -2, name);
}

/* The fingerprints that are known, 16 digits each. */
static void push_prints(lua_State *L, const ylm_grid_prints *p) {
  lua_newtable(L);
  if (p->known & YLM_GRID_PRINT_GEOMETRY) set_print(L, "geometry", p->geometry);
  if (p->known & YLM_GRID_PRINT_MATERIALS) set_print(L, "materials", p->materials);
  if (p->known & YLM_GRID_PRINT_LIGHTS) set_print(L, "lights", p->lights);
}

void ylmL_grid_push_form(lua_State *L, const ylm_grid_form *f) {
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
  ylmL_set_boolean(L, "dynamic", f->dynamic);
  lua_pushstring(L, ylm_quantity_name(f->quantity));
  lua_setfield(L, -2, "quantity");
  ylmL_set_boolean(L, "sides", f->sides);
  if (f->floor > 0) ylmL_set_number(L, "floor", f->floor);
  if (f->body.radius > 0) {
    push_body(L, &f->body);
    lua_setfield(L, -2, "body");
  }
  if (f->prints.known) {
    push_prints(L, &f->prints);
    lua_setfield(L, -2, "prints");
  }
  lua_newtable(L);
  for (int a = 0; a < 3; a++) {
    ylmL_push_count(L, adaptive ? (uint64_t)1 << f->depth : (uint64_t)f->cells[a]);
    lua_rawseti(L, -2, a + 1);
  }
  lua_setfield(L, -2, "resolution");
  if (adaptive) {
    ylmL_set_count(L, "depth", f->depth);
    ylmL_set_boolean(L, "continuous", f->continuous);
    lua_pushstring(L, f->metric == YLM_GRID_RELATIVE ? "relative" : "absolute");
    lua_setfield(L, -2, "metric");
    ylmL_set_number(L, f->tolerance > 0 ? "tolerance" : "threshold",
                    f->tolerance > 0 ? f->tolerance : f->threshold);
    if (f->tolerance > 0) {
      lua_pushstring(L, f->measure == YLM_GRID_IRRADIANCE ? "irradiance" : "coefficients");
      lua_setfield(L, -2, "measure");
    }
  }
}

/* grid_form(grid) -> table: kind, lmax, channels, bounds, resolution, depth, metric, ... */
static int grid_form(lua_State *L) {
  ylmL_grid_push_form(L, &ylm_grid_look(ylmL_grid_check(L, 1))->form);
  return 1;
}

/* A new array as field `name` of the table on top; raises without memory. */
static void *set_array(lua_State *L, const char *name, ylm_dtype t, int axes, const size_t *shape) {
  ylmL_array *a = ylmL_array_new(L, t, axes, shape);
  if (!a) ylmL_no_memory(L, NULL);
  lua_setfield(L, -2, name);
  return a->data;
}

/* The validity of a point; of an interpolated one trilinear between the corners that it is from. */
static double validity_of(const ylm_grid_contents *v, size_t i) {
  double sum = 0;
  if (i < v->evaluated)
    return v->validity ? (double)v->validity[i] : !(v->flags[i] & YLM_GRID_POINT_INVALID);
  if (!v->birth) return 1;
  ylm_grid_birth b = v->birth[i - v->evaluated];
  uint32_t place[3] = {b.place % 3, b.place / 3 % 3, b.place / 9};
  for (int k = 0; k < 8; k++) {
    double w = 1;
    for (int a = 0; a < 3; a++) w *= 0.5 * (k >> a & 1 ? place[a] : 2 - place[a]);
    if (w > 0) sum += w * validity_of(v, v->cell[b.cell].corner[k]);
  }
  return sum;
}

/* grid_points(grid) -> table of arrays, one row per point: evaluated ones first */
static int grid_points(lua_State *L) {
  const ylm_grid *g = ylmL_grid_check(L, 1);
  const ylm_grid_contents *v = ylm_grid_look(g);
  size_t n = v->points, c = (size_t)v->form.channels, k = (size_t)v->count, w = c * k;
  lua_newtable(L);
  double *position = set_array(L, "position", YLM_DOUBLE, 2, (size_t[]){n, 3});
  float *value = set_array(L, "value", YLM_FLOAT, 3, (size_t[]){n, c, k});
  float *gradient = set_array(L, "gradient", YLM_FLOAT, 4, (size_t[]){n, c, k, 3});
  float *lambda = set_array(L, "lambda", YLM_FLOAT, 1, &n);
  float *norm = set_array(L, "norm", YLM_FLOAT, 1, &n);
  float *invalid = set_array(L, "invalid", YLM_FLOAT, 1, &n);
  float *interpolated = set_array(L, "interpolated", YLM_FLOAT, 1, &n);
  float *validity = set_array(L, "validity", YLM_FLOAT, 1, &n);
  float *ghost = v->form.sides ? set_array(L, "ghost", YLM_FLOAT, 1, &n) : NULL;
  for (size_t i = 0; i < n; i++) {
    const float *row = v->data + v->rows * i * v->stride;
    ylm_grid_position(g, v->lattice + 3 * i, position + 3 * i);
    memcpy(value + i * w, row, w * sizeof *value);
    for (size_t j = 0; v->rows > 1 && j < w; j++)
      for (size_t a = 0; a < 3; a++) gradient[3 * (i * w + j) + a] = row[(a + 1) * v->stride + j];
    lambda[i] = v->lambda[i];
    norm[i] = v->norm[i];
    invalid[i] = (v->flags[i] & YLM_GRID_POINT_INVALID) != 0;
    interpolated[i] = (v->flags[i] & YLM_GRID_POINT_INTERPOLATED) != 0;
    validity[i] = (float)validity_of(v, i);
    if (ghost) ghost[i] = (v->flags[i] & YLM_GRID_POINT_GHOST) != 0;
  }
  ylm_status s = v->rows > 1 ? YLM_OK : ylm_grid_mean_slopes(g, gradient);
  return ylmL_result(L, 1, s, NULL);
}

/* grid_judges(grid) -> [n][6] places and normals that have judged its bake, or nil: there are none */
static int grid_judges(lua_State *L) {
  const ylm_grid *g = ylmL_grid_check(L, 1);
  size_t n = ylm_grid_judges(g, NULL);
  if (!n) return 0;
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 6});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_grid_judges(g, a->data);
  return 1;
}

/* grid_allowed(n) -> the most failures among n judging places, or -1 */
static int grid_allowed(lua_State *L) {
  lua_pushinteger(L, ylm_grid_allowed((size_t)luaL_checknumber(L, 1)));
  return 1;
}

/* grid_verdict(grid, verified, failed, error, largest): what another judge says */
static int grid_verdict(lua_State *L) {
  ylm_grid *g = ylmL_grid_check(L, 1);
  ylm_grid_verdict(g, (uint64_t)luaL_checknumber(L, 2), (uint64_t)luaL_checknumber(L, 3),
                   (double)luaL_checknumber(L, 4), (double)luaL_checknumber(L, 5));
  return 0;
}

/* grid_cells(grid, with added ones) -> table of arrays, one row per cell */
static int grid_cells(lua_State *L) {
  static const struct {
    const char *name;
    int flag;
  } flags[] = {{"leaf", YLM_GRID_LEAF},
               {"occupied", YLM_GRID_OCCUPIED},
               {"baked", YLM_GRID_BAKED},
               {"crossed", YLM_GRID_CROSSED | YLM_GRID_SIDED},
               {"added", YLM_GRID_ADDED}};
  const ylm_grid *g = ylmL_grid_check(L, 1);
  const ylm_grid_contents *v = ylm_grid_look(g);
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
  float *parts = v->form.sides ? set_array(L, "parts", YLM_FLOAT, 1, &n) : NULL;
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
    if (parts) parts[i] = 0;
  }
  for (size_t i = 0; parts && i < v->sides; i++) parts[v->side[i].cell] = (float)v->side[i].parts;
  return 1;
}

/* grid_locate(grid, x, y, z, finest) -> one-based cell or nil, table of what it knows, outside */
static int grid_locate(lua_State *L) {
  const ylm_grid *g = ylmL_grid_check(L, 1);
  const ylm_grid_contents *v = ylm_grid_look(g);
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
  ylmL_set_boolean(L, "leaf", c->flags & YLM_GRID_LEAF);
  ylmL_set_boolean(L, "occupied", c->flags & YLM_GRID_OCCUPIED);
  ylmL_set_boolean(L, "baked", c->flags & YLM_GRID_BAKED);
  ylmL_set_boolean(L, "crossed", c->flags & (YLM_GRID_CROSSED | YLM_GRID_SIDED));
  ylmL_set_boolean(L, "outside", outside);
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

static const luaL_Reg functions[] = {
    {"grid_stats", grid_stats},     {"grid_form", grid_form},       {"grid_judges", grid_judges},
    {"grid_allowed", grid_allowed}, {"grid_verdict", grid_verdict}, {"grid_points", grid_points},
    {"grid_cells", grid_cells},     {"grid_locate", grid_locate},   {NULL, NULL}};

void ylmL_open_grid_look(lua_State *L) { luaL_setfuncs(L, functions, 0); }
