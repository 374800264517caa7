/* shade_relight.c - prepared views with other materials or another camera; lua/ylm/render/relight.lua drives it. */

#include "../binding_product.h"
#include "shade.h"

/* The materials in the table at `i`, by mesh, in memory of the state; NULL: there are none. */
static const ylm_material **read_materials(lua_State *L, int i, size_t meshes) {
  if (lua_isnil(L, i)) return NULL;
  luaL_checktype(L, i, LUA_TTABLE);
  const ylm_material **m = lua_newuserdata(L, (meshes + 1) * sizeof *m);
  for (size_t k = 0; k < meshes; k++) {
    lua_rawgeti(L, i, (int)k + 1);
    m[k] = lua_toboolean(L, -1) ? ylmL_material_check(L, lua_gettop(L)) : NULL;
    lua_pop(L, 1);
  }
  return m;
}

/* shade_change(view, {camera: 10 numbers | nil, blind, materials: by mesh, false for one that is the same, | nil,
   meshes: how many, nearest, product | nil, keep, threads, progress}) -> view */
static int shade_change(lua_State *L) {
  static const char *const names[] = {"camera",  "blind", "materials", "meshes",   "nearest",
                                      "product", "keep",  "threads",   "progress", NULL};
  enum { CAMERA = 3, BLIND, MATERIALS, MESHES, NEAREST, PRODUCT, KEEP, THREADS, PROGRESS };
  ylmL_named(L, 2, names);
  const ylm_shade_view *from = ylmL_shade_view(L, 1);
  bool moved = !lua_isnil(L, CAMERA);
  double c[10] = {0};
  ylm_error e = {0};
  ylmL_progress p;
  if (moved) ylmL_scene_numbers(L, CAMERA, 10, c);
  ylm_camera camera = {{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}, c[9]};
  ylm_shade_change change = {.camera = moved ? &camera : NULL,
                             .blind = lua_toboolean(L, BLIND),
                             .materials =
                                 read_materials(L, MATERIALS, (size_t)luaL_checknumber(L, MESHES)),
                             .nearest = lua_toboolean(L, NEAREST),
                             .product = ylmL_product_method(L, PRODUCT),
                             .keep = lua_toboolean(L, KEEP)};
  const ylm_progress *progress = ylmL_progress_begin(L, PROGRESS, &p);
  ylm_shade_view **v = lua_newuserdata(L, sizeof *v);
  *v = NULL;
  luaL_getmetatable(L, YLML_SHADE_VIEW);
  lua_setmetatable(L, -2);
  ylm_shade_stats stats = {0};
  ylm_status s =
      ylm_shade_view_change(from, &change, (int)luaL_optnumber(L, THREADS, 0), progress, v, &e);
  if (s == YLM_OK) ylm_shade_view_stats(*v, &stats);
  ylmL_charge(L, stats.bytes);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* shade_stages(view) -> {rows, rotation, product, light, dot}: seconds of all threads since the view was made */
static int shade_stages(lua_State *L) {
  ylm_shade_stages s;
  ylm_shade_view_stages(ylmL_shade_view(L, 1), &s);
  lua_newtable(L);
  ylmL_set_number(L, "rows", s.rows);
  ylmL_set_number(L, "rotation", s.rotation);
  ylmL_set_number(L, "product", s.product);
  ylmL_set_number(L, "light", s.light);
  ylmL_set_number(L, "dot", s.dot);
  return 1;
}

static const luaL_Reg functions[] = {
    {"shade_change", shade_change}, {"shade_stages", shade_stages}, {NULL, NULL}};

void ylmL_open_shade_relight(lua_State *L) { luaL_setfuncs(L, functions, 0); }
