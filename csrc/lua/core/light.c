/* light.c - ylm.lights: sets of lights, and the evaluation of any object's light field. */
#include "../binding.h"

#include <math.h>
#include <string.h>

#include "ylm_light_emitter.h"
#include "ylm_light_virtual.h"
#include "ylm_sh.h"

/* An object of another type whose light field a set adds. */
typedef struct foreign {
  void *object;
  ylmL_field_of *get;
} foreign;

/* A set, which comes first: ylmL_lights_check. The set keeps foreign objects in the registry. */
typedef struct lights {
  ylm_light_set *set; /* NULL once closed */
  foreign *other;     /* [others] */
  size_t others;
  int keep;
} lights;

static const ylm_field *field_of(void *object) {
  const lights *l = object;
  for (size_t i = 0; i < l->others; i++)
    if (!l->other[i].get(l->other[i].object)) return NULL;
  return l->set ? ylm_light_set_field(l->set) : NULL;
}

/* Lights without a set, on the stack. */
static lights *push_lights(lua_State *L) {
  lights *l = lua_newuserdata(L, sizeof *l);
  *l = (lights){.keep = LUA_NOREF};
  luaL_getmetatable(L, YLM_LIGHTS);
  lua_setmetatable(L, -2);
  return l;
}

ylm_light_set **ylmL_lights_new(lua_State *L) { return &push_lights(L)->set; }

/* The lights on top of the stack, made with a status. */
static int made(lua_State *L, const lights *l, ylm_status s, const ylm_error *e) {
  if (s == YLM_OK) ylmL_charge(L, ylm_light_set_count(l->set) * 160);
  return ylmL_result(L, 1, s, e);
}

/* The double array at stack index i; raises otherwise. */
static const ylmL_array *doubles(lua_State *L, int i) {
  const ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_DOUBLE) luaL_argerror(L, i, "a double array expected");
  return a;
}

/* Source i of the list at 1; foreign objects go to `l` and to the table at 2. */
static ylm_light_source read_source(lua_State *L, int i, lights *l) {
  ylm_light_source s = {0};
  lua_rawgeti(L, 1, i);
  if (lua_istable(L, -1)) {
    lua_rawgeti(L, -1, 1);
    lua_rawgeti(L, -2, 2);
    const ylmL_array *a = doubles(L, lua_gettop(L));
    s.kind = luaL_checkstring(L, -2); /* both live as long as the list */
    s.record = a->data;
    s.numbers = a->count;
    lua_pop(L, 2);
  } else if (ylmL_test(L, -1, YLM_LIGHTS))
    s.set = ylmL_lights_check(L, lua_gettop(L));
  else {
    s.field = ylmL_field_check(L, lua_gettop(L));
    l->other[l->others++] = (foreign){lua_touserdata(L, -1), ylmL_field_getter(L, -1)};
    ylmL_note_part(L);
    lua_pushvalue(L, -1);
    lua_rawseti(L, 2, (int)l->others);
  }
  lua_pop(L, 1);
  return s;
}

/* A set keeps the foreign objects of sets that are joined to it. */
static void take_foreign(lua_State *L, int i, lights *l) {
  const lights *from;
  lua_rawgeti(L, 1, i);
  from = ylmL_test(L, -1, YLM_LIGHTS);
  if (from && from->others) {
    memcpy(l->other + l->others, from->other, from->others * sizeof *l->other);
    l->others += from->others;
    lua_pushvalue(L, -1);
    lua_rawseti(L, 2, (int)lua_rawlen(L, 2) + 1);
  }
  lua_pop(L, 1);
}

/* How many foreign objects a set of the list at 1 may have. */
static size_t count_foreign(lua_State *L, int n) {
  size_t all = 0;
  for (int i = 1; i <= n; i++) {
    lua_rawgeti(L, 1, i);
    const lights *from = ylmL_test(L, -1, YLM_LIGHTS);
    all += from ? from->others : 1;
    lua_pop(L, 1);
  }
  return all;
}

/* lights_create({{kind, records: double array} | lights | object with a light field ..})
   -> lights */
static int lights_create(lua_State *L) {
  ylm_error e = {0};
  luaL_checktype(L, 1, LUA_TTABLE);
  lua_settop(L, 1);
  luaL_checkstack(L, 20, "lights_create");
  int n = (int)lua_rawlen(L, 1);
  lua_newtable(L);
  ylm_light_source *source = lua_newuserdata(L, ((size_t)n + 1) * sizeof *source);
  lights *l = push_lights(L);
  l->other = ylm_alloc(count_foreign(L, n), sizeof *l->other);
  if (!l->other) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (int i = 0; i < n; i++) {
    source[i] = read_source(L, i + 1, l);
    take_foreign(L, i + 1, l);
  }
  if (l->others) {
    lua_pushvalue(L, 2);
    l->keep = luaL_ref(L, LUA_REGISTRYINDEX);
  }
  return made(L, l, ylm_light_set_create((size_t)n, source, &l->set, &e), &e);
}

/*
** lights_spheres(at [n][3], radius [n] or [1], radiance [n][3], or [3] for all, [n] or [1] of grey)
** -> lights. Arrays are double.
*/
static int lights_spheres(lua_State *L) {
  ylm_error e = {0};
  const ylmL_array *at = doubles(L, 1), *r = doubles(L, 2), *c = doubles(L, 3);
  size_t n = at->count / 3;
  bool rows = c->axes == 2;
  if (at->count % 3 || (r->count != 1 && r->count != n) ||
      (rows ? c->count != 3 * n : c->count != 1 && c->count != 3 && c->count != n))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *all = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 4}); /* collected by Lua */
  if (!all) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *radius = all->data, *rgb = radius + n;
  const double *radii = r->data, *colours = c->data;
  for (size_t i = 0; i < n; i++) {
    radius[i] = radii[r->count == 1 ? 0 : i];
    for (size_t a = 0; a < 3; a++)
      rgb[3 * i + a] = colours[rows ? 3 * i + a : c->count == 3 ? a : c->count == 1 ? 0 : i];
  }
  lights *l = push_lights(L);
  return made(L, l, ylm_light_set_spheres(n, at->data, radius, rgb, &l->set, &e), &e);
}

/* lights_textured(texels float [h][w][3], {corner, u, v: 9 numbers}, scale, tolerance, largest,
                   exact, horizon {x, y, z} | nil) -> lights, number of parts */
static int lights_textured(lua_State *L) {
  ylm_error e = {0};
  double horizon[3];
  size_t parts;
  lua_settop(L, 7);
  ylm_light_texture t = ylmL_light_texture(L);
  bool exact = lua_toboolean(L, 6), cut = lua_istable(L, 7);
  for (int a = 0; cut && a < 3; a++) {
    lua_rawgeti(L, 7, a + 1);
    horizon[a] = (double)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  lights *l = push_lights(L);
  ylm_status s = ylm_light_set_textured(&t, exact, cut ? horizon : NULL, &l->set, &parts, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  ylmL_charge(L, parts * 300 + t.width * t.height * 12);
  ylmL_push_count(L, parts);
  return 2;
}

/* lights_sampled(at double [n][3], coefficients double [n][3][(lmax+1)^2], lmax, power) -> lights */
static int lights_sampled(lua_State *L) {
  ylm_error e = {0};
  const ylmL_array *at = doubles(L, 1), *c = doubles(L, 2);
  ylm_light_sampled s = {.n = at->count / 3,
                         .at = at->data,
                         .lmax = (int)luaL_checknumber(L, 3),
                         .coefficients = c->data,
                         .power = (double)luaL_checknumber(L, 4)};
  if (s.lmax < 0 || s.lmax > YLM_LIGHT_LMAX || at->count % 3 ||
      c->count != 3 * s.n * ylm_sh_count(s.lmax))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  lights *l = push_lights(L);
  ylm_status status = ylm_light_set_sampled(&s, &l->set, &e);
  if (status == YLM_OK) ylmL_charge(L, (at->count + c->count) * sizeof(double));
  return ylmL_result(L, 1, status, &e);
}

static int lights_close(lua_State *L) {
  lights *l = ylmL_check(L, 1, YLM_LIGHTS);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_light_set_free(l->set);
  ylm_free(l->other);
  luaL_unref(L, LUA_REGISTRYINDEX, l->keep);
  *l = (lights){.keep = LUA_NOREF};
  ylmL_disown(L, 1);
  return 0;
}

/* lights_count(lights) -> number, or nil once closed; of these spheres; whether all can be
   followed; whether a tree sums some of them to a tolerance; whether some are virtual lights */
static int lights_count(lua_State *L) {
  const lights *l = ylmL_check(L, 1, YLM_LIGHTS);
  if (!l->set) return 0;
  ylmL_push_count(L, ylm_light_set_count(l->set));
  ylmL_push_count(L, ylm_light_set_sphere_count(l->set));
  lua_pushboolean(L, ylm_light_set_is_listable(l->set));
  lua_pushboolean(L, ylm_light_set_sphere_count(l->set) > 0 || ylm_light_set_has_virtual(l->set));
  lua_pushboolean(L, ylm_light_set_has_virtual(l->set));
  return 5;
}

/* Rows of `width` numbers as a double array. */
static bool push_rows(lua_State *L, const double *from, size_t n, size_t width) {
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, width});
  if (a) ylm_copy(a->data, from, n * width * sizeof *from);
  return a != NULL;
}

/* Centres [n][3], radii [n] and radiances [n][3] of spheres. */
static bool push_spheres(lua_State *L, size_t n, const ylm_light *sphere) {
  ylmL_array *at = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 3});
  ylmL_array *radius = at ? ylmL_array_new(L, YLM_DOUBLE, 1, (size_t[]){n}) : NULL;
  ylmL_array *radiance = radius ? ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 3}) : NULL;
  for (size_t i = 0; radiance && i < n; i++) {
    memcpy((double *)at->data + 3 * i, sphere[i].at, sizeof sphere->at);
    ((double *)radius->data)[i] = sphere[i].radius;
    memcpy((double *)radiance->data + 3 * i, sphere[i].radiance, sizeof sphere->radiance);
  }
  return radiance != NULL;
}

/* Emissions of triangles, then of disks: [..][6]. */
static bool push_emission(lua_State *L, const ylm_light_surfaces *s) {
  size_t nt = 6 * s->triangles, nd = 6 * s->disks;
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){s->triangles + s->disks, 6});
  if (a) ylm_copy(a->data, s->triangle_emission, nt * sizeof(double));
  if (a) ylm_copy((double *)a->data + nt, s->disk_emission, nd * sizeof(double));
  return a != NULL;
}

/* lights_surfaces(lights, tiles a side of an image) -> spheres: at [n][3], radius [n], radiance
   [n][3]; flat ones: triangles [t][9], disks [d][7], radiance and horizon of both [t+d][6], the
   numbers of triangles of images, which are the last */
static int lights_surfaces(lua_State *L) {
  luaL_checkstack(L, 20, "lights_surfaces");
  const ylm_light_surfaces *s = ylmL_light_surfaces(L, 1, (size_t)luaL_checknumber(L, 2));
  bool ok = s && push_spheres(L, s->spheres, s->sphere) &&
            push_rows(L, s->triangle, s->triangles, 9) && push_rows(L, s->disk, s->disks, 7) &&
            push_emission(L, s);
  if (!ok) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  lua_createtable(L, (int)s->images, 0);
  for (size_t i = 0; i < s->images; i++) {
    ylmL_push_count(L, s->image[i].triangles);
    lua_rawseti(L, -2, (int)i + 1);
  }
  return 7;
}

/* has_field(value) -> true for an object with a light field */
static int has_field(lua_State *L) {
  bool yes = lua_type(L, 1) == LUA_TUSERDATA && luaL_getmetafield(L, 1, "__field");
  lua_pushboolean(L, yes);
  return 1;
}

/* field_quantity(object) -> what its light field holds, whether that jumps at surfaces */
static int field_quantity(lua_State *L) {
  ylm_quantity q = ylmL_field_check(L, 1)->quantity;
  lua_pushstring(L, ylm_quantity_name(q));
  lua_pushboolean(L, ylm_quantity_jumps(q));
  return 2;
}

enum { OBJECT = 1, POINTS };

typedef struct query_form {
  int lmax, derivatives, threads, isa; /* isa: -1, the one in use */
  int channels, metric;                /* 0 luminance, 1 rgb; metric -1: none */
  bool rough, narrow;
  int progress, out[3]; /* on the stack */
} query_form;

static const ylmL_entry query_entries[] = {
    YLML(query_form, lmax, "lmax", INT),
    YLML(query_form, channels, "channels", CHOICE, .choices = ylmL_channels_choices,
         .optional = true),
    YLML(query_form, derivatives, "derivatives", INT),
    YLML(query_form, metric, "metric", CHOICE, .choices = ylmL_channels_choices, .optional = true),
    YLML(query_form, threads, "threads", INT, .optional = true),
    YLML(query_form, progress, "progress", VALUE),
    YLML(query_form, out[0], "value", VALUE),
    YLML(query_form, out[1], "gradient", VALUE),
    YLML(query_form, out[2], "hessian", VALUE),
    YLML(query_form, isa, "isa", CHOICE, .choices = ylmL_isa_choices, .optional = true),
    YLML(query_form, rough, "rough", BOOL),
    YLML(query_form, narrow, "narrow", BOOL),
    {.name = NULL}};

/* The results that are wanted: values, derivatives to an order, a metric where one is named. */
static int wanted(const query_form *f) {
  return YLM_WANT_VALUE | (f->derivatives >= 1 ? YLM_WANT_GRADIENT : 0) |
         (f->derivatives >= 2 ? YLM_WANT_HESSIAN : 0) | (f->metric >= 0 ? YLM_WANT_METRIC : 0) |
         (f->rough ? YLM_WANT_ROUGH : 0);
}

/* Calls the field, or lights by the kernels of a given instruction set (for specs and
   benchmarks). */
static ylm_status call_field(lua_State *L, int isa, const ylm_field *f, const ylm_field_query *q,
                             size_t n, const void *points, ylm_field_result *r, ylm_error *e) {
  if (isa < 0) return ylm_field_evaluate(f, q, n, points, r, e);
  const ylm_light_cut *cut = ylmL_light_cut(L, OBJECT);
  if (cut) return ylm_light_cut_evaluate(cut, (ylm_isa)isa, q, n, points, r, e);
  return ylm_light_set_evaluate(ylmL_lights_check(L, OBJECT), (ylm_isa)isa, q, n, points, r, e);
}

/* Pushes arrays of results for n points: value, gradient, hessian, lambda, norm; nil where one is not wanted. */
static ylm_status push_results(lua_State *L, const query_form *f, const ylm_field_query *q,
                               size_t n, ylm_field_result *r) {
  size_t shape[4] = {n, (size_t)q->channels, (size_t)(q->lmax + 1) * (size_t)(q->lmax + 1), 0};
  ylm_status s = YLM_OK;
  void **slots[3] = {&r->value, &r->gradient, &r->hessian};
  for (int i = 0; i < 3; i++) {
    shape[3] = i == 1 ? 3 : 6;
    if (q->want & (1 << i)) {
      ylmL_array *a = ylmL_array_result(L, f->out[i], q->dtype, i ? 4 : 3, shape, &s);
      *slots[i] = a ? a->data : NULL;
    } else
      lua_pushnil(L);
  }
  for (int i = 0; i < 2; i++) {
    lua_pushnil(L);
    if (q->want & YLM_WANT_METRIC) {
      ylmL_array *a = ylmL_array_result(L, lua_gettop(L), q->dtype, 1, shape, &s);
      lua_remove(L, -2);
      *(i ? &r->norm : &r->lambda) = a ? a->data : NULL;
    }
  }
  return s;
}

/* The box around n points. */
static void box_of(size_t n, const ylmL_array *points, double box[6]) {
  for (int a = 0; a < 3; a++) box[a] = INFINITY, box[3 + a] = -INFINITY;
  for (size_t i = 0; i < 3 * n; i++) {
    double x = ylm_get(points->dtype, points->data, i);
    box[i % 3] = fmin(box[i % 3], x);
    box[3 + i % 3] = fmax(box[3 + i % 3], x);
  }
}

/* Points of double in float, about an origin; the room for both is left on the stack. */
static const void *narrowed(lua_State *L, size_t n, const ylmL_array *points, ylm_field_query *q) {
  double box[6], *origin = lua_newuserdata(L, 3 * sizeof *origin + (3 * n + 1) * sizeof(float));
  float *out = (float *)(void *)(origin + 3);
  box_of(n, points, box);
  ylm_origin(box, origin);
  for (size_t i = 0; i < 3 * n; i++)
    out[i] = (float)(ylm_get(points->dtype, points->data, i) - origin[i % 3]);
  q->dtype = YLM_FLOAT;
  if (origin[0] != 0 || origin[1] != 0 || origin[2] != 0) q->origin = origin;
  return out;
}

/* points_far(points [n][3]) -> whether float keeps too few digits of them: ylm_origin is not 0 */
static int points_far(lua_State *L) {
  const ylmL_array *points = ylmL_array_check(L, 1);
  double box[6], origin[3];
  box_of(points->count / 3, points, box);
  ylm_origin(box, origin);
  lua_pushboolean(L, points->count >= 3 && (origin[0] != 0 || origin[1] != 0 || origin[2] != 0));
  return 1;
}

/*
** field_evaluate(object, points [n][3], {lmax, channels, derivatives, metric | nil, threads,
**                progress, value, gradient, hessian: arrays to be written | nil, isa | nil, rough | nil,
**                narrow | nil: points are of double, results of float})
**   -> value, gradient, hessian, lambda [n], norm [n], inside [n] of 0 and 1, pairs; nil where not
**   wanted
** The dtype is that of the points, unless `narrow` is given.
*/
static int field_evaluate(lua_State *L) {
  query_form f = {.isa = -1, .channels = 0, .metric = -1};
  ylmL_read(L, 3, query_entries, &f);
  const ylm_field *field = ylmL_field_check(L, OBJECT);
  ylmL_array *points = ylmL_array_check(L, POINTS);
  size_t n = points->count / 3;
  ylmL_progress progress;
  ylm_field_query q = {.lmax = f.lmax,
                       .channels = f.channels ? 3 : 1,
                       .want = wanted(&f),
                       .metric_channels = f.metric > 0 ? 3 : 1,
                       .dtype = points->dtype,
                       .threads = f.threads,
                       .progress = ylmL_progress_begin(L, f.progress, &progress)};
  if (points->axes != 2 || points->shape[1] != 3 || q.lmax < 0 || q.lmax > 10000)
    return ylmL_result(L, 0, YLM_ERANGE, NULL);
  const void *at = f.narrow ? narrowed(L, n, points, &q) : points->data;
  ylm_field_result r = {0};
  ylm_status s = push_results(L, &f, &q, n, &r);
  uint8_t *inside = lua_newuserdata(L, n + 1); /* collected whatever happens */
  r.inside = inside;
  ylm_error e = {0};
  if (s == YLM_OK) s = call_field(L, f.isa, field, &q, n, at, &r, &e);
  if (s != YLM_OK) return ylmL_result_progress(L, 0, s, &e, &progress);
  ylmL_array *flags = ylmL_array_new(L, YLM_FLOAT, 1, &n);
  if (!flags) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++) ((float *)flags->data)[i] = inside[i];
  lua_remove(L, -2);
  ylmL_push_count(L, r.pairs);
  return ylmL_result_progress(L, 7, YLM_OK, &e, &progress);
}

/* field_crosses(object, boxes [n][6] of double: min, max) -> array [n] of 0 and 1 */
static int field_crosses(lua_State *L) {
  const ylm_field *f = ylmL_field_check(L, 1);
  const ylmL_array *boxes = doubles(L, 2);
  if (boxes->axes != 2 || boxes->shape[1] != 6) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = boxes->shape[0];
  uint8_t *out = lua_newuserdata(L, n + 1);
  ylm_status s = f->crosses(f, n, boxes->data, out);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  ylmL_array *flags = ylmL_array_new(L, YLM_FLOAT, 1, boxes->shape);
  if (!flags) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++) ((float *)flags->data)[i] = out[i];
  return 1;
}

static const luaL_Reg functions[] = {{"lights_create", lights_create},
                                     {"lights_spheres", lights_spheres},
                                     {"lights_textured", lights_textured},
                                     {"lights_sampled", lights_sampled},
                                     {"lights_close", lights_close},
                                     {"lights_count", lights_count},
                                     {"lights_surfaces", lights_surfaces},
                                     {"has_field", has_field},
                                     {"field_quantity", field_quantity},
                                     {"field_evaluate", field_evaluate},
                                     {"field_crosses", field_crosses},
                                     {"points_far", points_far},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", lights_close}, {NULL, NULL}};

void ylmL_open_light(lua_State *L) {
  ylmL_type(L, YLM_LIGHTS, methods);
  ylmL_type_has_field(L, field_of);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
