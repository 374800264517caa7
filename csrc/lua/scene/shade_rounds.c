/* shade_rounds.c - pictures in rounds: sets of links, the noise that is left, and where it is. */
#include "shade.h"
#include "transfer.h"
#include "ylm_shade_bounce.h"

typedef struct sets_form {
  ylm_shade_sets o;
  ylm_radiosity *lit;
  ylmL_array *sets, *first, *second;
  bool apart;
  int progress; /* on the stack */
} sets_form;

static void read_transfer(lua_State *L, int i, void *field) {
  *(const ylm_transfer **)field = ylmL_transfer(L, i);
}

#define TARGETS "ylm.shade_targets"

static void destroy_targets(void *targets) { ylm_transfer_targets_free(targets); }

static void read_targets(lua_State *L, int i, void *field) {
  *(const ylm_transfer_targets **)field = ylmL_held_check(L, i, TARGETS)->object;
}

static const ylmL_entry sets_entries[] = {
    YLML(sets_form, o.transfer, "transfer", READ, .read = read_transfer),
    YLML(sets_form, lit, "lit", READ, .read = ylmL_read_radiosity),
    YLML(sets_form, o.targets, "targets", READ, .read = read_targets, .optional = true),
    YLML(sets_form, o.links, "links", INT),
    YLML(sets_form, sets, "sets", ARRAY),
    YLML(sets_form, o.all, "all", BOOL),
    YLML(sets_form, apart, "apart", BOOL),
    YLML(sets_form, first, "first", ARRAY),
    YLML(sets_form, second, "second", ARRAY),
    YLML(sets_form, o.seed, "seed", UINT64),
    YLML(sets_form, o.threads, "threads", INT),
    YLML(sets_form, progress, "progress", VALUE),
    {.name = NULL}};

static bool has_floats(const ylmL_array *a, size_t count) {
  return a->dtype == YLM_FLOAT && a->count == count;
}

/* shade_gather_sets(view, {transfer, lit, links, sets [n], all, apart: noise of direct light instead of light, first, second:
   out [n][3], seed, threads, progress}) -> rays; 0: that noise is not known */
static int shade_gather_sets(lua_State *L) {
  sets_form f = {.o = {.targets = NULL}};
  ylmL_read(L, 2, sets_entries, &f);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  size_t n = ylmL_shade_points(v);
  uint64_t rays = 0;
  ylm_error e = {0};
  ylmL_progress p;
  if (!has_floats(f.sets, n) || !has_floats(f.first, 3 * n) || !has_floats(f.second, 3 * n))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  f.o.sets = f.sets->data;
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_status s =
      (f.apart ? ylm_radiosity_noise : ylm_radiosity_averaged)(f.lit, f.o.threads, &f.o.leaving);
  if (s == YLM_OK && f.o.leaving)
    s = ylm_shade_gather_sets(v, &f.o, (float *[2]){f.first->data, f.second->data}, &rays, &e);
  if (s == YLM_OK) ylmL_push_count(L, rays);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* shade_targets(view, transfer, lit, seed, threads, progress) -> targets, {clusters, groups, rays, seconds}; false: no light */
static int shade_targets(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylmL_held *of = ylmL_held_check(L, 2, YLML_TRANSFER);
  const ylm_radiosity *lit = ylmL_radiosity(L, 3);
  ylm_transfer_targets *a = NULL;
  ylm_transfer_targets_stats stats;
  ylmL_progress p;
  lua_settop(L, 6);
  ylmL_held *h = ylmL_hold(L, TARGETS, destroy_targets, of);
  ylm_status s =
      ylm_shade_targets(v, of->object, ylm_radiosity_leaving(lit), (uint64_t)luaL_checknumber(L, 4),
                        (int)luaL_checknumber(L, 5), ylmL_progress_begin(L, 6, &p), &a);
  h->object = a;
  if (s != YLM_OK) return ylmL_result_progress(L, 1, s, NULL, &p);
  if (!a) lua_pushboolean(L, false);
  if (!a) return ylmL_result_progress(L, 1, s, NULL, &p);
  ylm_transfer_targets_look(a, &stats);
  lua_newtable(L);
  ylmL_set_count(L, "clusters", stats.clusters);
  ylmL_set_count(L, "groups", stats.groups);
  ylmL_set_count(L, "rays", stats.rays);
  ylmL_set_number(L, "seconds", stats.seconds);
  return ylmL_result_progress(L, 2, s, NULL, &p);
}

/* shade_noise_around(view, a, b, all: each [h][w][3], threads, out [h][w][1]) -> out */
static int shade_noise_around(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  size_t n = (size_t)o->width * (size_t)o->height;
  const ylmL_array *x[3];
  for (int k = 0; k < 3; k++) {
    x[k] = ylmL_array_check(L, 2 + k);
    if (!has_floats(x[k], 3 * n)) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  }
  int threads = (int)luaL_checknumber(L, 5);
  ylmL_array *out = ylmL_array_check(L, 6);
  if (!has_floats(out, n)) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_status s = ylm_shade_noise_around(v, x[0]->data, x[1]->data, x[2]->data, threads, out->data);
  lua_settop(L, 6);
  return ylmL_result(L, 1, s, NULL);
}

typedef struct plan_form {
  ylm_shade_plan o;
  ylmL_array *noise, *rays, *weight;
} plan_form;

static const ylmL_entry plan_entries[] = {
    YLML(plan_form, noise, "noise", ARRAY),
    YLML(plan_form, o.factor, "factor", DOUBLE),
    YLML(plan_form, o.unit, "unit", DOUBLE),
    YLML(plan_form, o.least, "least", DOUBLE),
    YLML(plan_form, o.most, "most", DOUBLE),
    YLML(plan_form, rays, "rays", ARRAY, .optional = true),
    YLML(plan_form, weight, "weight", ARRAY, .optional = true),
    {.name = NULL}};

/* shade_plan(view, {noise [h][w], factor, unit, least, most, rays, weight: out [n]}) -> the squared noise of all pixels, rays of
   a point */
static int shade_plan(lua_State *L) {
  plan_form f = {.rays = NULL, .weight = NULL};
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  size_t n = ylmL_shade_points(v);
  double sum[2];
  ylmL_read(L, 2, plan_entries, &f);
  if (!has_floats(f.noise, (size_t)o->width * (size_t)o->height) ||
      (f.rays && !has_floats(f.rays, n)) || (f.weight && !has_floats(f.weight, n)))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  f.o.noise = f.noise->data;
  ylm_status s = ylm_shade_plan_rays(v, &f.o, f.rays ? f.rays->data : NULL,
                                     f.weight ? f.weight->data : NULL, sum);
  lua_pushnumber(L, sum[0]);
  lua_pushnumber(L, sum[1]);
  return ylmL_result(L, 2, s, NULL);
}

/* shade_edge_rays(view, light [n][3], all [n][3], unit, most, threads, out [n]) -> the mean of out */
static int shade_edge_rays(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylmL_array *light = ylmL_array_check(L, 2), *all = ylmL_array_check(L, 3);
  ylmL_array *out = ylmL_array_check(L, 7);
  size_t n = ylmL_shade_points(v);
  double mean = 0;
  ylm_shade_edges o = {.unit = luaL_checknumber(L, 4), .most = luaL_checknumber(L, 5)};
  if (!has_floats(light, 3 * n) || !has_floats(all, 3 * n) || !has_floats(out, n))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  o.light = light->data, o.all = all->data;
  ylm_status s = ylm_shade_edge_rays(v, &o, (int)luaL_checknumber(L, 6), out->data, &mean);
  lua_pushnumber(L, mean);
  return ylmL_result(L, 1, s, NULL);
}

typedef struct denoise_form {
  ylmL_array *first, *second, *all;
  bool bounced;
  double noise;
  int threads, progress; /* progress on the stack */
} denoise_form;

static const ylmL_entry denoise_entries[] = {
    YLML(denoise_form, first, "first", ARRAY),       YLML(denoise_form, second, "second", ARRAY),
    YLML(denoise_form, all, "all", ARRAY),           YLML(denoise_form, bounced, "bounced", BOOL),
    YLML(denoise_form, noise, "noise", DOUBLE),      YLML(denoise_form, threads, "threads", INT),
    YLML(denoise_form, progress, "progress", VALUE), {.name = NULL}};

/* shade_denoise(view, {first, second: in/out [n][3], all [n][3], bounced, noise, threads, progress}) -> true */
static int shade_denoise(lua_State *L) {
  denoise_form f = {.threads = 0};
  ylmL_progress p;
  ylmL_read(L, 2, denoise_entries, &f);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  size_t n = 3 * ylmL_shade_points(v);
  if (!has_floats(f.first, n) || !has_floats(f.second, n) || !has_floats(f.all, n))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  const ylm_progress *progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_status s = ylm_shade_denoise(v, (float *[2]){f.first->data, f.second->data}, f.all->data,
                                   f.bounced, f.noise, f.threads, progress);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, NULL, &p);
}

/* shade_oidn() -> true: Open Image Denoise is there; shade_oidn(radiance, albedo or nil, normal or nil: float [h][w][3],
   out) -> true */
static int shade_oidn(lua_State *L) {
  ylm_error e = {0};
  ylmL_array *x[4] = {NULL};
  bool asked = lua_isnoneornil(L, 1);
  for (int k = 0; k < 4 && !asked; k++)
    if (!lua_isnoneornil(L, k + 1)) x[k] = ylmL_array_check(L, k + 1);
  for (int k = 0; k < 4 && !asked; k++)
    if (k % 3 == 0 || x[k])
      if (!x[k] || x[k]->axes != 3 || x[k]->shape[2] != 3 || !has_floats(x[k], x[0]->count))
        return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_shade_picture p = {0};
  if (!asked)
    p = (ylm_shade_picture){.width = (int)x[0]->shape[1],
                            .height = (int)x[0]->shape[0],
                            .radiance = x[0]->data,
                            .albedo = x[1] ? x[1]->data : NULL,
                            .normal = x[2] ? x[2]->data : NULL};
  ylm_status s = ylm_shade_oidn(asked ? NULL : &p, asked ? NULL : x[3]->data, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {{"shade_denoise", shade_denoise},
                                     {"shade_edge_rays", shade_edge_rays},
                                     {"shade_oidn", shade_oidn},
                                     {"shade_gather_sets", shade_gather_sets},
                                     {"shade_noise_around", shade_noise_around},
                                     {"shade_plan", shade_plan},
                                     {"shade_targets", shade_targets},
                                     {NULL, NULL}};

void ylmL_open_shade_rounds(lua_State *L) {
  static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};
  ylmL_type(L, TARGETS, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
