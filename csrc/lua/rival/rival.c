/* rival.c - opens ylm.c.rival, which registers libylm_rival.so, and binds what shades by lamps. For
   lua/ylm/library.lua, lua/ylm/render/zonal.lua and lua/ylm/render/gather.lua. */
#include "ylm_rival.h"

#include "../binding.h"

/* The array at `i`, of n elements of a type. */
static void *numbers(lua_State *L, int i, ylm_dtype t, size_t n, ylm_status *s) {
  ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != t) *s = YLM_ETYPE;
  if (a->count != n) *s = YLM_ESHAPE;
  return a->data;
}

/* zonal({position [n][3], normal [n][3], lobe [n] from 0 or below, eye x, y, z}, lmax,
   zonal double [lobes][rows][3][lmax+1], {at [m][3], radius [m], radiance [m][3]}, threads, out [n][3]) -> out */
static int zonal(lua_State *L) {
  lua_settop(L, 6);
  ylmL_array *z = ylmL_array_check(L, 3), *out = ylmL_array_check(L, 6);
  ylm_rival_points p = {.n = out->count / 3, .lmax = (int)luaL_checknumber(L, 2)};
  ylm_rival_lamps lamps = {0};
  ylm_status s = z->axes == 4 && z->shape[2] == 3 && p.lmax >= 0 &&
                         z->shape[3] == (size_t)p.lmax + 1 && z->dtype == YLM_DOUBLE
                     ? YLM_OK
                     : YLM_ESHAPE;
  for (int i = 1; i <= 6; i++) lua_rawgeti(L, 1, i);
  for (int i = 1; i <= 3; i++) lua_rawgeti(L, 4, i);
  p.position = numbers(L, 7, YLM_FLOAT, 3 * p.n, &s);
  p.normal = numbers(L, 8, YLM_FLOAT, 3 * p.n, &s);
  p.lobe = numbers(L, 9, YLM_FLOAT, p.n, &s);
  for (int a = 0; a < 3; a++) p.eye[a] = (double)luaL_checknumber(L, 10 + a);
  lamps.n = ylmL_array_check(L, 14)->count;
  lamps.at = numbers(L, 13, YLM_FLOAT, 3 * lamps.n, &s);
  lamps.radius = numbers(L, 14, YLM_FLOAT, lamps.n, &s);
  lamps.radiance = numbers(L, 15, YLM_FLOAT, 3 * lamps.n, &s);
  if (out->dtype != YLM_FLOAT) s = YLM_ETYPE;
  if (s == YLM_OK) {
    p.lobes = z->shape[0], p.rows = z->shape[1], p.zonal = z->data;
    for (size_t i = 0; i < p.n; i++)
      if (!(p.lobe[i] < (float)p.lobes)) s = YLM_ERANGE;
  }
  if (s == YLM_OK) s = ylm_rival_zonal(&p, &lamps, (int)luaL_optnumber(L, 5, 0), out->data);
  lua_settop(L, 6);
  return ylmL_result(L, 1, s, NULL);
}

/* many() -> what shade_rivals of ylm.c.scene takes */
static int many(lua_State *L) {
  lua_pushlightuserdata(L, (void *)(uintptr_t)ylm_rival_many());
  return 1;
}

static const luaL_Reg functions[] = {{"zonal", zonal}, {"many", many}, {NULL, NULL}};

int luaopen_ylm_c_rival(lua_State *L) {
  ylmL_check_abi(L);
  ylm_rival_register();
  lua_newtable(L);
  luaL_setfuncs(L, functions, 0);
  return 1;
}
