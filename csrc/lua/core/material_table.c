/* material_table.c - tables of materials in spherical harmonics; lua/ylm/material/table.lua drives it. */
#include "material.h"
#include "ylm_material_table.h"

#define TABLE "ylm.material_table"

typedef struct handle {
  ylm_material_table *table;
} handle;

static int table_gc(lua_State *L) {
  handle *h = ylmL_check(L, 1, TABLE);
  ylm_material_table_free(h->table);
  h->table = NULL;
  return 0;
}

typedef struct table_form {
  ylm_material_table_form f;
  int progress; /* on the stack */
} table_form;

static const ylmL_entry table_entries[] = {
    YLML(table_form, f.lmax, "lmax", INT),
    YLML(table_form, f.rows, "rows", INT),
    YLML(table_form, f.columns, "columns", INT),
    YLML(table_form, f.error, "error", DOUBLE),
    YLML(table_form, f.slice, "slice", CHOICE, .choices = ylmL_slice_choices),
    YLML(table_form, f.threads, "threads", INT, .optional = true),
    YLML(table_form, progress, "progress", VALUE),
    {.name = NULL}};

/* material_table(material, {lmax, rows, columns, error, slice: "cosine" | "bare" | "fit", threads, progress}) ->
   table, facts */
static int material_table(lua_State *L) {
  table_form t = {.progress = 0};
  const ylm_material *m = ylmL_material_check(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylm_material_table_facts f;
  ylmL_read(L, 2, table_entries, &t);
  handle *h = lua_newuserdata(L, sizeof *h);
  h->table = NULL;
  luaL_getmetatable(L, TABLE);
  lua_setmetatable(L, -2);
  t.f.progress = ylmL_progress_begin(L, t.progress, &p);
  ylm_status s = ylm_material_table_create(m, &t.f, &h->table, &e);
  if (s != YLM_OK) return ylmL_result_progress(L, 0, s, &e, &p);
  ylm_material_table_look(h->table, &f);
  ylmL_charge(L, f.bytes);
  lua_newtable(L);
  ylmL_set_number(L, "lmax", f.lmax);
  ylmL_set_number(L, "rows", f.rows);
  ylmL_set_number(L, "columns", f.columns);
  ylmL_set_number(L, "functions", f.functions);
  ylmL_set_number(L, "error", f.error);
  ylmL_set_number(L, "grazing", f.grazing);
  ylmL_set_number(L, "bytes", (double)f.bytes);
  ylmL_set_number(L, "seconds", f.seconds);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* Directions above the surface. */
static ylmL_array *views(lua_State *L, int i) {
  return ylmL_unit_rows(L, i, ylmL_array_check(L, i)->count / 3, "wo", true);
}

/* material_table_slices(table, wo [n][3]) -> float [n][3][(lmax+1)^2] */
static int material_table_slices(lua_State *L) {
  handle *h = ylmL_check(L, 1, TABLE);
  ylm_material_table_facts f;
  ylmL_array *wo = views(L, 2);
  if (!wo) return 3;
  ylm_material_table_look(h->table, &f);
  size_t n = wo->count / 3, count = (size_t)(f.lmax + 1) * (size_t)(f.lmax + 1);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 3, (size_t[]){n, 3, count});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(
      L, 1, ylm_material_table_slices(h->table, n, (const float(*)[3])wo->data, out->data), NULL);
}

/* material_table_missed(table, lmax, wo [n][3]) -> float [n] */
static int material_table_missed(lua_State *L) {
  handle *h = ylmL_check(L, 1, TABLE);
  int lmax = (int)luaL_checknumber(L, 2);
  ylmL_array *wo = views(L, 3);
  if (!wo) return 3;
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 1, (size_t[]){wo->count / 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_material_table_missed(h->table, lmax, wo->count / 3, (const float(*)[3])wo->data, out->data);
  return 1;
}

static const luaL_Reg functions[] = {{"material_table", material_table},
                                     {"material_table_slices", material_table_slices},
                                     {"material_table_missed", material_table_missed},
                                     {NULL, NULL}};
static const luaL_Reg methods[] = {{"__gc", table_gc}, {NULL, NULL}};

void ylmL_open_material_table(lua_State *L) {
  ylmL_type(L, TABLE, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
