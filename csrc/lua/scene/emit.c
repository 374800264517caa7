/* emit.c - virtual lights of scenes; lua/ylm/render/emit.lua drives it. */
#include <math.h>
#include <string.h>

#include "transfer.h"
#include "ylm_emit.h"
#include "ylm_light_virtual.h"
#include "ylm_sh.h"

#define YLML_VISIBLE "ylm.visible"

static void set_colour(lua_State *L, const char *name, const double x[3]) {
  lua_createtable(L, 3, 0);
  for (int c = 0; c < 3; c++) {
    lua_pushnumber(L, (lua_Number)x[c]);
    lua_rawseti(L, -2, c + 1);
  }
  lua_setfield(L, -2, name);
}

/* Landings of each reflection, up to the last that has any. */
static void set_bounces(lua_State *L, const ylm_emit_report *r) {
  int n = YLM_EMIT_BOUNCES;
  while (n > 0 && r->landings[n - 1] == 0) n--;
  lua_createtable(L, n, 0);
  for (int k = 0; k < n; k++) {
    ylmL_push_count(L, r->landings[k]);
    lua_rawseti(L, -2, k + 1);
  }
  lua_setfield(L, -2, "bounces");
}

static void push_report(lua_State *L, const ylm_emit_report *r, size_t n) {
  lua_newtable(L);
  ylmL_set_count(L, "lights", n);
  ylmL_set_count(L, "particles", r->particles);
  ylmL_set_count(L, "rays", r->rays);
  ylmL_set_count(L, "turned", r->turned);
  ylmL_set_count(L, "absorbed", r->absorbed);
  ylmL_set_count(L, "glossy", r->glossy);
  ylmL_set_count(L, "degree", (size_t)r->degree);
  lua_newtable(L);
  ylmL_set_number(L, "missed", r->missed[0]);
  ylmL_set_number(L, "most", r->missed[1]);
  ylmL_set_number(L, "below", r->below);
  ylmL_set_count(L, "unscaled", r->unscaled);
  lua_setfield(L, -2, "slices");
  set_bounces(L, r);
  lua_newtable(L);
  set_colour(L, "emitted", r->emitted);
  set_colour(L, "landed", r->landed);
  set_colour(L, "lost", r->lost);
  set_colour(L, "reflected", r->reflected);
  set_colour(L, "going", r->going);
  lua_setfield(L, -2, "power");
  lua_newtable(L);
  ylmL_set_number(L, "min", r->radius[0]);
  ylmL_set_number(L, "median", r->radius[1]);
  ylmL_set_number(L, "max", r->radius[2]);
  ylmL_set_count(L, "cut", r->cut);
  lua_setfield(L, -2, "radius");
  lua_newtable(L);
  ylmL_set_number(L, "trace", r->seconds[0]);
  ylmL_set_number(L, "radius", r->seconds[1]);
  ylmL_set_number(L, "emission", r->seconds[2]);
  ylmL_set_number(L, "merge", r->seconds[3]);
  lua_setfield(L, -2, "seconds");
  if (r->merged == 0) return;
  lua_newtable(L);
  ylmL_set_count(L, "landings", r->merged);
  ylmL_set_number(L, "cell", r->cell);
  lua_setfield(L, -2, "merged");
}

/* Four arrays of doubles that hold lights, the last their emission where it has a degree, and their shifts or nil; false
   without memory. */
static bool push_lights(lua_State *L, const ylm_emit_lights *l) {
  const double *from[] = {l->at, l->normal, l->radius, l->emission ? l->emission : l->intensity};
  size_t shape[] = {l->n, 3, (size_t)(l->degree + 1) * (size_t)(l->degree + 1)};
  for (int k = 0; k < 4; k++) {
    ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE,
                                   k == 2                  ? 1
                                   : k == 3 && l->emission ? 3
                                                           : 2,
                                   shape);
    if (!a) return false;
    ylm_copy(a->data, from[k], a->count * sizeof(double));
  }
  if (!l->shift) {
    lua_pushnil(L);
    return true;
  }
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 1, shape); /* [n] */
  if (a) ylm_copy(a->data, l->shift, a->count * sizeof(double));
  return a != NULL;
}

typedef struct emit_form {
  ylm_emit_options o;
  int progress; /* on the stack */
} emit_form;

static const ylmL_entry emit_entries[] = {
    YLML(emit_form, o.particles, "particles", COUNT),
    YLML(emit_form, o.lights, "lights", COUNT, .optional = true),
    YLML(emit_form, o.bounces, "bounces", INT),
    YLML(emit_form, o.radius, "radius", CHOICE, .choices = ylmL_emit_radius_choices),
    YLML(emit_form, o.fixed, "fixed", DOUBLE, .optional = true),
    YLML(emit_form, o.scale, "scale", DOUBLE),
    YLML(emit_form, o.seed, "seed", UINT64),
    YLML(emit_form, o.threads, "threads", INT, .optional = true),
    YLML(emit_form, progress, "progress", VALUE),
    YLML(emit_form, o.grid, "grid", INT, .optional = true),
    YLML(emit_form, o.degree, "degree", INT),
    YLML(emit_form, o.conserve, "conserve", BOOL),
    YLML(emit_form, o.merge, "merge", BOOL),
    YLML(emit_form, o.cell, "cell", DOUBLE, .optional = true),
    {.name = NULL}};

/* emit_lights(scene, {particles, lights, bounces, radius: "density" | "angle" | "fixed" | "footprint" | "neighbours",
   fixed, scale, seed, threads, progress, grid: texels a side or nil, degree: -1 auto, conserve, merge, cell}) -> at
   [n][3], normal [n][3], radius [n], intensity [n][3] or emission [n][3][(degree+1)^2], shift [n] or nil, report */
static int emit_lights(lua_State *L) {
  emit_form f = {.progress = 0};
  ylmL_read(L, 2, emit_entries, &f);
  const ylm_scene *scene = ylmL_scene(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylm_emit_lights lights;
  ylm_emit_report report;
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_status s = ylm_emit(scene, &f.o, &lights, &report, &e);
  if (s == YLM_OK && !push_lights(L, &lights)) s = YLM_ENOMEM;
  ylm_emit_free(&lights);
  if (s == YLM_OK)
    push_report(L, &report, report.particles ? ylmL_array_check(L, -3)->shape[0] : 0);
  return ylmL_result_progress(L, 6, s, &e, &p);
}

/* The array of n doubles at `i`. */
static double *doubles(lua_State *L, int i, size_t n) {
  ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_DOUBLE || a->count != n) luaL_argerror(L, i, "an array of another size");
  return a->data;
}

/* Intensities along the normal [n][3] of emission [n][3][count]. */
static ylm_status along_normals(size_t n, size_t count, const double *normal,
                                const double *emission, double *out) {
  int degree = (int)sqrt((double)count + 0.5) - 1;
  double *Y = ylm_alloc(count, sizeof *Y);
  ylm_status s = Y ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    s = ylm_sh_eval(degree, 0, true, YLM_DOUBLE, 1, normal + 3 * i, Y, NULL, NULL, 1, NULL);
    for (size_t c = 0; s == YLM_OK && c < 3; c++) {
      const double *b = emission + (3 * i + c) * count;
      double sum = 0;
      for (size_t q = 0; q < count; q++) sum += b[q] * Y[q];
      out[3 * i + c] = fmax(0, sum);
    }
  }
  ylm_free(Y);
  return s;
}

/* emit_write(path, at [n][3], normal [n][3], radius [n], emission [n][3][..], shift [n]) -> true */
static int emit_write(lua_State *L) {
  ylm_error e = {0};
  const char *path = luaL_checkstring(L, 1);
  size_t n = ylmL_array_check(L, 4)->count;
  size_t count = n > 0 ? ylmL_array_check(L, 5)->count / (3 * n) : 1;
  ylm_emit_lights l = {.n = n,
                       .at = doubles(L, 2, 3 * n),
                       .normal = doubles(L, 3, 3 * n),
                       .radius = doubles(L, 4, n)};
  const double *emission = doubles(L, 5, 3 * n * count), *shift = doubles(L, 6, n);
  ylmL_array *intensity = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 3});
  if (!intensity) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  l.intensity = intensity->data;
  for (size_t i = 0; count == 1 && i < 3 * n; i++) l.intensity[i] = emission[i] / sqrt(4 * YLM_PI);
  ylm_status s = count > 1 ? along_normals(n, count, l.normal, emission, l.intensity) : YLM_OK;
  for (size_t i = 0; i < 3 * n; i++) l.intensity[i] *= 1 + shift[i / 3];
  lua_pushboolean(L, true);
  if (s == YLM_OK) s = ylm_emit_write_ply(&l, path, &e);
  return ylmL_result(L, 1, s, &e);
}

/* -- lights with their shadows -------------------------------------------------------------- */

static const ylm_field *visible_field(void *object) {
  ylmL_held *h = *(ylmL_held **)object;
  return h && h->object ? ylm_emit_visible_field(h->object) : NULL;
}

static void destroy_visible(void *object) { ylm_emit_visible_free(object); }

/* emit_visible(scene, virtual lights) -> visible */
static int emit_visible(lua_State *L) {
  ylm_error e = {0};
  ylm_emit_visible *v;
  const ylm_scene *scene = ylmL_scene(L, 1);
  ylm_light_virtual *lights = ylm_light_set_virtuals(ylmL_lights_check(L, 2));
  if (!lights) return luaL_argerror(L, 2, "virtual lights expected");
  ylmL_held *h = ylmL_hold(L, YLML_VISIBLE, destroy_visible, NULL);
  ylm_status s = ylm_emit_visible_create(scene, lights, &v, &e);
  h->object = v;
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {{"emit_lights", emit_lights},
                                     {"emit_write", emit_write},
                                     {"emit_visible", emit_visible},
                                     {"emit_visible_close", ylmL_let_go},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};

void ylmL_open_emit(lua_State *L) {
  ylmL_type(L, YLML_VISIBLE, methods);
  ylmL_type_has_field(L, visible_field);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
