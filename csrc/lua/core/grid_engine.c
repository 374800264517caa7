/* grid_engine.c - numbers at the middles of equal cells, as engines read them. */
#include "grid.h"

typedef struct fit_arguments {
  double cells[3];
  ylmL_array *at, *basis, *wanted, *weight, *hold, *norm, *probes;
  int threads;
  bool quick;
} fit_arguments;

static const ylmL_entry fit_entries[] = {
    YLML(fit_arguments, cells, "cells", NUMBERS),
    YLML(fit_arguments, at, "at", ARRAY),
    YLML(fit_arguments, basis, "basis", ARRAY),
    YLML(fit_arguments, wanted, "wanted", ARRAY, .optional = true),
    YLML(fit_arguments, weight, "weight", ARRAY, .optional = true),
    YLML(fit_arguments, hold, "hold", ARRAY, .optional = true),
    YLML(fit_arguments, norm, "norm", ARRAY, .optional = true),
    YLML(fit_arguments, probes, "probes", ARRAY),
    YLML(fit_arguments, threads, "threads", INT),
    YLML(fit_arguments, quick, "quick", BOOL, .optional = true),
    {NULL}};

static const float *floats(lua_State *L, const ylmL_array *a, size_t count) {
  if (!a) return NULL;
  if (a->dtype != YLM_FLOAT || a->count != count) luaL_error(L, "another array expected");
  return a->data;
}

static ylm_grid_fit read_fit(lua_State *L) {
  fit_arguments x = {0};
  ylmL_read(L, 1, fit_entries, &x);
  ylm_grid_fit f = {.numbers = (int)x.probes->shape[2],
                    .channels = (int)x.probes->shape[1],
                    .places = x.at->shape[0],
                    .threads = x.threads,
                    .quick = x.quick};
  size_t probes = 1;
  for (int a = 0; a < 3; a++) {
    f.cells[a] = (uint32_t)x.cells[a];
    probes *= f.cells[a];
  }
  size_t numbers = (size_t)f.numbers, channels = (size_t)f.channels;
  if (x.at->dtype != YLM_DOUBLE || x.at->count != 3 * f.places)
    luaL_error(L, "another array expected");
  f.at = x.at->data;
  f.basis = floats(L, x.basis, f.places * numbers);
  f.wanted = floats(L, x.wanted, f.places * channels);
  f.weight = floats(L, x.weight, f.places);
  f.hold = floats(L, x.hold, probes);
  f.norm = floats(L, x.norm, numbers);
  floats(L, x.probes, probes * channels * numbers);
  f.probe = x.probes->data;
  return f;
}

/* grid_fit { cells, at, basis, wanted, weight, hold, norm, probes, threads }: the probes change -> true */
static int grid_fit(lua_State *L) {
  ylm_grid_fit f = read_fit(L);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, ylm_grid_fit_probes(&f), NULL);
}

/* grid_fit_look { cells, at, basis, probes, threads } -> irradiance [n][channels] */
static int grid_fit_look(lua_State *L) {
  ylm_grid_fit f = read_fit(L);
  size_t shape[2] = {f.places, (size_t)f.channels};
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, shape);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 1, ylm_grid_fit_look(&f, out->data), NULL);
}

/* grid_clear(bytes of ylm_grid_walls, points [n][3], normals [n][3], far) -> array [n]: 1 where no surface is within `far` along
   the normal */
static int grid_clear(lua_State *L) {
  ylm_grid_walls room;
  const ylm_grid_walls *walls = ylmL_grid_walls(L, 1, &room);
  if (!walls) return luaL_error(L, "walls expected");
  const ylmL_array *p = ylmL_array_check(L, 2), *n = ylmL_array_check(L, 3);
  double far = luaL_checknumber(L, 4);
  size_t count = p->shape[0];
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 1, &count);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  float *share = out->data;
  for (size_t i = 0; i < count; i++) {
    float a[3], b[3];
    for (size_t k = 0; k < 3; k++) {
      double x = ylmL_array_get(p, 3 * i + k) - walls->origin[k],
             d = far * ylmL_array_get(n, 3 * i + k);
      a[k] = (float)(x + 1e-3 * d);
      b[k] = (float)(x + d);
    }
    walls->share(walls->self, 1, &a, &b, share + i);
    share[i] = share[i] >= 1 ? 1 : 0;
  }
  return 1;
}

static const luaL_Reg functions[] = {{"grid_fit", grid_fit},
                                     {"grid_fit_look", grid_fit_look},
                                     {"grid_clear", grid_clear},
                                     {NULL, NULL}};

void ylmL_open_grid_engine(lua_State *L) { luaL_setfuncs(L, functions, 0); }
