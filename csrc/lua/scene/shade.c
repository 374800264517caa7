/* shade.c - views as objects, shading of their points; lua/ylm/render/init.lua drives it. */
#include "shade.h"
#include "transfer.h"
#include "ylm_pace.h"
#include "ylm_shade_gloss.h"

static int view_close(lua_State *L) {
  ylm_shade_view **v = ylmL_check(L, 1, YLML_SHADE_VIEW);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_shade_view_free(*v);
  *v = NULL;
  ylmL_disown(L, 1);
  return 0;
}

static const luaL_Reg view_methods[] = {{"__gc", view_close}, {NULL, NULL}};

ylm_shade_view *ylmL_shade_view(lua_State *L, int i) {
  ylm_shade_view **v = ylmL_check(L, i, YLML_SHADE_VIEW);
  if (!*v) luaL_argerror(L, i, "the prepared view has been closed");
  return *v;
}

ylmL_array *ylmL_shade_result(lua_State *L, int i, int axes, const size_t *shape, ylm_status *s) {
  if (lua_isnoneornil(L, i)) {
    ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, axes, shape);
    if (!a) *s = YLM_ENOMEM;
    return a;
  }
  ylmL_array *a = ylmL_array_check(L, i);
  size_t count;
  if (a->dtype != YLM_FLOAT)
    *s = YLM_ETYPE;
  else if (!ylm_shape_count(axes, shape, &count) || count != a->count)
    *s = YLM_ESHAPE;
  lua_pushvalue(L, i);
  return *s == YLM_OK ? a : NULL;
}

size_t ylmL_shade_points(const ylm_shade_view *v) {
  ylm_shade_stats stats;
  ylm_shade_view_stats(v, &stats);
  return stats.points;
}

ylm_shade_weight ylmL_shade_weight(lua_State *L, int i) {
  return (ylm_shade_weight)luaL_checkoption(L, i, NULL, ylmL_weight_choices);
}

/* shade_field(view, object, "transfer" | "cosine", "float" | "double", threads, progress)
   -> radiance [n][3], pairs */
static int shade_field(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_field *field = ylmL_field_check(L, 2);
  ylm_shade_weight weight = ylmL_shade_weight(L, 3);
  ylm_dtype t = (ylm_dtype)luaL_checkoption(L, 4, "float", ylmL_dtype_choices);
  int threads = (int)luaL_checknumber(L, 5);
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 6);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylmL_shade_points(v), 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  uint64_t pairs = 0;
  const ylm_progress *progress = ylmL_progress_begin(L, 6, &p);
  ylm_status s = ylm_shade_field(v, field, weight, t, threads, progress, out->data, &pairs, &e);
  if (s == YLM_OK) ylmL_push_count(L, pairs);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* shade_coefficients(view, first from 1, L [n][channels][count], threads, out [n][3] or nil) ->
   out */
static int shade_coefficients(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  double first = (double)luaL_checknumber(L, 2);
  ylmL_array *c = ylmL_array_check(L, 3);
  int threads = (int)luaL_checknumber(L, 4), lmax = 0;
  ylm_status s = YLM_OK;
  lua_settop(L, 5);
  if (c->axes != 3 || !(first >= 1)) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  while ((size_t)(lmax + 1) * (size_t)(lmax + 1) < c->shape[2]) lmax++;
  if ((size_t)(lmax + 1) * (size_t)(lmax + 1) != c->shape[2])
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_shade_result(L, 5, 2, (size_t[]){c->shape[0], 3}, &s);
  if (s == YLM_OK)
    s = ylm_shade_coefficients(v, (size_t)first - 1, c->shape[0], (int)c->shape[1], lmax, c->dtype,
                               c->data, threads, out->data);
  return ylmL_result(L, 1, s, NULL);
}

#define GUIDE "ylm.shade_guide"

static void destroy_guide(void *guide) { ylm_scene_guide_free(guide); }

static void read_guide(lua_State *L, int i, void *field) {
  *(const ylm_scene_guide **)field = ylmL_held_check(L, i, GUIDE)->object;
}

typedef struct raycast_form {
  ylm_shade_casting o;
  ylmL_array *rays;
  int progress, into; /* on the stack */
} raycast_form;

static const ylmL_entry raycast_entries[] = {
    YLML(raycast_form, o.light_samples, "light_samples", INT),
    YLML(raycast_form, o.shadows, "shadows", BOOL),
    YLML(raycast_form, o.spread, "spread", BOOL, .optional = true),
    YLML(raycast_form, o.seed, "seed", UINT64),
    YLML(raycast_form, o.threads, "threads", INT),
    YLML(raycast_form, progress, "progress", VALUE),
    YLML(raycast_form, o.lit, "lit", READ, .read = ylmL_read_scene, .optional = true),
    YLML(raycast_form, o.guide, "guide", READ, .read = read_guide, .optional = true),
    YLML(raycast_form, rays, "rays", ARRAY, .optional = true),
    YLML(raycast_form, into, "into", VALUE),
    {.name = NULL}};

/* The numbers of rays of points in o.rays; false: their shape is another. */
static bool take_rays(raycast_form *f, const ylm_shade_view *v) {
  if (!f->rays) return true;
  f->o.rays = f->rays->data;
  return f->rays->dtype == YLM_FLOAT && f->rays->count == ylmL_shade_points(v);
}

/* shade_guide(view, {as shade_raycast}) -> guide, {clusters, rays, seconds}; false: nothing is to be guided */
static int shade_guide(lua_State *L) {
  raycast_form f = {.o = {.lit = NULL}};
  ylmL_read(L, 2, raycast_entries, &f);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_scene_guide *g = NULL;
  ylm_scene_guide_stats stats;
  ylmL_progress p;
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylmL_held *h = ylmL_hold(L, GUIDE, destroy_guide, NULL);
  ylm_status s = ylm_shade_guide(v, &f.o, &g);
  h->object = g;
  if (s != YLM_OK) return ylmL_result_progress(L, 1, s, NULL, &p);
  if (!g) lua_pushboolean(L, false);
  if (!g) return ylmL_result_progress(L, 1, s, NULL, &p);
  ylm_scene_guide_look(g, &stats);
  lua_newtable(L);
  ylmL_set_count(L, "clusters", stats.clusters);
  ylmL_set_count(L, "rays", stats.rays);
  ylmL_set_number(L, "seconds", stats.seconds);
  return ylmL_result_progress(L, 2, s, NULL, &p);
}

/* shade_raycast(view, {light_samples, shadows, seed, threads, progress, lit: the traced scene of the lamps, or nil: the
   view's, guide or nil, rays: float array [n] of points or nil, into: float array [n][3], filled while rays are traced, or nil}) -> radiance [n][3], rays */
static int shade_raycast(lua_State *L) {
  raycast_form f = {.o = {.lit = NULL}};
  ylmL_read(L, 2, raycast_entries, &f);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  uint64_t rays = 0;
  ylmL_progress p;
  ylm_status s = YLM_OK;
  ylmL_array *out =
      ylmL_array_result(L, f.into, YLM_FLOAT, 2, (size_t[]){ylmL_shade_points(v), 3}, &s);
  if (!out) return ylmL_result(L, 0, s, NULL);
  if (!take_rays(&f, v)) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_progress_still(!lua_isnil(L, f.into)); /* the progress function looks at it */
  s = ylm_shade_raycast(v, &f.o, out->data, &rays);
  if (s == YLM_OK) ylmL_push_count(L, rays);
  return ylmL_result_progress(L, 2, s, NULL, &p);
}

/* shade_raycast_noise(view, radiance [n][3], {as shade_raycast}) -> noise */
static int shade_raycast_noise(lua_State *L) {
  raycast_form f = {.o = {.lit = NULL}};
  ylmL_read(L, 3, raycast_entries, &f);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylmL_array *radiance = ylmL_array_check(L, 2);
  double noise = 0;
  if (radiance->dtype != YLM_FLOAT || radiance->count != 3 * ylmL_shade_points(v))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_status s = ylm_shade_raycast_noise(v, &f.o, radiance->data, &noise);
  lua_pushnumber(L, (lua_Number)noise);
  return ylmL_result(L, 1, s, NULL);
}

typedef struct blend_form {
  ylm_shade_blending o;
  int progress; /* on the stack */
} blend_form;

static const ylmL_entry blend_entries[] = {
    YLML(blend_form, o.weight, "weight", CHOICE, .choices = ylmL_weight_choices),
    YLML(blend_form, o.lmax, "lmax", INT),
    YLML(blend_form, o.light_samples, "light_samples", INT),
    YLML(blend_form, o.noise, "noise", DOUBLE, .optional = true),
    YLML(blend_form, o.most_samples, "most_samples", INT, .optional = true),
    YLML(blend_form, o.shadows, "shadows", BOOL),
    YLML(blend_form, o.seed, "seed", UINT64),
    YLML(blend_form, o.threads, "threads", INT),
    YLML(blend_form, progress, "progress", VALUE),
    YLML(blend_form, o.lit, "lit", READ, .read = ylmL_read_scene, .optional = true),
    {.name = NULL}};

/* shade_blend(view, radiance [n][3], {weight: "transfer" | "cosine", lmax, light_samples: or 0, noise | nil,
   most_samples | nil, shadows, seed, threads, progress, lit: the traced scene of the lamps, or nil: the view's})
   -> share [n], {sh, rays, missed, traced, light_samples, noise | nil, seconds}; writes radiance */
static int shade_blend(lua_State *L) {
  blend_form f = {.progress = 0};
  ylmL_read(L, 3, blend_entries, &f);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylmL_array *radiance = ylmL_array_check(L, 2);
  size_t n = ylmL_shade_points(v);
  ylm_shade_blended r;
  ylm_error e = {0};
  ylmL_progress p;
  if (radiance->dtype != YLM_FLOAT || radiance->count != 3 * n)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *share = ylmL_array_new(L, YLM_FLOAT, 1, &n);
  if (!share) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_status s = ylm_shade_blend(v, &f.o, radiance->data, share->data, &r, &e);
  if (s == YLM_OK) {
    lua_newtable(L);
    ylmL_set_count(L, "sh", r.sh);
    ylmL_set_count(L, "rays", r.rays);
    ylmL_set_number(L, "missed", r.missed);
    ylmL_set_count(L, "traced", r.traced);
    ylmL_set_count(L, "light_samples", (uint64_t)r.light_samples);
    if (r.noise >= 0) ylmL_set_number(L, "noise", r.noise);
    ylmL_set_number(L, "seconds", r.seconds);
  }
  return ylmL_result_progress(L, 2, s, &e, &p);
}

static const luaL_Reg functions[] = {{"shade_field", shade_field},
                                     {"shade_blend", shade_blend},
                                     {"shade_coefficients", shade_coefficients},
                                     {"shade_guide", shade_guide},
                                     {"shade_raycast", shade_raycast},
                                     {"shade_raycast_noise", shade_raycast_noise},
                                     {"shade_close_view", view_close},
                                     {NULL, NULL}};

void ylmL_open_shade(lua_State *L) {
  static const luaL_Reg guide_methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};
  ylmL_type(L, YLML_SHADE_VIEW, view_methods);
  ylmL_type(L, GUIDE, guide_methods);
  lua_pop(L, 2);
  luaL_setfuncs(L, functions, 0);
}
