/* gltf.c - glTF files as tables. */
#include "gltf.h"

#include <string.h>

#include "ylm_gltf.h"

#define YLML_GLTF "ylm.gltf_file"

static int file_close(lua_State *L) {
  ylm_gltf **g = lua_touserdata(L, 1);
  if (g) ylm_gltf_free(*g);
  if (g) *g = NULL;
  return 0;
}

static const luaL_Reg file_methods[] = {{"__gc", file_close}, {NULL, NULL}};

/* NULL: no entry. */
static void set_string(lua_State *L, const char *key, const char *s) {
  if (!s) return;
  lua_pushstring(L, s);
  lua_setfield(L, -2, key);
}

static void set_doubles(lua_State *L, const char *key, const double *x, int n) {
  lua_createtable(L, n, 0);
  for (int i = 0; i < n; i++) {
    lua_pushnumber(L, (lua_Number)x[i]);
    lua_rawseti(L, -2, i + 1);
  }
  lua_setfield(L, -2, key);
}

static void set_floats(lua_State *L, const char *key, const float *x, int n) {
  double d[4];
  for (int i = 0; i < n; i++) d[i] = (double)x[i];
  set_doubles(L, key, d, n);
}

static void set_wraps(lua_State *L, const char *key, const ylm_texture_wrap wrap[2]) {
  static const char *const names[] = {"repeat", "mirror", "clamp"};
  lua_createtable(L, 2, 0);
  for (int i = 0; i < 2; i++) {
    lua_pushstring(L, names[wrap[i]]);
    lua_rawseti(L, -2, i + 1);
  }
  lua_setfield(L, -2, key);
}

static void push_material(lua_State *L, const ylm_gltf_material *m) {
  static const char *const alpha[] = {"opaque", "mask", "blend"};
  lua_createtable(L, 0, 14);
  set_string(L, "name", m->name);
  set_floats(L, "base", m->base, 4);
  set_floats(L, "emission", m->emission, 3);
  ylmL_set_number(L, "metallic", (double)m->metallic);
  ylmL_set_number(L, "roughness", (double)m->roughness);
  ylmL_set_number(L, "f0", (double)m->f0);
  ylmL_set_number(L, "cutoff", (double)m->cutoff);
  set_string(L, "alpha", alpha[m->alpha]);
  set_string(L, "extras", m->extras);
  ylmL_set_boolean(L, "unlit", m->unlit);
  ylmL_set_boolean(L, "both_sides", m->both_sides);
  if (m->base_image >= 0) ylmL_set_count(L, "base_image", (uint64_t)m->base_image + 1);
  set_wraps(L, "base_wrap", m->base_wrap);
  set_wraps(L, "emission_wrap", m->emission_wrap);
  ylmL_set_boolean(L, "emission_uvs",
                   m->base_set == m->emission_set &&
                       memcmp(m->base_map, m->emission_map, sizeof m->base_map) == 0);
  if (m->emission_image >= 0) ylmL_set_count(L, "emission_image", (uint64_t)m->emission_image + 1);
}

static void push_lamp(lua_State *L, const ylm_gltf_lamp *l) {
  static const char *const kind[] = {"point", "spot", "directional", "profile"};
  lua_createtable(L, 0, 9);
  set_string(L, "name", l->name);
  set_string(L, "kind", kind[l->kind]);
  set_doubles(L, "at", l->at, 3);
  set_doubles(L, "direction", l->direction, 3);
  set_doubles(L, "intensity", l->intensity, 3);
  if (l->kind == YLM_GLTF_PROFILE) {
    set_doubles(L, "across", l->across, 3);
    ylmL_set_count(L, "profile", l->profile + 1);
  }
  ylmL_set_number(L, "inner", l->inner);
  ylmL_set_number(L, "outer", l->outer);
  set_string(L, "extras", l->extras);
  ylmL_set_boolean(L, "range", l->range);
}

static void push_camera(lua_State *L, const ylm_gltf_camera *c) {
  lua_createtable(L, 0, 5);
  set_string(L, "name", c->name);
  set_doubles(L, "from", c->from, 3);
  set_doubles(L, "forward", c->forward, 3);
  set_doubles(L, "up", c->up, 3);
  ylmL_set_number(L, "yfov", c->yfov);
  set_string(L, "extras", c->extras);
}

/* Gives the mesh to an object on the stack. */
static void push_piece(lua_State *L, ylm_gltf_piece *p) {
  lua_createtable(L, 0, 3);
  ylm_mesh **m = ylmL_mesh_new(L);
  *m = p->mesh;
  p->mesh = NULL;
  lua_setfield(L, -2, "mesh");
  set_string(L, "name", p->name);
  set_string(L, "extras", p->extras);
  ylmL_set_number(L, "alpha", (double)p->alpha);
  if (p->grouped) set_floats(L, "tint", p->tint, 3);
  if (p->material >= 0) ylmL_set_count(L, "material", (uint64_t)p->material + 1);
}

static void push_image(lua_State *L, ylm_image **image) {
  if (!*image) {
    lua_pushboolean(L, 0);
    return;
  }
  ylm_image **i = ylmL_image_new(L);
  *i = *image;
  *image = NULL;
}

/* A list `key` of n things, pushed one by one. */
#define LIST(key, n, push)                                                                         \
  lua_createtable(L, (int)(n), 0);                                                                 \
  for (size_t i = 0; i < (n); i++) {                                                               \
    push;                                                                                          \
    lua_rawseti(L, -2, (int)i + 1);                                                                \
  }                                                                                                \
  lua_setfield(L, -2, key);

static void push_file(lua_State *L, ylm_gltf *g) {
  lua_createtable(L, 0, 9);
  LIST("pieces", g->pieces, push_piece(L, &g->piece[i]))
  LIST("materials", g->materials, push_material(L, &g->material[i]))
  LIST("lamps", g->lamps, push_lamp(L, &g->lamp[i]))
  LIST("cameras", g->cameras, push_camera(L, &g->camera[i]))
  LIST("images", g->images, push_image(L, &g->image[i]))
  LIST("profiles", g->profiles,
       lua_pushlstring(L, g->profile[i].data ? (char *)g->profile[i].data : "", g->profile[i].size))
  LIST("notes", g->notes, lua_pushstring(L, g->note[i]))
  set_string(L, "extras", g->extras);
  ylmL_set_count(L, "nodes", g->nodes);
  ylmL_set_count(L, "triangles", g->triangles);
}

typedef struct read_form {
  const char *path;
  size_t file_size;
  ylm_gltf_options o;
  bool images;
} read_form;

static const ylmL_entry read_entries[] = {
    YLML(read_form, path, "path", STRING),
    YLML(read_form, file_size, "file_size", COUNT),
    YLML(read_form, o.triangles, "triangles", UINT64),
    YLML(read_form, o.texels, "texels", UINT64),
    YLML(read_form, o.scene, "scene", INT),
    YLML(read_form, images, "images", BOOL),
    YLML(read_form, o.groups, "groups", INT, .optional = true),
    {.name = NULL}};

/* gltf_read { path =, file_size =, triangles =, texels =, scene =, images =, groups = } -> table */
static int gltf_read(lua_State *L) {
  read_form f = {.path = NULL};
  ylmL_read(L, 1, read_entries, &f);
  f.o.no_images = !f.images;
  ylm_error e = {0};
  ylm_gltf **g = lua_newuserdata(L, sizeof *g);
  *g = NULL;
  ylmL_type(L, YLML_GLTF, file_methods);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_gltf_read(f.path, f.file_size, &f.o, g, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  luaL_checkstack(L, 12, "gltf_read");
  push_file(L, *g);
  return 1;
}

void ylmL_open_gltf(lua_State *L) {
  static const luaL_Reg functions[] = {{"gltf_read", gltf_read}, {NULL, NULL}};
  luaL_setfuncs(L, functions, 0);
}
