/* light_tree.c - ylm.light_cut: the field of a set of lights to a tolerance. */
#include "../binding.h"

#include "ylm_light.h"

#define CUT "ylm.light_cut"

/* A cut keeps its lights in the registry, and looks whether they are still open. */
typedef struct cut {
  ylm_light_cut *cut;
  ylm_light_set **of;
  int lights;
} cut;

static const ylm_field *field_of(void *object) {
  const cut *c = object;
  return c->cut && *c->of ? ylm_light_cut_field(c->cut) : NULL;
}

const ylm_light_cut *ylmL_light_cut(lua_State *L, int i) {
  const cut *c = ylmL_test(L, i, CUT);
  return c ? c->cut : NULL;
}

static int cut_gc(lua_State *L) {
  cut *c = ylmL_check(L, 1, CUT);
  ylm_light_cut_free(c->cut);
  c->cut = NULL;
  luaL_unref(L, LUA_REGISTRYINDEX, c->lights);
  c->lights = LUA_NOREF;
  return 0;
}

/* light_cut(lights, tolerance, threads) -> an object with a light field */
static int light_cut(lua_State *L) {
  ylm_light_set **l = ylmL_check(L, 1, YLM_LIGHTS);
  double tolerance = luaL_checknumber(L, 2);
  int threads = (int)luaL_checknumber(L, 3);
  ylm_error e = {YLM_OK, ""};
  ylmL_lights_check(L, 1);
  cut *c = lua_newuserdata(L, sizeof *c);
  *c = (cut){NULL, l, LUA_NOREF};
  luaL_getmetatable(L, CUT);
  lua_setmetatable(L, -2);
  lua_pushvalue(L, 1);
  c->lights = luaL_ref(L, LUA_REGISTRYINDEX);
  size_t before = ylm_light_set_tree_bytes(*l);
  ylm_status s = ylm_light_cut_create(*l, tolerance, threads, &c->cut, &e);
  if (s == YLM_OK) ylmL_charge(L, ylm_light_set_tree_bytes(*l) - before);
  return ylmL_result(L, 1, s, &e);
}

/* lights_tree_bytes(lights) -> number */
static int lights_tree_bytes(lua_State *L) {
  ylm_light_set **l = ylmL_check(L, 1, YLM_LIGHTS);
  ylmL_push_count(L, *l ? ylm_light_set_tree_bytes(*l) : 0);
  return 1;
}

static const luaL_Reg functions[] = {
    {"light_cut", light_cut}, {"lights_tree_bytes", lights_tree_bytes}, {NULL, NULL}};
static const luaL_Reg methods[] = {{"__gc", cut_gc}, {NULL, NULL}};

void ylmL_open_light_tree(lua_State *L) {
  ylmL_type(L, CUT, methods);
  ylmL_type_has_field(L, field_of);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
