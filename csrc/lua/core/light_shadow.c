/* light_shadow.c - ylm.occluder and ylm.shadowed: visibilities of bodies, and light behind them. */
#include "../binding.h"

#include <string.h>

#include "ylm_geom.h"
#include "ylm_light_shadow.h"

#define OCCLUDER YLML_OCCLUDER
#define SHADOWED "ylm.shadowed"

/* -- occluders ------------------------------------------------------------------------------ */

static const ylm_field *occluder_field(void *object) {
  const ylmL_occluder *o = object;
  return o->of ? o->kind->field(o->of) : NULL;
}

static const ylm_field *field_of(const void *of) { return ylm_light_occluder_field(of); }

static void body_of(const void *of, double at[3], double *radius, double *area) {
  ylm_light_occluder_body(of, at, radius, area);
}

static ylm_status places_of(const void *of, double near, double far, size_t n, float *places,
                            ylm_error *e) {
  (void)e;
  ylm_light_occluder_places(of, near, far, 1, n, places);
  return YLM_OK;
}

static void free_occluder(void *of) { ylm_light_occluder_free(of); }

static const ylmL_occluder_kind exact = {field_of, body_of, places_of, free_occluder};

/* occluder_sphere(x, y, z, radius) -> occluder */
static int occluder_sphere(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  double at[3] = {(double)luaL_checknumber(L, 1), (double)luaL_checknumber(L, 2),
                  (double)luaL_checknumber(L, 3)};
  double radius = (double)luaL_checknumber(L, 4);
  ylmL_occluder *o = ylmL_occluder_push(L, &exact);
  ylm_light_occluder *of;
  ylm_status s = ylm_light_occluder_sphere(at, radius, &of, &e);
  o->of = of;
  if (s == YLM_OK) ylmL_charge(L, 2000);
  return ylmL_result(L, 1, s, &e);
}

/* occluder_solid(mesh) -> occluder */
static int occluder_solid(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  const ylm_mesh *m = ylmL_mesh_check(L, 1);
  const float *position = ylmL_mesh_floats(L, m);
  ylmL_occluder *o = ylmL_occluder_push(L, &exact);
  ylm_light_occluder *of;
  ylm_status s = ylm_light_occluder_solid(m->vertices, position, m->triangles, m->index, &of, &e);
  o->of = of;
  if (s == YLM_OK) ylmL_charge(L, m->triangles * 600);
  return ylmL_result(L, 1, s, &e);
}

/* occluder_body(occluder) -> x, y, z, radius of a sphere around the body, mean area of its projections; nothing once
   closed */
static int occluder_body(lua_State *L) {
  const ylmL_occluder *o = ylmL_check(L, 1, OCCLUDER);
  double at[3], radius, area;
  if (!o->of) return 0;
  o->kind->body(o->of, at, &radius, &area);
  for (int a = 0; a < 3; a++) lua_pushnumber(L, at[a]);
  lua_pushnumber(L, radius);
  lua_pushnumber(L, area);
  return 5;
}

/* occluder_places(occluder, near, far, n) -> float [n][3] */
static int occluder_places(lua_State *L) {
  const ylmL_occluder *o = ylmL_check(L, 1, OCCLUDER);
  ylm_error e = {YLM_OK, ""};
  size_t n = (size_t)luaL_checknumber(L, 4);
  double near = (double)luaL_checknumber(L, 2), far = (double)luaL_checknumber(L, 3);
  if (!o->of) return ylmL_result(L, 0, YLM_ECLOSED, NULL);
  ylmL_array *a = ylmL_array_unset(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 1, o->kind->places(o->of, near, far, n, a->data, &e), &e);
}

static int occluder_close(lua_State *L) {
  ylmL_occluder *o = ylmL_check(L, 1, OCCLUDER);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  if (o->of) o->kind->free(o->of);
  o->of = NULL;
  ylmL_disown(L, 1);
  return 0;
}

/* -- shadowed light -------------------------------------------------------------------------- */

/* An object whose light field is asked. */
typedef struct part {
  void *object;
  ylmL_field_of *get;
} part;

typedef struct shadowed {
  ylm_light_shadowed *of;       /* NULL once closed, or where `rest` is meant */
  ylm_light_shadowed_rest rest; /* rest.of NULL: none */
  part *parts;                  /* [n] */
  size_t n;
  int keep; /* the parts, in the registry */
} shadowed;

static const ylm_field *shadowed_field(void *object) {
  const shadowed *s = object;
  for (size_t i = 0; i < s->n; i++)
    if (!s->parts[i].get(s->parts[i].object)) return NULL;
  if (s->rest.of) return &s->rest.field;
  return s->of ? ylm_light_shadowed_field(s->of) : NULL;
}

/* Arguments of shadowed_create, those of lights and casters as their places on the stack. */
typedef struct shadowed_form {
  int lights, hides, facts, which, at, rotation, scale, body;
  ylm_light_shadow_form form;
} shadowed_form;
enum { LMAX, CENTRE, RADIUS = 4, FAR, AREA, FACTS_WIDTH };

/* The double array at `i` of `count` numbers; raises otherwise. */
static const double *numbers(lua_State *L, int i, size_t count) {
  const ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_DOUBLE || a->count != count)
    luaL_argerror(L, i, "a double array of another shape expected");
  return a->data;
}

/* Casters from the arguments of shadowed_create, in a userdata left on the stack. */
static ylm_light_caster *read_casters(lua_State *L, const shadowed_form *f, size_t *n) {
  const ylmL_array *which = ylmL_array_check(L, f->which);
  size_t hides = lua_rawlen(L, f->hides);
  *n = which->count;
  const double *w = numbers(L, f->which, *n), *at = numbers(L, f->at, 3 * *n),
               *rotation = numbers(L, f->rotation, 9 * *n), *scale = numbers(L, f->scale, *n),
               *body = numbers(L, f->body, *n), *facts = numbers(L, f->facts, FACTS_WIDTH * hides);
  ylm_light_caster *c = lua_newuserdata(L, (*n + 1) * sizeof *c);
  for (size_t i = 0; i < *n; i++) {
    c[i] = (ylm_light_caster){.scale = scale[i], .body = (uint32_t)body[i]};
    memcpy(c[i].at, at + 3 * i, sizeof c[i].at);
    memcpy(c[i].rotation, rotation + 9 * i, sizeof c[i].rotation);
    if (!(w[i] >= 1 && w[i] <= (double)hides)) continue; /* a sphere */
    const double *fact = facts + FACTS_WIDTH * ((size_t)w[i] - 1);
    lua_rawgeti(L, f->hides, (int)w[i]);
    c[i].hides = ylmL_field_check(L, lua_gettop(L));
    lua_pop(L, 1);
    c[i].lmax = (int)fact[LMAX];
    memcpy(c[i].centre, fact + CENTRE, sizeof c[i].centre);
    c[i].radius = fact[RADIUS];
    c[i].far = fact[FAR];
    c[i].area = fact[AREA];
  }
  return c;
}

/* Keeps the lights and what casters hide alive, and looks at them before each use. */
static bool keep_parts(lua_State *L, const shadowed_form *f, shadowed *s) {
  size_t hides = lua_rawlen(L, f->hides);
  s->parts = ylm_alloc(hides + 1, sizeof *s->parts);
  if (!s->parts) return false;
  lua_createtable(L, (int)hides + 1, 0);
  for (size_t i = 0; i <= hides; i++) {
    if (i)
      lua_rawgeti(L, f->hides, (int)i);
    else
      lua_pushvalue(L, f->lights);
    s->parts[s->n++] = (part){lua_touserdata(L, -1), ylmL_field_getter(L, -1)};
    ylmL_note_part(L);
    lua_rawseti(L, -2, (int)i + 1);
  }
  s->keep = luaL_ref(L, LUA_REGISTRYINDEX);
  return true;
}

static const ylmL_entry shadowed_entries[] = {
    YLML(shadowed_form, lights, "lights", VALUE),
    YLML(shadowed_form, hides, "hides", VALUE),
    YLML(shadowed_form, facts, "facts", VALUE),
    YLML(shadowed_form, which, "which", VALUE),
    YLML(shadowed_form, at, "at", VALUE),
    YLML(shadowed_form, rotation, "rotation", VALUE),
    YLML(shadowed_form, scale, "scale", VALUE),
    YLML(shadowed_form, body, "body", VALUE),
    YLML(shadowed_form, form.product, "product", CHOICE, .choices = ylmL_shadow_product_choices),
    YLML(shadowed_form, form.rule, "rule", DOUBLE),
    YLML(shadowed_form, form.cull, "cull", DOUBLE),
    YLML(shadowed_form, form.layers, "layers", BOOL),
    YLML(shadowed_form, form.exponential, "exp", CHOICE, .choices = ylmL_sh_exp_choices),
    YLML(shadowed_form, form.terms, "terms", INT),
    {.name = NULL}};

/*
** shadowed_create{lights: an object with a light field, hides: list of objects with one, facts: double [hides][7] of
**   lmax, centre, radius, far, area, which: double [n] places in hides, 0 for spheres, at [n][3], rotation [n][9],
**   scale [n], body [n], product, rule, cull, layers, exp, terms} -> an object with a light field
*/
static int shadowed_create(lua_State *L) {
  shadowed_form f = {.lights = 0};
  ylm_error e = {YLM_OK, ""};
  size_t n;
  ylmL_read(L, 1, shadowed_entries, &f);
  luaL_checktype(L, f.hides, LUA_TTABLE);
  const ylm_field *field = ylmL_field_check(L, f.lights);
  const ylm_light_set *set =
      ylmL_test(L, f.lights, YLM_LIGHTS) ? ylmL_lights_check(L, f.lights) : NULL;
  const ylm_light_caster *caster = read_casters(L, &f, &n);
  shadowed *s = lua_newuserdata(L, sizeof *s);
  *s = (shadowed){.keep = LUA_NOREF};
  luaL_getmetatable(L, SHADOWED);
  lua_setmetatable(L, -2);
  if (!keep_parts(L, &f, s)) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status status =
      ylm_light_shadowed_create(set, set ? NULL : field, n, caster, &f.form, &s->of, &e);
  if (status == YLM_OK) ylmL_charge(L, n * 400 + 2000);
  return ylmL_result(L, 1, status, &e);
}

/* shadowed_without(shadowed, first from 0 on, n) -> an object whose light field has these casters not */
static int shadowed_without(lua_State *L) {
  shadowed *s = ylmL_check(L, 1, SHADOWED);
  size_t first = (size_t)luaL_checknumber(L, 2), n = (size_t)luaL_checknumber(L, 3);
  lua_settop(L, 1);
  if (!s->of) return ylmL_result(L, 0, YLM_ECLOSED, NULL);
  shadowed *r = lua_newuserdata(L, sizeof *r);
  *r = (shadowed){.keep = LUA_NOREF};
  luaL_getmetatable(L, SHADOWED);
  lua_setmetatable(L, -2);
  r->parts = ylm_alloc(1, sizeof *r->parts);
  if (!r->parts) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  lua_createtable(L, 1, 0);
  lua_pushvalue(L, 1);
  r->parts[r->n++] = (part){s, ylmL_field_getter(L, -1)};
  ylmL_note_part(L);
  lua_rawseti(L, -2, 1);
  r->keep = luaL_ref(L, LUA_REGISTRYINDEX);
  return ylmL_result(L, 1, ylm_light_shadowed_without(s->of, first, n, &r->rest), NULL);
}

/* shadowed_caster(shadowed, i from 0 on) -> {x, y, z}, rotation {9 numbers}, scale */
static int shadowed_caster(lua_State *L) {
  shadowed *s = ylmL_check(L, 1, SHADOWED);
  if (!s->of) return ylmL_result(L, 0, YLM_ECLOSED, NULL);
  const ylm_light_caster *c = ylm_light_shadowed_caster(s->of, (size_t)luaL_checknumber(L, 2));
  lua_createtable(L, 3, 0);
  for (int a = 0; a < 3; a++) {
    lua_pushnumber(L, c->at[a]);
    lua_rawseti(L, -2, a + 1);
  }
  lua_createtable(L, 9, 0);
  for (int a = 0; a < 9; a++) {
    lua_pushnumber(L, c->rotation[a]);
    lua_rawseti(L, -2, a + 1);
  }
  lua_pushnumber(L, c->scale);
  return 3;
}

/* shadowed_move(shadowed, first from 0 on, n, at [n][3] | nil, rotation [n][9] | nil, scale [n] | nil) -> true */
static int shadowed_move(lua_State *L) {
  shadowed *s = ylmL_check(L, 1, SHADOWED);
  ylm_error e = {YLM_OK, ""};
  lua_settop(L, 6);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  if (!s->of) return ylmL_result(L, 0, YLM_ECLOSED, NULL);
  size_t first = (size_t)luaL_checknumber(L, 2), n = (size_t)luaL_checknumber(L, 3);
  const double *at = lua_isnil(L, 4) ? NULL : numbers(L, 4, 3 * n),
               *rotation = lua_isnil(L, 5) ? NULL : numbers(L, 5, 9 * n),
               *scale = lua_isnil(L, 6) ? NULL : numbers(L, 6, n);
  ylm_status status = ylm_light_shadowed_move(s->of, first, n, at, rotation, scale, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, status, &e);
}

/* shadowed_look(shadowed) -> { points, casters, products, factors, seconds }; nothing once closed */
static int shadowed_look(lua_State *L) {
  const shadowed *s = ylmL_check(L, 1, SHADOWED);
  ylm_light_shadowed_stats now;
  if (!s->of) return 0;
  ylm_light_shadowed_look(s->of, &now);
  lua_newtable(L);
  ylmL_set_count(L, "points", now.points);
  ylmL_set_count(L, "casters", now.casters);
  ylmL_set_count(L, "products", now.products);
  ylmL_set_count(L, "factors", now.factors);
  ylmL_set_number(L, "seconds", now.seconds);
  return 1;
}

static int shadowed_close(lua_State *L) {
  shadowed *s = ylmL_check(L, 1, SHADOWED);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_light_shadowed_free(s->of);
  ylm_free(s->parts);
  luaL_unref(L, LUA_REGISTRYINDEX, s->keep);
  *s = (shadowed){.keep = LUA_NOREF};
  ylmL_disown(L, 1);
  return 0;
}

static const luaL_Reg functions[] = {
    {"occluder_sphere", occluder_sphere},   {"occluder_solid", occluder_solid},
    {"occluder_body", occluder_body},       {"occluder_close", occluder_close},
    {"occluder_places", occluder_places},   {"shadowed_create", shadowed_create},
    {"shadowed_move", shadowed_move},       {"shadowed_look", shadowed_look},
    {"shadowed_without", shadowed_without}, {"shadowed_caster", shadowed_caster},
    {"shadowed_close", shadowed_close},     {NULL, NULL}};

static const luaL_Reg occluder_methods[] = {{"__gc", occluder_close}, {NULL, NULL}};
static const luaL_Reg shadowed_methods[] = {{"__gc", shadowed_close}, {NULL, NULL}};

void ylmL_open_light_shadow(lua_State *L) {
  ylmL_type(L, OCCLUDER, occluder_methods);
  ylmL_type_has_field(L, occluder_field);
  lua_pop(L, 1);
  ylmL_type(L, SHADOWED, shadowed_methods);
  ylmL_type_has_field(L, shadowed_field);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
