/* shade_relight.c - prepared views with other materials or another camera; lua/ylm/render/relight.lua drives it. */

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

typedef struct change_form {
  ylm_shade_change change;
  ylm_camera camera;
  size_t meshes;
  int threads, materials, progress; /* materials, progress: on the stack */
} change_form;

/* A camera, which the change then points to. */
static void read_moved(lua_State *L, int i, void *field) {
  change_form *f = (change_form *)(void *)((char *)field - offsetof(change_form, camera));
  ylmL_read_camera(L, i, &f->camera);
  f->change.camera = &f->camera;
}

static const ylmL_entry change_entries[] = {
    YLML(change_form, camera, "camera", READ, .read = read_moved, .optional = true),
    YLML(change_form, change.blind, "blind", BOOL),
    YLML(change_form, materials, "materials", VALUE),
    YLML(change_form, meshes, "meshes", COUNT),
    YLML(change_form, change.nearest, "nearest", BOOL),
    YLML(change_form, change.product, "product", CHOICE, .choices = ylmL_sh_product_choices,
         .optional = true),
    YLML(change_form, change.keep, "keep", BOOL),
    YLML(change_form, threads, "threads", INT, .optional = true),
    YLML(change_form, progress, "progress", VALUE),
    {.name = NULL}};

/* shade_change(view, {camera: 10 numbers | nil, blind, materials: by mesh, false for one that is the same, | nil,
   meshes: how many, nearest, product | nil, keep, threads, progress}) -> view */
static int shade_change(lua_State *L) {
  change_form f = {.threads = 0};
  ylmL_read(L, 2, change_entries, &f);
  const ylm_shade_view *from = ylmL_shade_view(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  f.change.materials = read_materials(L, f.materials, f.meshes);
  const ylm_progress *progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_shade_view **v = lua_newuserdata(L, sizeof *v);
  *v = NULL;
  luaL_getmetatable(L, YLML_SHADE_VIEW);
  lua_setmetatable(L, -2);
  ylm_shade_stats stats = {0};
  ylm_status s = ylm_shade_view_change(from, &f.change, f.threads, progress, v, &e);
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
