/* light_photometry.c - binds tables of intensities, and photometric files. Arguments come sorted from lua/ylm/photometry. */
#include <math.h>
#include <string.h>

#include "../binding.h"
#include "ylm_light_photometry.h"

#define PHOTOMETRY "ylm.photometric_table"

/* A larger file is none of a lamp. */
#define LARGEST_FILE ((size_t)1 << 26)

/* A table, and the file that it came from or would be. */
typedef struct photometry {
  ylm_light_photometry *table; /* NULL once closed */
  ylm_light_photometry_file file;
} photometry;

static int photometry_close(lua_State *L) {
  photometry *p = ylmL_check(L, 1, PHOTOMETRY);
  ylm_light_photometry_free(p->table);
  ylm_light_photometry_file_free(&p->file);
  *p = (photometry){0};
  ylmL_disown(L, 1);
  return 0;
}

static const luaL_Reg methods[] = {{"__gc", photometry_close}, {NULL, NULL}};

static photometry *new_photometry(lua_State *L) {
  photometry *p = lua_newuserdata(L, sizeof *p);
  *p = (photometry){0};
  ylmL_type(L, PHOTOMETRY, methods);
  lua_setmetatable(L, -2);
  return p;
}

static const photometry *check(lua_State *L) {
  const photometry *p = ylmL_check(L, 1, PHOTOMETRY);
  if (!p->table) luaL_argerror(L, 1, "the photometry has been closed");
  return p;
}

static ylm_status make_table(photometry *p, bool linear, ylm_error *e) {
  const ylm_light_photometry_file *f = &p->file;
  ylm_light_photometry_grid g = {f->angles, f->planes, f->angle, f->plane, f->candela, linear};
  return ylm_light_photometry_create(&g, &p->table, e);
}

/* Makes the table; `lumens` above 0: with that flux. */
static ylm_status finish(photometry *p, bool linear, double lumens, ylm_error *e) {
  ylm_status s = make_table(p, linear, e);
  if (s != YLM_OK || !(lumens > 0)) return s;
  double flux = ylm_light_photometry_flux(p->table, 0, 180);
  if (!(flux > 0)) return ylm_fail(e, YLM_EDOMAIN, "lumens: all intensities are 0");
  for (size_t i = 0; i < p->file.planes * p->file.angles; i++) p->file.candela[i] *= lumens / flux;
  ylm_light_photometry_free(p->table);
  p->table = NULL;
  return make_table(p, linear, e);
}

static int made(lua_State *L, const photometry *p, ylm_status s, const ylm_error *e) {
  if (s == YLM_OK) ylmL_charge(L, 2 * ylm_light_photometry_bytes(p->table));
  return ylmL_result(L, 1, s, e);
}

/* Arguments of photometry_read. */
typedef struct read_form {
  const char *path, *factors, *bytes;
  int lamps;
  double tilt, lumens;
  bool linear;
} read_form;

static const ylmL_entry read_entries[] = {
    YLML(read_form, path, "path", STRING),
    YLML(read_form, factors, "factors", STRING, .optional = true),
    YLML(read_form, bytes, "bytes", STRING, .optional = true),
    YLML(read_form, lamps, "lamps", INT),
    YLML(read_form, tilt, "tilt", DOUBLE, .optional = true),
    YLML(read_form, lumens, "lumens", DOUBLE, .optional = true),
    YLML(read_form, linear, "linear", BOOL),
    {.name = NULL}};

/* photometry_read { path, bytes = those of the file, a text | nil, factors = path of a file that TILT= names | nil, lamps,
                     tilt, lumens, linear } -> table */
static int photometry_read(lua_State *L) {
  ylm_error e = {0};
  read_form f = {.tilt = NAN};
  ylmL_read(L, 1, read_entries, &f);
  photometry *p = new_photometry(L);
  unsigned char *bytes = NULL, *factors = NULL;
  size_t size, factors_size = 0;
  ylm_status s = YLM_OK;
  if (f.bytes)
    bytes = ylm_alloc_copy(f.bytes, size = strlen(f.bytes), 1);
  else
    s = ylm_file_read(f.path, LARGEST_FILE, &bytes, &size, &e);
  if (s == YLM_OK && !bytes) s = YLM_ENOMEM;
  if (s == YLM_OK && f.factors)
    s = ylm_file_read(f.factors, LARGEST_FILE, &factors, &factors_size, &e);
  if (s == YLM_OK) {
    ylm_light_photometry_form form = {f.lamps, f.tilt, factors, factors_size};
    s = ylm_light_photometry_read(bytes, size, f.path, &form, &p->file, &e);
  }
  ylm_free(bytes);
  ylm_free(factors);
  if (s == YLM_OK) s = finish(p, f.linear, f.lumens, &e);
  return made(L, p, s, &e);
}

static double *copy(const ylmL_array *a, size_t *n) {
  *n = a->count;
  double *x = ylm_alloc(a->count, sizeof *x);
  for (size_t i = 0; x && i < a->count; i++) x[i] = ylmL_array_get(a, i);
  return x;
}

/* Arguments of photometry_create. */
typedef struct create_form {
  ylmL_array *vertical, *horizontal, *candela;
  double lumens, watts, size[3];
  int opening;
  bool linear;
} create_form;

static const ylmL_entry create_entries[] = {
    YLML(create_form, vertical, "vertical", ARRAY),
    YLML(create_form, horizontal, "horizontal", ARRAY),
    YLML(create_form, candela, "candela", ARRAY),
    YLML(create_form, lumens, "lumens", DOUBLE, .optional = true),
    YLML(create_form, watts, "watts", DOUBLE),
    YLML(create_form, opening, "opening", CHOICE, .choices = ylmL_opening_choices),
    YLML(create_form, size, "size", NUMBERS),
    YLML(create_form, linear, "linear", BOOL),
    {.name = NULL}};

/* photometry_create { vertical [v], horizontal [h], candela [h][v], lumens | nil, watts, opening, size = {3 numbers},
                       linear } -> table */
static int photometry_create(lua_State *L) {
  ylm_error e = {0};
  create_form f = {0};
  size_t n;
  ylmL_read(L, 1, create_entries, &f);
  photometry *p = new_photometry(L);
  ylm_light_photometry_file *file = &p->file;
  if (f.candela->count != f.vertical->count * f.horizontal->count)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  file->format = "IES LM-63-2002";
  file->watts = f.watts;
  file->opening = (ylm_light_opening)f.opening;
  memcpy(file->size, f.size, sizeof file->size);
  file->angle = copy(f.vertical, &file->angles);
  file->plane = copy(f.horizontal, &file->planes);
  file->candela = copy(f.candela, &n);
  ylm_status s = file->angle && file->plane && file->candela ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = finish(p, f.linear, f.lumens, &e);
  return made(L, p, s, &e);
}

static void set_string(lua_State *L, const char *name, const char *text) {
  lua_pushstring(L, text);
  lua_setfield(L, -2, name);
}

/* photometry_facts(table) -> what the file says, and what the table is */
static int photometry_facts(lua_State *L) {
  const photometry *p = check(L);
  const ylm_light_photometry_file *f = &p->file;
  lua_newtable(L);
  set_string(L, "format", f->format);
  set_string(L, "opening", ylmL_opening_choices[f->opening]);
  ylmL_set_number(L, "lumens", f->lumens);
  ylmL_set_number(L, "watts", f->watts);
  ylmL_set_number(L, "name", ylm_light_photometry_name(p->table));
  ylmL_set_number(L, "peak", ylm_light_photometry_peak(p->table));
  ylmL_set_number(L, "clipped", ylm_light_photometry_clipped(p->table));
  ylmL_set_count(L, "angles", f->angles);
  ylmL_set_count(L, "planes", f->planes);
  ylmL_set_number(L, "last", f->angle[f->angles - 1]);
  ylmL_set_count(L, "bytes", ylm_light_photometry_bytes(p->table));
  if (f->tilt_file) set_string(L, "tilt_file", f->tilt_file);
  lua_createtable(L, 3, 0);
  for (int k = 0; k < 3; k++) {
    lua_pushnumber(L, (lua_Number)f->size[k]);
    lua_rawseti(L, -2, k + 1);
  }
  lua_setfield(L, -2, "size");
  lua_createtable(L, (int)f->notes, 0);
  for (size_t i = 0; i < f->notes; i++) {
    lua_pushstring(L, f->note[i]);
    lua_rawseti(L, -2, (int)i + 1);
  }
  lua_setfield(L, -2, "notes");
  lua_createtable(L, 0, (int)f->texts);
  for (size_t i = f->texts; i-- > 0;) set_string(L, f->text[i].name, f->text[i].text);
  lua_setfield(L, -2, "text");
  return 1;
}

/* photometry_grid(table) -> vertical [v], horizontal [h], candela [h][v], double arrays */
static int photometry_grid(lua_State *L) {
  ylm_light_photometry_grid g = ylm_light_photometry_grid_of(check(L)->table);
  size_t shape[2] = {g.planes, g.angles};
  ylmL_array *v = ylmL_array_new(L, YLM_DOUBLE, 1, &g.angles);
  ylmL_array *h = v ? ylmL_array_new(L, YLM_DOUBLE, 1, &g.planes) : NULL;
  ylmL_array *c = h ? ylmL_array_new(L, YLM_DOUBLE, 2, shape) : NULL;
  if (!c) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  memcpy(v->data, g.angle, g.angles * sizeof(double));
  memcpy(h->data, g.plane, g.planes * sizeof(double));
  memcpy(c->data, g.candela, g.planes * g.angles * sizeof(double));
  return 3;
}

/* photometry_intensity(table, directions double [n][3] of length 1, derivatives 0 .. 2) -> cd [n], [n][3], [n][6] */
static int photometry_intensity(lua_State *L) {
  const photometry *p = check(L);
  const ylmL_array *way = ylmL_array_check(L, 2);
  int order = (int)luaL_checkinteger(L, 3);
  if (way->dtype != YLM_DOUBLE || way->axes != 2 || way->shape[1] != 3)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = way->shape[0];
  ylmL_array *cd = ylmL_array_new(L, YLM_DOUBLE, 1, &n), *g = NULL, *h = NULL;
  if (cd && order > 0) g = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 3});
  if (g && order > 1) h = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 6});
  if (!cd || (order > 0 && !g) || (order > 1 && !h)) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_light_photometry_intensity(p->table, n, way->data, cd->data, g ? g->data : NULL,
                                 h ? h->data : NULL);
  return 1 + order;
}

/* photometry_flux(table, from, to) -> lm between two angles, degrees */
static int photometry_flux(lua_State *L) {
  const photometry *p = check(L);
  lua_pushnumber(L, (lua_Number)ylm_light_photometry_flux(p->table, (double)luaL_checknumber(L, 2),
                                                          (double)luaL_checknumber(L, 3)));
  return 1;
}

/* photometry_sample(table, u double [n][2]) -> directions [n][3], densities [n], sr^-1 */
static int photometry_sample(lua_State *L) {
  const photometry *p = check(L);
  const ylmL_array *u = ylmL_array_check(L, 2);
  if (u->dtype != YLM_DOUBLE || u->axes != 2 || u->shape[1] != 2)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = u->shape[0];
  ylmL_array *way = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 3});
  ylmL_array *density = way ? ylmL_array_new(L, YLM_DOUBLE, 1, &n) : NULL;
  if (!density) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  memset(way->data, 0, 3 * n * sizeof(double));
  for (size_t i = 0; i < n; i++)
    ((double *)density->data)[i] = ylm_light_photometry_sample(
        p->table, (const double *)u->data + 2 * i, (double *)way->data + 3 * i);
  return 2;
}

/* photometry_write(table, path, whether as EULUMDAT, {name, text, ..}: texts instead of the file's, or nil) -> true */
static int photometry_write(lua_State *L) {
  ylm_error e = {0};
  const photometry *p = check(L);
  const char *path = luaL_checkstring(L, 2);
  char *bytes;
  size_t size;
  ylm_light_photometry_file f = p->file;
  if (lua_istable(L, 4)) {
    f.texts = lua_rawlen(L, 4) / 2;
    f.text = lua_newuserdata(L, (f.texts + 1) * sizeof *f.text);
    for (size_t i = 0; i < f.texts; i++) { /* the strings are the table's */
      lua_rawgeti(L, 4, (int)(2 * i + 1));
      lua_rawgeti(L, 4, (int)(2 * i + 2));
      f.text[i] = (ylm_light_photometry_text){(char *)(uintptr_t)luaL_checkstring(L, -2),
                                              (char *)(uintptr_t)luaL_checkstring(L, -1)};
      lua_pop(L, 2);
    }
  }
  ylm_status s = ylm_light_photometry_write(&f, lua_toboolean(L, 3), &bytes, &size, &e);
  if (s == YLM_OK) s = ylm_file_save(path, bytes, size, &e);
  ylm_free(bytes);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* photometry_kind(path) -> 'ies', 'ldt' or nil, by the first bytes; nil, message, code */
static int photometry_kind(lua_State *L) {
  ylm_error e = {0};
  unsigned char head[8192];
  size_t size;
  ylm_status s = ylm_file_head(luaL_checkstring(L, 1), head, sizeof head, &size, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  int kind = memchr(head, 0, size) ? 0 : ylm_light_photometry_is(head, size);
  if (!kind) return 0;
  lua_pushstring(L, kind == 'i' ? "ies" : "ldt");
  return 1;
}

static const luaL_Reg functions[] = {
    {"photometry_read", photometry_read},           {"photometry_create", photometry_create},
    {"photometry_facts", photometry_facts},         {"photometry_grid", photometry_grid},
    {"photometry_intensity", photometry_intensity}, {"photometry_flux", photometry_flux},
    {"photometry_sample", photometry_sample},       {"photometry_write", photometry_write},
    {"photometry_kind", photometry_kind},           {NULL, NULL}};

void ylmL_open_light_photometry(lua_State *L) { luaL_setfuncs(L, functions, 0); }
