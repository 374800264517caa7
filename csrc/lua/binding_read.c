/* binding_read.c - named arguments: a table of Lua is read into a struct, as the struct's entries say. */
#include "binding.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The largest whole number up to which doubles have all. */
#define WHOLE 9007199254740992.0

/* Pushes a number as it is written: 5 where Lua would write 5.0. */
static const char *push_number(lua_State *L, double x) {
  char text[32];
  snprintf(text, sizeof text, "%.14g", x);
  lua_pushstring(L, text);
  return lua_tostring(L, -1);
}

/* Raises of the entry of the table at `i` whose value is on top: "lmax: an integer of 0 to 12 expected, got 13". */
static void refuse(lua_State *L, int i, const ylmL_entry *e, const char *wanted) {
  const char *got = luaL_typename(L, -1);
  if (lua_type(L, -1) == LUA_TNUMBER)
    got = push_number(L, (double)lua_tonumber(L, -1));
  else if (lua_type(L, -1) == LUA_TSTRING)
    got = lua_pushfstring(L, "'%s'", lua_tostring(L, -1));
  luaL_argerror(L, i, lua_pushfstring(L, "%s: %s expected, got %s", e->name, wanted, got));
}

/* Has the table of entries this name? */
static bool is_named(const ylmL_entry *entries, const char *name) {
  for (; entries->name; entries++)
    if (strcmp(entries->name, name) == 0) return true;
  return false;
}

/* Raises where the table at `i` has a key that no entry has. */
static void check_names(lua_State *L, int i, const ylmL_entry *entries) {
  for (lua_pushnil(L); lua_next(L, i); lua_pop(L, 1)) {
    bool text = lua_type(L, -2) == LUA_TSTRING;
    if (text && is_named(entries, lua_tostring(L, -2))) continue;
    const char *name = text ? lua_tostring(L, -2) : luaL_typename(L, -2);
    luaL_argerror(L, i, lua_pushfstring(L, "no argument has the name '%s'", name));
  }
}

/* The number on top, of the entry's range within least .. most; `what`: how it is called. */
static double number_of(lua_State *L, int i, const ylmL_entry *e, const char *what, double least,
                        double most) {
  if (e->least < e->most) least = fmax(least, e->least), most = fmin(most, e->most);
  bool bounded = least > -INFINITY || most < INFINITY;
  double x = (double)lua_tonumber(L, -1);
  if (lua_type(L, -1) == LUA_TNUMBER && (!bounded || (x >= least && x <= most))) return x;
  if (bounded) {
    const char *from = push_number(L, least), *to = push_number(L, most);
    what = lua_pushfstring(L, "%s of %s to %s", what, from, to);
    lua_pushvalue(L, -4);
  }
  refuse(L, i, e, what);
  return 0;
}

/* number_of, whole. */
static double integer_of(lua_State *L, int i, const ylmL_entry *e, double least, double most) {
  double x = number_of(L, i, e, "an integer", least, most);
  if (x != floor(x)) refuse(L, i, e, "an integer");
  return x;
}

/* The place of the word on top in the entry's choices. */
static int choice_of(lua_State *L, int i, const ylmL_entry *e) {
  const char *word = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : NULL;
  for (int k = 0; word && e->choices[k]; k++)
    if (strcmp(word, e->choices[k]) == 0) return k;
  lua_pushliteral(L, "one of");
  for (int k = 0; e->choices[k]; k++) {
    lua_pushfstring(L, k ? ", '%s'" : " '%s'", e->choices[k]);
    lua_concat(L, 2);
  }
  const char *wanted = lua_tostring(L, -1);
  lua_insert(L, -2);
  refuse(L, i, e, wanted);
  return 0;
}

/* The numbers of the list on top, as many as the entry says. */
static void numbers_of(lua_State *L, int i, const ylmL_entry *e, double *out) {
  size_t n = e->size / sizeof *out;
  const char *wanted = lua_pushfstring(L, "a list of %d numbers", (int)n);
  lua_insert(L, -2);
  if (!lua_istable(L, -1)) refuse(L, i, e, wanted);
  for (size_t k = 0; k < n; k++) {
    lua_rawgeti(L, -1, (int)k + 1);
    if (lua_type(L, -1) != LUA_TNUMBER) refuse(L, i, e, wanted);
    out[k] = (double)lua_tonumber(L, -1);
    lua_pop(L, 1);
  }
  lua_remove(L, -2);
}

/* Bytes of a field, by kind; 0: any. */
static const size_t sizes[YLML_KINDS] = {
    [YLML_INT] = sizeof(int),         [YLML_COUNT] = sizeof(size_t),
    [YLML_UINT64] = sizeof(uint64_t), [YLML_DOUBLE] = sizeof(double),
    [YLML_BOOL] = sizeof(bool),       [YLML_CHOICE] = sizeof(int),
    [YLML_EITHER] = sizeof(bool),     [YLML_STRING] = sizeof(char *),
    [YLML_ARRAY] = sizeof(void *),    [YLML_FIELD] = sizeof(void *),
    [YLML_VALUE] = sizeof(int)};

/* Reads the value on top, which is not nil, into the entry's field. */
static void read_plain(lua_State *L, int i, const ylmL_entry *e, void *field) {
  switch (e->kind) {
  case YLML_INT: *(int *)field = (int)integer_of(L, i, e, INT_MIN, INT_MAX); break;
  case YLML_COUNT: *(size_t *)field = (size_t)integer_of(L, i, e, 0, WHOLE); break;
  case YLML_UINT64: *(uint64_t *)field = (uint64_t)integer_of(L, i, e, 0, WHOLE); break;
  case YLML_DOUBLE: *(double *)field = number_of(L, i, e, "a number", -INFINITY, INFINITY); break;
  case YLML_BOOL:
    if (!lua_isboolean(L, -1)) refuse(L, i, e, "a boolean");
    *(bool *)field = lua_toboolean(L, -1);
    break;
  case YLML_CHOICE: *(int *)field = choice_of(L, i, e); break;
  case YLML_EITHER: *(bool *)field = choice_of(L, i, e) == 1; break;
  case YLML_STRING:
    if (lua_type(L, -1) != LUA_TSTRING) refuse(L, i, e, "a string");
    *(const char **)field = lua_tostring(L, -1);
    break;
  default: numbers_of(L, i, e, field);
  }
}

/* Reads the object on top of the stack, where it stays. */
static void read_object(lua_State *L, const ylmL_entry *e, void *field) {
  int top = lua_gettop(L);
  if (e->kind == YLML_VALUE)
    *(int *)field = top;
  else if (lua_isnil(L, top) && e->optional)
    return;
  else if (e->kind == YLML_ARRAY)
    *(ylmL_array **)field = ylmL_array_check(L, top);
  else if (e->kind == YLML_FIELD)
    *(const ylm_field **)field = ylmL_field_check(L, top);
  else
    e->read(L, top, field);
}

void ylmL_read(lua_State *L, int i, const ylmL_entry *entries, void *out) {
  luaL_checktype(L, i, LUA_TTABLE);
  lua_settop(L, i);
  luaL_checkstack(L, 40, "named arguments");
  check_names(L, i, entries);
  for (const ylmL_entry *e = entries; e->name; e++) {
    void *field = (char *)out + e->at;
    if (sizes[e->kind] && e->size != sizes[e->kind])
      luaL_error(L, "the field of %s has another size than its kind", e->name);
    lua_getfield(L, i, e->name);
    if (e->kind >= YLML_OBJECTS) {
      read_object(L, e, field);
      continue;
    }
    if (!lua_isnil(L, -1))
      read_plain(L, i, e, field);
    else if (!e->optional && e->kind != YLML_BOOL)
      luaL_argerror(L, i, lua_pushfstring(L, "%s is missing", e->name));
    lua_pop(L, 1);
  }
}
