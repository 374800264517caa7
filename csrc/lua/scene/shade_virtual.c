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

typedef struct virtual_form {
  ylm_shade_gather_options o;
  int window, progress; /* on the stack */
} virtual_form;

static const ylmL_entry virtual_entries[] = {
    YLML(virtual_form, o.method, "method", CHOICE, .choices = ylmL_virtual_method_choices),
    YLML(virtual_form, o.lmax, "lmax", INT),
    YLML(virtual_form, window, "window", VALUE),
    YLML(virtual_form, o.horizon, "horizon", CHOICE, .choices = ylmL_horizon_choices,
         .optional = true),
    YLML(virtual_form, o.clamp, "clamp", CHOICE, .choices = ylmL_clamp_choices, .optional = true),
    YLML(virtual_form, o.limit, "limit", DOUBLE, .optional = true),
    YLML(virtual_form, o.compensate, "compensate", INT, .optional = true),
    YLML(virtual_form, o.bounces, "bounces", INT, .optional = true),
    YLML(virtual_form, o.samples, "samples", INT, .optional = true),
    YLML(virtual_form, o.strategy, "strategy", CHOICE, .choices = ylmL_sphere_strategy_choices,
         .optional = true),
    YLML(virtual_form, o.shadows, "shadows", BOOL),
    YLML(virtual_form, o.seed, "seed", UINT64),
    YLML(virtual_form, o.threads, "threads", INT, .optional = true),
    YLML(virtual_form, progress, "progress", VALUE),
    YLML(virtual_form, o.zonal, "zonal", BOOL),
    YLML(virtual_form, o.matte, "matte", BOOL),
    YLML(virtual_form, o.groups, "groups", COUNT, .optional = true),
    YLML(virtual_form, o.subset, "subset", CHOICE, .choices = ylmL_subset_choices,
         .optional = true),
    YLML(virtual_form, o.tile, "tile", INT, .optional = true),
    YLML(virtual_form, o.alpha, "alpha", DOUBLE, .optional = true),
    {.name = NULL}};

static void push_gathered(lua_State *L, const ylm_shade_gather_report *r) {
  lua_newtable(L);
  ylmL_set_count(L, "pairs", r->pairs);
  ylmL_set_count(L, "rays", r->rays);
  ylmL_set_count(L, "singular", r->singular);
  ylmL_set_count(L, "lights", r->lights);
  ylmL_set_count(L, "kept", r->kept);
  ylmL_set_number(L, "alpha", r->alpha);
  ylmL_set_number(L, "seconds", r->seconds);
}

/* shade_virtual(view, lights, {method, lmax, window: list | nil, horizon, clamp, limit, compensate,
   bounces, samples, strategy, shadows, seed, threads, progress, zonal, matte, groups, subset, tile, alpha}) -> radiance
   [n][3], {pairs, rays, singular, lights, kept, alpha, seconds} */
static int shade_virtual(lua_State *L) {
  virtual_form f = {.o = {.bounces = 1, .samples = 1, .strategy = YLM_SHADE_MIS}};
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_light_virtual *lights = ylm_light_set_virtuals(ylmL_lights_check(L, 2));
  if (!lights) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  ylm_error e = {0};
  ylmL_progress p;
  ylmL_read(L, 3, virtual_entries, &f);
  f.o.window = read_window(L, f.window, f.o.lmax);
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_shade_gather_report r;
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylmL_shade_points(v), 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_shade_gather_virtual(v, lights, &f.o, out->data, &r, &e);
  push_gathered(L, &r);
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
