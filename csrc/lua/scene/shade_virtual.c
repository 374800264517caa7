/* shade_virtual.c - views under virtual lights; lua/ylm/render/gather.lua drives it. */
#include "shade.h"
#include "ylm_light_virtual.h"
#include "ylm_shade_bounce.h"

/* The window's factors at `i`, lmax + 1 of them, in memory of the state; NULL: nil stands there. */
static const double *read_window(lua_State *L, int i, int lmax) {
  if (lua_isnil(L, i)) return NULL;
  if (lmax < 0 || lmax > YLM_SHADE_GATHER_LMAX) return NULL; /* refused later */
  double *x = lua_newuserdata(L, ((size_t)lmax + 1) * sizeof *x);
  ylmL_scene_numbers(L, i, lmax + 1, x);
  return x;
}

/* shade_virtual(view, lights, {method, lmax, window: list | nil, horizon, clamp, limit, compensate,
   bounces, samples, strategy, shadows, seed, threads, progress, zonal, matte, groups, subset, tile, alpha}) -> radiance
   [n][3], {pairs, rays, singular, lights, kept, alpha, seconds} */
static int shade_virtual(lua_State *L) {
  static const char *const names[] = {
      "method",  "lmax",    "window",   "horizon", "clamp", "limit",   "compensate",
      "bounces", "samples", "strategy", "shadows", "seed",  "threads", "progress",
      "zonal",   "matte",   "groups",   "subset",  "tile",  "alpha",   NULL};
  static const char *const methods[] = {"hvl", "vpl", "vsl", "vsgl", NULL};
  static const char *const horizons[] = {"none", "paper", "gate", NULL};
  static const char *const clamps[] = {"none", "distance", "geometry", "whole", NULL};
  static const char *const strategies[] = {"cone", "receiver", "mis", NULL};
  static const char *const subsets[] = {"all", "interleaved", "stochastic", NULL};
  enum {
    METHOD = 4,
    LMAX,
    WINDOW,
    HORIZON,
    CLAMP,
    LIMIT,
    COMPENSATE,
    BOUNCES,
    SAMPLES,
    STRATEGY,
    SHADOWS,
    SEED,
    THREADS,
    PROGRESS,
    ZONAL,
    MATTE,
    GROUPS,
    SUBSET,
    TILE,
    ALPHA
  };
  ylmL_named(L, 3, names);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_light_virtual *lights = ylm_light_set_virtuals(ylmL_lights_check(L, 2));
  if (!lights) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  ylm_error e = {0};
  ylmL_progress p;
  ylm_shade_gather_options o = {
      .method = (ylm_shade_gather_method)luaL_checkoption(L, METHOD, NULL, methods),
      .lmax = (int)luaL_checknumber(L, LMAX),
      .horizon = (ylm_shade_horizon)luaL_checkoption(L, HORIZON, "none", horizons),
      .clamp = (ylm_shade_clamp)luaL_checkoption(L, CLAMP, "none", clamps),
      .limit = (double)luaL_optnumber(L, LIMIT, 0),
      .compensate = (int)luaL_optnumber(L, COMPENSATE, 0),
      .bounces = (int)luaL_optnumber(L, BOUNCES, 1),
      .samples = (int)luaL_optnumber(L, SAMPLES, 1),
      .strategy = (ylm_shade_sphere_strategy)luaL_checkoption(L, STRATEGY, "mis", strategies),
      .shadows = lua_toboolean(L, SHADOWS),
      .groups = (size_t)luaL_optnumber(L, GROUPS, 0),
      .zonal = lua_toboolean(L, ZONAL),
      .matte = lua_toboolean(L, MATTE),
      .subset = (ylm_shade_subset)luaL_checkoption(L, SUBSET, "all", subsets),
      .tile = (int)luaL_optnumber(L, TILE, 0),
      .alpha = (double)luaL_optnumber(L, ALPHA, 0),
      .seed = (uint64_t)luaL_checknumber(L, SEED),
      .threads = (int)luaL_optnumber(L, THREADS, 0),
      .progress = ylmL_progress_begin(L, PROGRESS, &p)};
  o.window = read_window(L, WINDOW, o.lmax);
  ylm_shade_gather_report r;
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylmL_shade_points(v), 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_shade_gather_virtual(v, lights, &o, out->data, &r, &e);
  lua_newtable(L);
  ylmL_set_count(L, "pairs", r.pairs);
  ylmL_set_count(L, "rays", r.rays);
  ylmL_set_count(L, "singular", r.singular);
  ylmL_set_count(L, "lights", r.lights);
  ylmL_set_count(L, "kept", r.kept);
  ylmL_set_number(L, "alpha", r.alpha);
  ylmL_set_number(L, "seconds", r.seconds);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* shade_rivals(many() of ylm.c.rival): methods of shade_virtual that answered EMISSING */
static int shade_rivals(lua_State *L) {
  ylm_shade_rival_set(lua_touserdata(L, 1));
  return 0;
}

/* shade_near(view, lights, "transfer" | "cosine", lmax, radiance [n][3], threads, progress) -> radiance,
   which it adds to, {pairs, seconds} */
static int shade_near(lua_State *L) {
  lua_settop(L, 7);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_light_virtual *lights = ylm_light_set_virtuals(ylmL_lights_check(L, 2));
  ylm_shade_weight weight = ylmL_shade_weight(L, 3);
  int lmax = (int)luaL_checknumber(L, 4), threads = (int)luaL_checknumber(L, 6);
  ylmL_array *radiance = ylmL_array_check(L, 5);
  ylm_error e = {0};
  ylmL_progress p;
  ylm_shade_near_report r = {0};
  if (!lights) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  if (radiance->dtype != YLM_FLOAT || radiance->count != 3 * ylmL_shade_points(v))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  const ylm_progress *progress = ylmL_progress_begin(L, 7, &p);
  ylm_status s = ylm_shade_near(v, lights, weight, lmax, threads, progress, radiance->data, &r, &e);
  lua_pushvalue(L, 5);
  lua_newtable(L);
  ylmL_set_count(L, "pairs", r.pairs);
  ylmL_set_number(L, "seconds", r.seconds);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* shade_reflect(view, irradiance [n][3]) -> it, as radiance of matte surfaces */
static int shade_reflect(lua_State *L) {
  lua_settop(L, 2);
  const ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylmL_array *a = ylmL_array_check(L, 2);
  if (a->dtype != YLM_FLOAT || a->count != 3 * ylmL_shade_points(v))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_shade_reflect(v, a->data);
  return 1;
}

static const luaL_Reg functions[] = {{"shade_virtual", shade_virtual},
                                     {"shade_rivals", shade_rivals},
                                     {"shade_near", shade_near},
                                     {"shade_reflect", shade_reflect},
                                     {NULL, NULL}};

void ylmL_open_shade_virtual(lua_State *L) { luaL_setfuncs(L, functions, 0); }
