/* texture.c - textures, and the materials that OBJ files name; lua/ylm/material, lua/ylm/geometry. */
#include "../binding.h"
#include "ylm_geom.h"
#include "ylm_image_texture.h"

/* -- textures -------------------------------------------------------------------- */

/* texture_create(float [h][w][c], wrap of u | nil, wrap of v | nil) -> texture of 0 .. 1 */
static int texture_create(lua_State *L) {
  ylm_texture_wrap u = (ylm_texture_wrap)luaL_checkoption(L, 2, "repeat", ylmL_wrap_choices);
  ylm_texture_wrap v = (ylm_texture_wrap)luaL_checkoption(L, 3, "repeat", ylmL_wrap_choices);
  ylmL_array *a = ylmL_array_check(L, 1);
  ylm_error e = {0};
  if (a->dtype != YLM_FLOAT || a->axes != 3) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_texture **t = ylmL_texture_new(L);
  ylm_status s = ylm_texture_create(a->shape[1], a->shape[0], (int)a->shape[2], a->data, t, &e);
  if (s == YLM_OK) ylm_texture_set_wrap(*t, u, v);
  if (s == YLM_OK) ylmL_charge(L, 3 * a->shape[0] * a->shape[1] * sizeof(float));
  return ylmL_result(L, 1, s, &e);
}

static int push_colour(lua_State *L, const float c[3]) {
  for (int i = 0; i < 3; i++) lua_pushnumber(L, (lua_Number)c[i]);
  return 3;
}

/* texture_mean(texture) -> red, green, blue */
static int texture_mean(lua_State *L) {
  float mean[3];
  ylm_texture_mean(ylmL_texture_check(L, 1), mean);
  return push_colour(L, mean);
}

/* mesh_albedo(mesh, texture or false, red, green, blue) -> float [n][3]: this colour times texture and
   colours at the vertices; nothing where there is neither */
static int mesh_albedo(lua_State *L) {
  const ylm_mesh *m = ylmL_mesh_check(L, 1);
  const ylm_texture *t = lua_toboolean(L, 2) && m->uv ? ylmL_texture_check(L, 2) : NULL;
  float base[3];
  for (int c = 0; c < 3; c++) base[c] = (float)luaL_checknumber(L, 3 + c);
  if (!t && !m->colour) return 0;
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){m->vertices, 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  float *to = out->data;
  for (size_t i = 0; i < m->vertices; i++, to += 3) {
    float tint[3] = {1, 1, 1};
    if (t) ylm_texture_at(t, m->uv[2 * i], m->uv[2 * i + 1], tint);
    for (size_t c = 0; c < 3; c++)
      to[c] = base[c] * tint[c] * (m->colour ? m->colour[3 * i + c] : 1);
  }
  return 1;
}

/* -- materials of OBJ files -------------------------------------------------------- */

/* Memory of C that must be freed although Lua may raise. */
typedef struct holder {
  ylm_mesh_groups *groups;
  ylm_mesh_library *library;
  ylm_mesh **part;
  size_t parts;
  unsigned char *bytes;
} holder;

static int holder_free(lua_State *L) {
  holder *h = lua_touserdata(L, 1);
  for (size_t i = 0; h->part && i < h->parts; i++) ylm_mesh_free(h->part[i]);
  ylm_free(h->part);
  ylm_mesh_groups_free(h->groups);
  ylm_mesh_library_free(h->library);
  ylm_free(h->bytes);
  *h = (holder){0};
  return 0;
}

static const luaL_Reg holder_methods[] = {{"__gc", holder_free}, {NULL, NULL}};

static holder *new_holder(lua_State *L) {
  holder *h = lua_newuserdata(L, sizeof *h);
  *h = (holder){0};
  ylmL_type(L, "ylm.mesh_file", holder_methods);
  lua_setmetatable(L, -2);
  return h;
}

static void set_text(lua_State *L, const char *key, const ylm_mesh_text *t) {
  lua_pushstring(L, t->text);
  lua_setfield(L, -2, key);
  ylmL_set_count(L, "line", t->line);
}

/* A list of { name =, line = } of the libraries. */
static void push_libraries(lua_State *L, const ylm_mesh_groups *g) {
  lua_newtable(L);
  for (size_t i = 0; i < g->libraries; i++) {
    lua_newtable(L);
    set_text(L, "name", &g->library[i]);
    lua_rawseti(L, -2, (int)i + 1);
  }
}

/* Splits the mesh, and leaves a list of { mesh =, name =, line = } (without name: before any usemtl). */
static ylm_status push_parts(lua_State *L, const ylm_mesh *mesh, holder *h, ylm_error *e) {
  int used = 0;
  h->parts = h->groups->names + 1;
  h->part = ylm_alloc_zero(h->parts, sizeof(ylm_mesh *));
  if (!h->part) return YLM_ENOMEM;
  ylm_status s = ylm_mesh_split(mesh, h->groups, h->part, e);
  lua_newtable(L);
  for (size_t i = 0; s == YLM_OK && i < h->parts; i++) {
    if (!h->part[i]) continue;
    lua_newtable(L);
    ylm_mesh **m = ylmL_mesh_new(L);
    *m = h->part[i];
    h->part[i] = NULL;
    lua_setfield(L, -2, "mesh");
    if (i > 0) set_text(L, "name", &h->groups->name[i - 1]);
    lua_rawseti(L, -2, ++used);
  }
  return s;
}

/* mesh_read_parts(path, limit of bytes or 0, crease in degrees) -> mesh; of OBJ also its libraries and its parts */
static int mesh_read_parts(lua_State *L) {
  const char *path = luaL_checkstring(L, 1);
  size_t size, limit = (size_t)luaL_checknumber(L, 2);
  double crease = luaL_checknumber(L, 3);
  ylm_error e = {0};
  holder *h = new_holder(L);
  ylm_mesh **m = ylmL_mesh_new(L);
  ylm_status s = ylm_file_read(path, limit, &h->bytes, &size, &e);
  bool ply = s == YLM_OK && ylm_mesh_is_ply(h->bytes, size);
  if (ply)
    s = ylm_mesh_parse_ply(h->bytes, size, path, crease, m, &e);
  else if (s == YLM_OK)
    s = ylm_mesh_parse_obj_groups(h->bytes, size, path, crease, m, &h->groups, &e);
  if (s == YLM_OK && !ply) {
    push_libraries(L, h->groups);
    s = push_parts(L, *m, h, &e);
  }
  return ylmL_result(L, ply ? 1 : 3, s, &e);
}

static void set_colour(lua_State *L, const char *key, bool has, const float c[3]) {
  if (!has) return;
  lua_createtable(L, 3, 0);
  for (int i = 0; i < 3; i++) {
    lua_pushnumber(L, (lua_Number)c[i]);
    lua_rawseti(L, -2, i + 1);
  }
  lua_setfield(L, -2, key);
}

static void push_material(lua_State *L, const ylm_mesh_material *m) {
  lua_newtable(L);
  set_text(L, "name", &m->name);
  set_colour(L, "Kd", m->has_kd, m->kd);
  set_colour(L, "Ks", m->has_ks, m->ks);
  set_colour(L, "Ke", m->has_ke, m->ke);
  if (m->has_ns) ylmL_set_number(L, "Ns", (double)m->ns);
  if (m->map_kd.text) {
    lua_newtable(L);
    set_text(L, "name", &m->map_kd);
    lua_setfield(L, -2, "map_Kd");
  }
}

/* mtl_read(path, limit of bytes or 0) -> list of materials, how many statements are skipped, their names */
static int mtl_read(lua_State *L) {
  const char *path = luaL_checkstring(L, 1);
  size_t size, limit = (size_t)luaL_checknumber(L, 2);
  ylm_error e = {0};
  holder *h = new_holder(L);
  ylm_status s = ylm_file_read(path, limit, &h->bytes, &size, &e);
  if (s == YLM_OK) s = ylm_mesh_parse_mtl(h->bytes, size, path, &h->library, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  lua_newtable(L);
  for (size_t i = 0; i < h->library->count; i++) {
    push_material(L, &h->library->material[i]);
    lua_rawseti(L, -2, (int)i + 1);
  }
  lua_pushinteger(L, (lua_Integer)h->library->skipped);
  lua_pushstring(L, h->library->words);
  return 3;
}

static const luaL_Reg functions[] = {{"texture_create", texture_create},
                                     {"texture_mean", texture_mean},
                                     {"mesh_albedo", mesh_albedo},
                                     {"mesh_read_parts", mesh_read_parts},
                                     {"mtl_read", mtl_read},
                                     {NULL, NULL}};

void ylmL_open_texture(lua_State *L) { luaL_setfuncs(L, functions, 0); }
