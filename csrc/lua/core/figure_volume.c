/* figure_volume.c - lattices of numbers: resampling, isosurfaces' and streamlines' source. */
#include "../binding_figure.h"
#include "../binding_grid.h"

#include <math.h>
#include <string.h>

static ylm_figure_volume *volume_at(lua_State *L, int i) { return ylmL_check(L, i, YLM_VOLUME); }

static size_t voxels(const ylm_figure_volume *v) { return v->size[0] * v->size[1] * v->size[2]; }

static int volume_gc(lua_State *L) {
  ylm_figure_volume_clear(volume_at(L, 1));
  return 0;
}

/* volume({x0 y0 z0 x1 y1 z1}, {nx, ny, nz}, components) */
static int volume_new(lua_State *L) {
  double b[6], size[3];
  ylmL_numbers(L, 1, 6, b);
  ylmL_numbers(L, 2, 3, size);
  size_t n[3];
  for (int a = 0; a < 3; a++) {
    if (!(size[a] >= 1 && size[a] <= 65536)) return ylmL_result(L, 0, YLM_ERANGE, NULL);
    n[a] = (size_t)size[a];
  }
  int components = (int)luaL_optnumber(L, 3, 1);
  ylm_figure_volume *v = lua_newuserdata(L, sizeof *v);
  memset(v, 0, sizeof *v);
  luaL_getmetatable(L, YLM_VOLUME);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_figure_volume_init(v, b, n, components);
  if (s == YLM_OK) ylmL_charge(L, voxels(v) * (size_t)components * sizeof(float));
  return ylmL_result(L, 1, s, NULL);
}

/* fill(volume, value, pointwise, cells...) */
static int volume_fill(lua_State *L) {
  ylm_figure_volume *v = volume_at(L, 1);
  bool pointwise = lua_toboolean(L, 3);
  ylm_figure_cells c = ylmL_cells(L, 4);
  size_t rows;
  const double *value = ylmL_doubles(L, 2, pointwise ? (size_t)v->components : 1, &rows);
  if (!pointwise && rows != c.n) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  return ylmL_result(L, 0, ylm_figure_fill(v, &c, value, rows, pointwise), NULL);
}

/* fill_parts(volume, grid with sides, doubles [points][components] or nil: numbers of parts) */
static int volume_fill_parts(lua_State *L) {
  ylm_figure_volume *v = volume_at(L, 1);
  const ylm_grid *g = ylmL_grid_check(L, 2);
  bool numbers = lua_isnoneornil(L, 3);
  size_t rows = 0;
  const double *value = numbers ? NULL : ylmL_doubles(L, 3, (size_t)v->components, &rows);
  if (!numbers && rows != ylm_grid_look(g)->points) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_figure_fill_parts(v, g, value);
  return 0;
}

/* set(volume, array [nz][ny][nx][components]) */
static int volume_set(lua_State *L) {
  ylm_figure_volume *v = volume_at(L, 1);
  ylmL_array *a = ylmL_array_check(L, 2);
  if (a->count != voxels(v) * (size_t)v->components) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  for (size_t i = 0; i < a->count; i++) v->value[i] = (float)ylmL_array_get(a, i);
  return 0;
}

/* resample(to, from) */
static int volume_resample(lua_State *L) {
  ylm_figure_volume *to = volume_at(L, 1), *from = volume_at(L, 2);
  if (to->components != from->components) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_figure_resample(to, from);
  return 0;
}

/* values(volume) -> array [nz][ny][nx][components] */
static int volume_values(lua_State *L) {
  ylm_figure_volume *v = volume_at(L, 1);
  size_t shape[4] = {v->size[2], v->size[1], v->size[0], (size_t)v->components};
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 4, shape);
  if (a) memcpy(a->data, v->value, a->count * sizeof(float));
  return ylmL_result(L, 1, a ? YLM_OK : YLM_ENOMEM, NULL);
}

/* centres(volume) -> the voxels' middles [voxels][3] */
static int volume_centres(lua_State *L) {
  ylm_figure_volume *v = volume_at(L, 1);
  size_t shape[2] = {voxels(v), 3}, i = 0;
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 2, shape);
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *p = a->data;
  for (size_t z = 0; z < v->size[2]; z++)
    for (size_t y = 0; y < v->size[1]; y++)
      for (size_t x = 0; x < v->size[0]; x++, i++) {
        p[3 * i] = v->origin[0] + v->spacing[0] * (double)x;
        p[3 * i + 1] = v->origin[1] + v->spacing[1] * (double)y;
        p[3 * i + 2] = v->origin[2] + v->spacing[2] * (double)z;
      }
  return 1;
}

/* range(volume) -> least, largest, least above 0; nothing if it is empty */
static int volume_range(lua_State *L) {
  double lo, hi, positive;
  if (!ylm_figure_volume_range(volume_at(L, 1), &lo, &hi, &positive)) return 0;
  lua_pushnumber(L, lo);
  lua_pushnumber(L, hi);
  if (!isfinite(positive)) return 2;
  lua_pushnumber(L, positive);
  return 3;
}

static int volume_smooth(lua_State *L) {
  return ylmL_result(L, 0, ylm_figure_volume_smooth(volume_at(L, 1), (int)luaL_checknumber(L, 2)),
                     NULL);
}

static int volume_save(lua_State *L) {
  ylm_error e;
  ylm_status s =
      ylm_figure_save_volume(luaL_checkstring(L, 2), volume_at(L, 1), luaL_checkstring(L, 3), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

typedef struct lines_form {
  int seeds; /* on the stack */
  double step, radius;
  size_t room, fewest;
} lines_form;

static const ylmL_entry lines_entries[] = {
    YLML(lines_form, seeds, "seeds", VALUE),    YLML(lines_form, step, "step", DOUBLE),
    YLML(lines_form, room, "room", COUNT),      YLML(lines_form, fewest, "fewest", COUNT),
    YLML(lines_form, radius, "radius", DOUBLE), {.name = NULL}};

/* streamlines(shape, volume, {seeds, step, room, fewest, radius}, scale...) */
static int shape_streamlines(lua_State *L) {
  enum { LINES = 8 };
  lines_form f = {.seeds = 0};
  size_t n;
  ylm_figure_scale scale = ylmL_scale(L, 4);
  lua_settop(L, LINES - 1);
  lua_pushvalue(L, 3);
  ylmL_read(L, LINES, lines_entries, &f);
  const double *seed = ylmL_doubles(L, f.seeds, 3, &n);
  return ylmL_result(L, 0,
                     ylm_figure_add_streamlines(ylmL_check(L, 1, YLM_SHAPE), volume_at(L, 2), n,
                                                seed, f.step, f.room, f.fewest, f.radius, &scale),
                     NULL);
}

static const luaL_Reg functions[] = {{"shape_streamlines", shape_streamlines},
                                     {"volume", volume_new},
                                     {"volume_fill", volume_fill},
                                     {"volume_fill_parts", volume_fill_parts},
                                     {"volume_set", volume_set},
                                     {"volume_values", volume_values},
                                     {"volume_centres", volume_centres},
                                     {"volume_range", volume_range},
                                     {"volume_smooth", volume_smooth},
                                     {"volume_resample", volume_resample},
                                     {"volume_save", volume_save},
                                     {"__gc", volume_gc},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", volume_gc}, {NULL, NULL}};

void ylmL_open_figure_volume(lua_State *L) {
  ylmL_type(L, YLM_VOLUME, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
