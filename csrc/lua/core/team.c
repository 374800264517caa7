/* team.c - ylm.team: processes that share work; values as bytes for them. lua/ylm/team. */
#include <stdlib.h>
#include <string.h>

#include "../binding.h"

static ylm_team *team_check(lua_State *L) {
  luaL_checktype(L, 1, LUA_TUSERDATA);
  return ylmL_team_opt(L, 1);
}

/* team_alone() -> the team of one process */
static int team_alone(lua_State *L) {
  ylm_team **t = ylmL_team_new(L);
  return ylmL_result(L, 1, ylm_team_alone(t), NULL);
}

/* team_info(team) -> rank from 1, size */
static int team_info(lua_State *L) {
  const ylm_team *t = team_check(L);
  lua_pushinteger(L, t->rank + 1);
  lua_pushinteger(L, t->size);
  return 2;
}

/* team_job(team) -> the number of a new job */
static int team_job(lua_State *L) {
  ylmL_push_count(L, ylm_team_job(team_check(L)));
  return 1;
}

/* team_next(team, job, n) -> a task of it, 1 .. n; false: none is left; nil, message, code */
static int team_next(lua_State *L) {
  ylm_team *t = team_check(L);
  ylm_error e = {0};
  size_t task, n = (size_t)luaL_checknumber(L, 3);
  ylm_status s = t->next(t->self, (uint32_t)luaL_checknumber(L, 2), n, &task, &e);
  if (s == YLM_OK && task < n)
    ylmL_push_count(L, task + 1);
  else
    lua_pushboolean(L, 0);
  return ylmL_result(L, 1, s, &e);
}

/* team_stop(team, job): no more of its tasks are handed out */
static int team_stop(lua_State *L) {
  ylm_team *t = team_check(L);
  t->stop(t->self, (uint32_t)luaL_checknumber(L, 2));
  return 0;
}

/* team_serve(team): answers the others */
static int team_serve(lua_State *L) {
  ylm_team *t = team_check(L);
  t->serve(t->self);
  return 0;
}

static ylm_status status_of(const char *name) {
  for (int s = 0; s < YLM_STATUS_COUNT; s++)
    if (strcmp(ylm_status_name((ylm_status)s), name) == 0) return (ylm_status)s;
  return YLM_EPEER;
}

/* team_agree(team, code or nil, message) -> true; nil, message, code of the first that has one */
static int team_agree(lua_State *L) {
  ylm_team *t = team_check(L);
  ylm_error e = {0};
  ylm_status s = YLM_OK;
  if (!lua_isnoneornil(L, 2)) {
    s = status_of(luaL_checkstring(L, 2));
    ylm_fail(&e, s, "%s", luaL_checkstring(L, 3));
  }
  s = t->agree(t->self, s, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* Every process's bytes, of which one has `mine`: *all has their sum, bytes [size]. The caller frees
   *all. */
static ylm_status gather(ylm_team *t, const char *mine, size_t length, size_t *bytes, char **all,
                         ylm_error *e) {
  size_t size = (size_t)t->size, sum = 0;
  *all = NULL;
  for (size_t i = 0; i < size; i++) bytes[i] = sizeof length;
  size_t *lengths = bytes + size;
  ylm_status s = t->exchange(t->self, &length, bytes, lengths, e);
  for (size_t i = 0; s == YLM_OK && i < size; i++) sum += lengths[i];
  if (s != YLM_OK) return s;
  *all = ylm_alloc(sum, 1);
  s = t->agree(t->self, *all ? YLM_OK : YLM_ENOMEM, e);
  if (s == YLM_OK) s = t->exchange(t->self, mine, lengths, *all, e);
  if (s == YLM_OK) return s;
  ylm_free(*all);
  *all = NULL;
  return s;
}

/* An object that frees a block of C when it is collected. */
static int block_gc(lua_State *L) {
  void **block = lua_touserdata(L, 1);
  ylm_free(*block);
  *block = NULL;
  return 0;
}

static const luaL_Reg block_methods[] = {{"__gc", block_gc}, {NULL, NULL}};

static void **new_block(lua_State *L) {
  void **block = lua_newuserdata(L, sizeof *block);
  *block = NULL;
  ylmL_type(L, "ylm.team_block", block_methods);
  lua_setmetatable(L, -2);
  return block;
}

/* team_exchange(team, string) -> a list of every process's string */
static int team_exchange(lua_State *L) {
  size_t length;
  ylm_team *t = team_check(L);
  const char *mine = luaL_checklstring(L, 2, &length);
  size_t *bytes = lua_newuserdata(L, 2 * (size_t)t->size * sizeof *bytes);
  char **all = (char **)new_block(L);
  ylm_error e = {0};
  ylm_status s = gather(t, mine, length, bytes, all, &e);
  lua_newtable(L);
  const char *at = *all;
  for (int i = 0; s == YLM_OK && i < t->size; at += bytes[t->size + i++]) {
    lua_pushlstring(L, at, bytes[t->size + i]);
    lua_rawseti(L, -2, i + 1);
  }
  ylm_free(*all);
  *all = NULL;
  return ylmL_result(L, 1, s, &e);
}

/* team_same(team, function's name, names, strings) -> true; nil, message, code where a process has
   other strings */
static int team_same(lua_State *L) {
  ylm_team *t = team_check(L);
  const char *what = luaL_checkstring(L, 2);
  luaL_checktype(L, 3, LUA_TTABLE);
  luaL_checktype(L, 4, LUA_TTABLE);
  size_t n = lua_rawlen(L, 3);
  const char **names = lua_newuserdata(L, (n + 1) * sizeof *names);
  uint64_t *values = lua_newuserdata(L, (n + 1) * sizeof *values);
  for (size_t i = 0; i < n; i++) {
    size_t length;
    lua_rawgeti(L, 3, (int)i + 1);
    names[i] = luaL_checkstring(L, -1); /* the list keeps it alive */
    lua_rawgeti(L, 4, (int)i + 1);
    const char *text = luaL_checklstring(L, -1, &length);
    values[i] = ylm_crc64(0, text, length);
    lua_pop(L, 2);
  }
  ylm_error e = {0};
  ylm_status s = ylm_team_same(t, what, n, names, values, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* -- values as bytes --------------------------------------------------------------------------- */

/* team_crc(string) -> its CRC-64, 16 digits */
static int team_crc(lua_State *L) {
  size_t length;
  char text[17];
  const char *s = luaL_checklstring(L, 1, &length);
  snprintf(text, sizeof text, "%016llx", (unsigned long long)ylm_crc64(0, s, length));
  lua_pushstring(L, text);
  return 1;
}

/* team_bytes(array) -> its elements as a string, convention */
static int team_bytes(lua_State *L) {
  const ylmL_array *a = ylmL_array_any(L, 1);
  lua_pushlstring(L, a->data, a->count * ylm_numbers_size(a->dtype));
  ylmL_push_count(L, a->convention);
  return 2;
}

/* team_set_bytes(array, string, convention) -> the array; nil: it has another size */
static int team_set_bytes(lua_State *L) {
  size_t length;
  ylmL_array *a = ylmL_array_any(L, 1);
  const char *s = luaL_checklstring(L, 2, &length);
  if (length != a->count * ylm_numbers_size(a->dtype)) return 0;
  ylm_copy(a->data, s, length);
  a->convention = (uint32_t)luaL_checknumber(L, 3);
  lua_settop(L, 1);
  return 1;
}

static const luaL_Reg functions[] = {{"team_alone", team_alone},
                                     {"team_info", team_info},
                                     {"team_job", team_job},
                                     {"team_next", team_next},
                                     {"team_stop", team_stop},
                                     {"team_serve", team_serve},
                                     {"team_agree", team_agree},
                                     {"team_exchange", team_exchange},
                                     {"team_same", team_same},
                                     {"team_crc", team_crc},
                                     {"team_bytes", team_bytes},
                                     {"team_set_bytes", team_set_bytes},
                                     {NULL, NULL}};

void ylmL_open_team(lua_State *L) { luaL_setfuncs(L, functions, 0); }
