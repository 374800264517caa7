/* transfer.c - elements and links of scenes as Lua objects. */
#include "transfer.h"

#include <stdlib.h>
#include <string.h>

static void drop(ylmL_held *h) {
  while (h && --h->holds == 0) {
    ylmL_held *of = h->of;
    if (h->extra) h->destroy_extra(h->extra);
    if (h->object) h->destroy(h->object);
    free(h);
    h = of;
  }
}

int ylmL_let_go(lua_State *L) {
  ylmL_held **u = lua_touserdata(L, 1);
  if (!u || !*u) return 0;
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  drop(*u);
  *u = NULL;
  ylmL_disown(L, 1);
  return 0;
}

ylmL_held *ylmL_hold(lua_State *L, const char *type, void (*destroy)(void *), ylmL_held *of) {
  ylmL_held **u = lua_newuserdata(L, sizeof *u);
  *u = NULL;
  luaL_getmetatable(L, type);
  lua_setmetatable(L, -2);
  *u = calloc(1, sizeof **u);
  if (!*u) ylmL_no_memory(L, NULL);
  **u = (ylmL_held){.holds = 1, .destroy = destroy, .of = of};
  if (of) of->holds++;
  return *u;
}

ylmL_held *ylmL_held_check(lua_State *L, int i, const char *type) {
  ylmL_held **u = ylmL_check(L, i, type);
  if (!*u || !(*u)->object) luaL_argerror(L, i, lua_pushfstring(L, "the %s has been closed", type));
  return *u;
}

ylm_transfer *ylmL_transfer(lua_State *L, int i) {
  return ylmL_held_check(L, i, YLML_TRANSFER)->object;
}

static void destroy(void *t) { ylm_transfer_free(t); }

/* Sides by their names, in an array over the lua_State's memory; NULL: the list is nil. */
static const uint8_t *read_sides(lua_State *L, int i, size_t meshes) {
  if (lua_isnil(L, i)) return NULL;
  uint8_t *out = lua_newuserdata(L, meshes + 1);
  for (size_t m = 0; m < meshes; m++) {
    lua_rawgeti(L, i, (int)m + 1);
    out[m] = (uint8_t)luaL_checkoption(L, lua_gettop(L), NULL, ylmL_sides_choices);
    lua_pop(L, 1);
  }
  return out;
}

typedef struct create_form {
  ylm_transfer_form f;
  ylmL_array *inside;
  int sides, progress; /* on the stack */
} create_form;

static const ylmL_entry create_entries[] = {
    YLML(create_form, f.spacing, "spacing", DOUBLE),
    YLML(create_form, f.max_elements, "max_elements", COUNT),
    YLML(create_form, f.links, "links", INT),
    YLML(create_form, f.lmax, "lmax", INT),
    YLML(create_form, sides, "sides", VALUE),
    YLML(create_form, inside, "inside", ARRAY, .optional = true),
    YLML(create_form, f.seed, "seed", UINT64),
    YLML(create_form, f.threads, "threads", INT, .optional = true),
    YLML(create_form, progress, "progress", VALUE),
    {.name = NULL}};

/* transfer_create(scene, {spacing (0: chosen), max_elements, links, lmax, sides: names of all meshes,
   inside float [n][3] or nil, seed, threads, progress}) -> transfer */
static int transfer_create(lua_State *L) {
  create_form c = {.inside = NULL};
  const ylm_scene *scene = ylmL_scene(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylmL_read(L, 2, create_entries, &c);
  c.f.places = c.inside ? c.inside->count / 3 : 0;
  float(*inside)[3] = lua_newuserdata(L, (c.f.places + 1) * sizeof *inside);
  for (size_t i = 0; i < c.f.places; i++) {
    const float *x = (const float *)c.inside->data + 3 * i;
    ylm_scene_enter(scene, (const double[3]){(double)x[0], (double)x[1], (double)x[2]}, inside[i]);
  }
  c.f.inside = (const float(*)[3])inside;
  c.f.mesh_sides = read_sides(L, c.sides, ylm_scene_meshes(scene));
  c.f.progress = ylmL_progress_begin(L, c.progress, &p);
  ylmL_held *h = ylmL_hold(L, YLML_TRANSFER, destroy, NULL);
  ylm_transfer *t;
  ylm_status s = ylm_transfer_create(scene, &c.f, &t, &e);
  h->object = t;
  if (s == YLM_OK) {
    ylm_transfer_stats stats;
    ylm_transfer_look(t, &stats);
    ylmL_charge(L, stats.bytes);
  }
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* transfer_write(t, path) -> true */
static int transfer_write(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = ylm_transfer_write(ylmL_transfer(L, 1), luaL_checkstring(L, 2), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* transfer_read(scene, path) -> transfer */
static int transfer_read(lua_State *L) {
  const ylm_scene *scene = ylmL_scene(L, 1);
  const char *path = luaL_checkstring(L, 2);
  ylm_error e = {0};
  unsigned char *bytes;
  size_t size;
  ylmL_held *h = ylmL_hold(L, YLML_TRANSFER, destroy, NULL);
  ylm_transfer *t = NULL;
  ylm_status s = ylm_file_read(path, (size_t)1 << 40, &bytes, &size, &e);
  if (s == YLM_OK) {
    s = ylm_transfer_read(scene, bytes, size, path, &t, &e);
    ylm_free(bytes);
  }
  h->object = t;
  if (s == YLM_OK) ylmL_charge(L, size);
  return ylmL_result(L, 1, s, &e);
}

/* transfer_stats(t) -> table */
static int transfer_stats(lua_State *L) {
  const ylm_transfer *t = ylmL_transfer(L, 1);
  const ylm_transfer_form *f = ylm_transfer_made(t);
  ylm_transfer_stats s;
  ylm_transfer_look(t, &s);
  lua_newtable(L);
  ylmL_set_count(L, "elements", s.elements);
  ylmL_set_count(L, "degenerate", s.degenerate);
  ylmL_set_count(L, "closed", s.closed);
  ylmL_set_count(L, "rooms", s.rooms);
  ylmL_set_count(L, "dead", s.dead);
  ylmL_set_count(L, "rays", s.rays);
  ylmL_set_count(L, "escaped", s.escaped);
  ylmL_set_count(L, "buried", s.buried);
  ylmL_set_count(L, "lost", s.lost);
  ylmL_set_number(L, "seconds", s.seconds);
  ylmL_set_count(L, "bytes", s.bytes);
  ylmL_set_number(L, "spacing", f->spacing);
  ylmL_set_count(L, "links", (uint64_t)f->links);
  lua_pushinteger(L, f->lmax);
  lua_setfield(L, -2, "lmax");
  return 1;
}

/* transfer_elements(t) -> centre [n][3], normal [n][3], albedo [n][3], area [n], mesh [n] from 1 */
static int transfer_elements(lua_State *L) {
  const ylm_transfer *t = ylmL_transfer(L, 1);
  size_t n = ylm_transfer_count(t);
  ylmL_array *a[5];
  float *centre = lua_newuserdata(L, (3 * n + 1) * sizeof *centre);
  ylm_transfer_elements(t, centre, NULL, NULL, NULL, NULL);
  if (!ylmL_scene_push_places(L, ylm_scene_origin(ylm_transfer_scene(t)), n, centre))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (int i = 1; i < 5; i++) {
    a[i] = ylmL_array_new(L, YLM_FLOAT, i < 3 ? 2 : 1, (size_t[]){n, 3});
    if (!a[i]) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  }
  uint32_t *mesh = a[4]->data; /* numbers of meshes, then these as floats */
  ylm_transfer_elements(t, NULL, a[1]->data, a[3]->data, a[2]->data, mesh);
  for (size_t i = 0; i < n; i++) {
    float number = (float)mesh[i] + 1;
    memcpy(&mesh[i], &number, sizeof number);
  }
  return 5;
}

/* transfer_links(t) -> [n][links] from 1; n + 1 is nothing */
static int transfer_links(lua_State *L) {
  const ylm_transfer *t = ylmL_transfer(L, 1);
  size_t n = ylm_transfer_count(t), links = (size_t)ylm_transfer_made(t)->links;
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, links});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t k = 0; k < a->count; k++)
    ((double *)a->data)[k] = (double)ylm_links_at(ylm_transfer_links(t), k) + 1;
  return 1;
}

/* transfer_escape(t) -> [n][(lmax+1)^2], or nil */
static int transfer_escape(lua_State *L) {
  const ylm_transfer *t = ylmL_transfer(L, 1);
  const float *escape = ylm_transfer_escape(t);
  if (!escape) return 0;
  size_t row = (size_t)ylm_transfer_made(t)->lmax + 1;
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylm_transfer_count(t), row * row});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_copy(a->data, escape, a->count * sizeof(float));
  return 1;
}

static const luaL_Reg functions[] = {{"transfer_create", transfer_create},
                                     {"transfer_stats", transfer_stats},
                                     {"transfer_elements", transfer_elements},
                                     {"transfer_links", transfer_links},
                                     {"transfer_escape", transfer_escape},
                                     {"transfer_read", transfer_read},
                                     {"transfer_write", transfer_write},
                                     {"transfer_close", ylmL_let_go},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};

void ylmL_open_transfer(lua_State *L) {
  ylmL_type(L, YLML_TRANSFER, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
