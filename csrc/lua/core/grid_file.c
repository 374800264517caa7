/* grid_file.c - ylm.grid: files. lua/ylm/grid/file.lua. */
#include "grid.h"

#include <string.h>

static int grid_write(lua_State *L) {
  ylm_error e = {0};
  ylm_status s = ylm_grid_write(ylmL_grid_check(L, 1), luaL_checkstring(L, 2), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static int grid_read(lua_State *L) {
  ylm_error e = {0};
  ylm_grid **g = ylmL_grid_new(L);
  ylm_status s = ylm_grid_read(luaL_checkstring(L, 1), g, &e);
  if (s == YLM_OK) ylmL_charge(L, ylm_grid_look(*g)->stats->bytes);
  return ylmL_result(L, 1, s, &e);
}

/* grid_encode(grid) -> the bytes of the file */
static int grid_encode(lua_State *L) {
  ylm_error e = {0};
  unsigned char *data = NULL;
  size_t size = 0;
  ylm_status s = ylm_grid_encode(ylmL_grid_check(L, 1), &data, &size, &e);
  if (s == YLM_OK) lua_pushlstring(L, (const char *)data, size);
  ylm_free(data);
  return ylmL_result(L, 1, s, &e);
}

void ylmL_grid_push_small(lua_State *L, const ylm_grid_small_report *r) {
  lua_newtable(L);
  ylmL_set_number(L, "error", r->error);
  ylmL_set_number(L, "confidence", r->confidence);
  ylmL_set_number(L, "before", r->before);
  ylmL_set_number(L, "rounding", r->rounding);
  ylmL_set_number(L, "largest", r->largest);
  ylmL_set_number(L, "median", r->middle);
  ylmL_set_count(L, "places", r->places);
  ylmL_set_boolean(L, "judged", r->judged != 0);
  ylmL_set_number(L, "step", r->step);
}

/* grid_encode_small(grid, tolerance or 0, bytes or 0, step or 0, threads, progress) -> the bytes of the file, report */
static int grid_encode_small(lua_State *L) {
  lua_settop(L, 6);
  ylm_grid *g = ylmL_grid_check(L, 1);
  ylmL_progress progress;
  ylm_error e = {0};
  ylm_grid_small how = {.tolerance = luaL_checknumber(L, 2),
                        .bytes = (uint64_t)luaL_checknumber(L, 3),
                        .step = luaL_checknumber(L, 4),
                        .threads = (int)luaL_checknumber(L, 5),
                        .progress = ylmL_progress_begin(L, 6, &progress)};
  ylm_grid_small_report report;
  unsigned char *data = NULL;
  size_t size = 0;
  ylm_status s = ylm_grid_encode_small(g, &how, &data, &size, &report, &e);
  if (s == YLM_OK) {
    lua_pushlstring(L, (const char *)data, size);
    ylmL_grid_push_small(L, &report);
  }
  ylm_free(data);
  return ylmL_result_progress(L, 2, s, &e, &progress);
}

/* grid_small(grid) -> the report of the file that it was read from, nil where that was not of few bytes */
static int grid_small(lua_State *L) {
  ylm_grid_small_report report;
  if (!ylm_grid_small_of(ylmL_grid_check(L, 1), &report)) return 0;
  ylmL_grid_push_small(L, &report);
  return 1;
}

/* grid_restate(bytes of a file, grid) -> the bytes, with the stats and the tolerance that the grid has */
static int grid_restate(lua_State *L) {
  ylm_error e = {0};
  size_t size;
  const char *data = luaL_checklstring(L, 1, &size);
  unsigned char *copy = lua_newuserdata(L, size + 1);
  memcpy(copy, data, size);
  ylm_status s = ylm_grid_restate(copy, size, ylmL_grid_check(L, 2), &e);
  if (s == YLM_OK) lua_pushlstring(L, (const char *)copy, size);
  return ylmL_result(L, 1, s, &e);
}

/* grid_inherit(grid, another that is read from its file): the places that judged it become those of the other */
static int grid_inherit(lua_State *L) {
  ylm_grid_inherit(ylmL_grid_check(L, 1), ylmL_grid_check(L, 2));
  return 0;
}

/* grid_decode(bytes) -> grid */
static int grid_decode(lua_State *L) {
  ylm_error e = {0};
  size_t size;
  const char *data = luaL_checklstring(L, 1, &size);
  ylm_grid **g = ylmL_grid_new(L);
  return ylmL_result(L, 1, ylm_grid_decode((const unsigned char *)data, size, "grid", g, &e), &e);
}

/* grid_small_parts(bytes of a small file) -> table: bytes of its parts by name; or nil, message, code */
static int grid_small_parts(lua_State *L) {
  ylm_error e = {0};
  ylm_grid_small_part part[YLM_GRID_SMALL_PARTS];
  size_t size;
  const char *data = luaL_checklstring(L, 1, &size);
  ylm_status s = ylm_grid_small_parts((const unsigned char *)data, size, part, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  lua_newtable(L);
  for (int i = 0; i < YLM_GRID_SMALL_PARTS; i++) {
    lua_pushlstring(L, part[i].size ? (const char *)part[i].data : "", part[i].size);
    lua_setfield(L, -2, part[i].name);
  }
  return 1;
}

/* grid_small_constants() -> table: constants of the format by their names */
static int grid_small_constants(lua_State *L) {
  size_t n;
  const ylm_grid_small_constant *list = ylm_grid_small_constants(&n);
  lua_newtable(L);
  for (size_t i = 0; i < n; i++) ylmL_set_number(L, list[i].name, list[i].value);
  return 1;
}

/* One section of a file, as a table on the stack. */
static void push_section(lua_State *L, const ylm_grid_file_section *s) {
  lua_newtable(L);
  lua_pushstring(L, s->name);
  lua_setfield(L, -2, "name");
  ylmL_set_count(L, "offset", s->offset);
  ylmL_set_count(L, "bytes", s->size);
  ylmL_set_count(L, "record", s->record);
  ylmL_set_boolean(L, "required", s->required);
  ylmL_set_boolean(L, "known", s->known);
}

/* grid_file_look(path) -> table: version, bytes, form, stats, sections, small */
static int grid_file_look(lua_State *L) {
  ylm_error e = {0};
  ylm_grid_file_info info;
  ylm_status s = ylm_grid_file_look(luaL_checkstring(L, 1), &info, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  lua_newtable(L);
  ylmL_set_count(L, "version", info.version);
  ylmL_set_count(L, "bytes", info.size);
  ylmL_grid_push_form(L, &info.form);
  lua_setfield(L, -2, "form");
  ylmL_grid_push_stats(L, &info.form, &info.stats);
  lua_setfield(L, -2, "stats");
  lua_newtable(L);
  for (size_t i = 0; i < info.sections; i++) {
    push_section(L, &info.section[i]);
    lua_rawseti(L, -2, (int)i + 1);
  }
  lua_setfield(L, -2, "sections");
  if (info.is_small) {
    ylmL_grid_push_small(L, &info.small);
    lua_setfield(L, -2, "small");
  }
  ylm_grid_file_forget(&info);
  return 1;
}

/* grid_accepted_damage(bytes) -> how many of all single-bit flips and truncations are accepted (0
   is right) */
static int grid_accepted_damage(lua_State *L) {
  ylm_error e = {0};
  size_t size, accepted = 0;
  const char *data = luaL_checklstring(L, 1, &size);
  unsigned char *copy = lua_newuserdata(L, size + 1);
  memcpy(copy, data, size);
  ylm_grid *g = NULL;
  for (size_t bit = 0; bit < 8 * size; bit++) {
    copy[bit >> 3] ^= (unsigned char)(1u << (bit & 7));
    accepted += ylm_grid_decode(copy, size, "grid", &g, &e) == YLM_OK;
    ylm_grid_free(g);
    copy[bit >> 3] ^= (unsigned char)(1u << (bit & 7));
  }
  for (size_t n = 0; n < size; n++) {
    accepted += ylm_grid_decode(copy, n, "grid", &g, &e) == YLM_OK;
    ylm_grid_free(g);
  }
  lua_pushnumber(L, (lua_Number)accepted);
  return 1;
}

static const luaL_Reg functions[] = {{"grid_write", grid_write},
                                     {"grid_read", grid_read},
                                     {"grid_encode", grid_encode},
                                     {"grid_encode_small", grid_encode_small},
                                     {"grid_small", grid_small},
                                     {"grid_small_parts", grid_small_parts},
                                     {"grid_small_constants", grid_small_constants},
                                     {"grid_restate", grid_restate},
                                     {"grid_inherit", grid_inherit},
                                     {"grid_decode", grid_decode},
                                     {"grid_file_look", grid_file_look},
                                     {"grid_accepted_damage", grid_accepted_damage},
                                     {NULL, NULL}};

void ylmL_open_grid_file(lua_State *L) { luaL_setfuncs(L, functions, 0); }
