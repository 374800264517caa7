/* gather.c - light fields of radiosities as Lua objects. */
#include "transfer.h"
#include "ylm_shade.h"

#define YLML_GATHER "ylm.gather"

/* A field that says, while it is asked, that the radiosity is being read. */
typedef struct gathered {
  ylm_field field;
  ylm_gather *gather;
  ylm_walls *walls; /* NULL: nobody has asked */
  ylmL_held *of;
} gathered;

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const gathered *g = f->self;
  const ylm_field *own = ylm_gather_field(g->gather);
  g->of->running++;
  ylm_status s = own->evaluate(own, q, n, points, r, e);
  g->of->running--;
  return s;
}

static void destroy(void *object) {
  gathered *g = object;
  ylm_walls_free(g->walls);
  ylm_gather_free(g->gather);
  ylm_free(g);
}

static ylm_status make(ylmL_held *of, const ylm_gather_form *form, gathered **out, ylm_error *e) {
  gathered *g = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  ylm_status s = ylm_gather_create(of->object, form, &g->gather, e);
  if (s != YLM_OK) {
    ylm_free(g);
    return s;
  }
  g->field = *ylm_gather_field(g->gather);
  g->field.self = g;
  g->field.evaluate = evaluate;
  g->of = of;
  *out = g;
  return YLM_OK;
}

const ylm_field *ylmL_radiosity_default(void *object) {
  ylmL_held *h = *(ylmL_held **)object;
  gathered *g;
  if (!h || !h->object) return NULL;
  if (!h->extra) {
    ylm_gather_form form = ylm_gather_defaults();
    if (make(h, &form, &g, NULL) != YLM_OK) return NULL;
    h->extra = g;
    h->destroy_extra = destroy;
  }
  return &((gathered *)h->extra)->field;
}

ylm_status ylmL_radiosity_busy(lua_State *L, int i) {
  ylmL_held *h = ylmL_held_check(L, i, YLML_RADIOSITY);
  return h->running ? YLM_EBUSY : ylmL_busy(L, i);
}

static const ylm_field *field_of(void *object) {
  ylmL_held *h = *(ylmL_held **)object;
  return h && h->object ? &((gathered *)h->object)->field : NULL;
}

static gathered *check_gather(lua_State *L, int i) {
  return ylmL_held_check(L, i, YLML_GATHER)->object;
}

static const ylmL_entry gather_entries[] = {
    YLML(ylm_gather_form, base, "base", INT),
    YLML(ylm_gather_form, levels, "levels", INT),
    YLML(ylm_gather_form, contrast, "contrast", DOUBLE),
    YLML(ylm_gather_form, spacing, "spacing", DOUBLE),
    YLML(ylm_gather_form, parts, "parts", INT),
    YLML(ylm_gather_form, derivatives, "derivatives", CHOICE,
         .choices = ylmL_gather_derivatives_choices),
    YLML(ylm_gather_form, tolerance, "tolerance", DOUBLE),
    YLML(ylm_gather_form, remember, "remember", BOOL),
    YLML(ylm_gather_form, seed, "seed", UINT64),
    YLML(ylm_gather_form, lamps, "lamps", READ, .read = ylmL_read_scene, .optional = true),
    {.name = NULL}};

/* gather_create(radiosity, {base, levels, contrast, spacing (0: the elements'), parts: 1 indirect + 2 direct,
   derivatives: "cells" | "points", tolerance, remember, seed, lamps: scene | nil}) -> gather */
static int gather_create(lua_State *L) {
  ylmL_held *of = ylmL_held_check(L, 1, YLML_RADIOSITY);
  gathered *g;
  ylm_error e = {0};
  ylm_gather_form f = {.lamps = NULL};
  ylmL_read(L, 2, gather_entries, &f);
  ylmL_held *h = ylmL_hold(L, YLML_GATHER, destroy, of);
  ylm_status s = make(of, &f, &g, &e);
  if (s == YLM_OK) {
    h->object = g;
    ylmL_charge(L, (size_t)(f.base * f.base) * 2000);
  }
  return ylmL_result(L, 1, s, &e);
}

/* gather_walls(gather) -> the bytes of a ylm_grid_walls: the surfaces of its scene, as long as it lives */
static int gather_walls(lua_State *L) {
  gathered *g = check_gather(L, 1);
  const ylm_transfer *t = ylm_radiosity_transfer(g->of->object);
  ylm_status s = g->walls ? YLM_OK : ylm_walls_create(ylm_transfer_scene(t), t, &g->walls);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  ylm_grid_walls walls = ylm_walls_look(g->walls);
  lua_pushlstring(L, (const char *)&walls, sizeof walls);
  return 1;
}

/* Points at `i`, [n][3], relative to the origin of the field's scene. */
static const float (*points_at(lua_State *L, int i, const gathered *g, size_t *n))[3] {
  const ylm_scene *scene = ylm_transfer_scene(ylm_radiosity_transfer(g->of->object));
  return ylmL_scene_places(L, i, ylm_scene_origin(scene), n);
}

/* gather_noise(gather, points, lmax, threads, progress) -> number */
static int gather_noise(lua_State *L) {
  gathered *g = check_gather(L, 1);
  size_t n;
  double quantile;
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 5);
  const float(*x)[3] = points_at(L, 2, g, &n);
  int lmax = (int)luaL_checknumber(L, 3), threads = (int)luaL_optnumber(L, 4, 0);
  const ylm_progress *progress = ylmL_progress_begin(L, 5, &p);
  g->of->running++;
  ylm_status s = ylm_gather_noise(g->gather, n, x, lmax, threads, progress, &quantile, &e);
  g->of->running--;
  lua_pushnumber(L, (lua_Number)quantile);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* gather_validity(gather, points, threads) -> float [n] */
static int gather_validity(lua_State *L) {
  gathered *g = check_gather(L, 1);
  size_t n;
  ylm_error e = {0};
  lua_settop(L, 3);
  const float(*x)[3] = points_at(L, 2, g, &n);
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 1, &n);
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(
      L, 1, ylm_gather_validity(g->gather, n, x, (int)luaL_optnumber(L, 3, 0), a->data, &e), &e);
}

/* gather_stats(gather) -> table */
static int gather_stats(lua_State *L) {
  ylm_gather_stats s;
  ylm_gather_look(check_gather(L, 1)->gather, &s);
  lua_newtable(L);
  ylmL_set_count(L, "points", s.points);
  ylmL_set_count(L, "rays", s.rays);
  ylmL_set_count(L, "shadow_rays", s.shadow_rays);
  ylmL_set_count(L, "invalid", s.invalid);
  ylmL_set_count(L, "bytes", s.bytes);
  return 1;
}

/* gather_lamps(gather, scene): from here on direct light is that of its lamps */
static int gather_lamps(lua_State *L) {
  gathered *g = check_gather(L, 1);
  ylm_error e = {0};
  if (g->of->running) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  lua_settop(L, 2);
  return ylmL_result(L, 1, ylm_gather_lamps(g->gather, ylmL_scene(L, 2), &e), &e);
}

static const luaL_Reg functions[] = {
    {"gather_create", gather_create}, {"gather_noise", gather_noise},
    {"gather_walls", gather_walls},   {"gather_validity", gather_validity},
    {"gather_stats", gather_stats},   {"gather_lamps", gather_lamps},
    {"gather_close", ylmL_let_go},    {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};

void ylmL_open_gather(lua_State *L) {
  ylmL_type(L, YLML_GATHER, methods);
  ylmL_type_has_field(L, field_of);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
