/* array_math.c - arithmetic of arrays, sums along axes, bytes; sorted arguments come from lua/ylm/array. */
#include "../binding.h"

static ylm_numbers numbers_of(const ylmL_array *a) {
  return (ylm_numbers){a->dtype, a->axes, a->shape, a->data};
}

/* "add" as a number of the list `names`; raises where there is none. */
static int named(lua_State *L, int i, const char *const *names) {
  return luaL_checkoption(L, i, NULL, names);
}

static ylm_dtype wider(ylm_dtype a, ylm_dtype b) {
  a = ylm_numbers_wide(a), b = ylm_numbers_wide(b);
  return a == YLM_DOUBLE || b == YLM_DOUBLE ? YLM_DOUBLE : YLM_FLOAT;
}

/* combine(op, array|number, array|number, convention) -> array, or nil where shapes do not broadcast; one is an array */
static int array_combine(lua_State *L) {
  static const char *const names[] = {
#define X(name) #name,
      YLM_NUMBERS_COMBINE_LIST(X)
#undef X
          NULL};
  static const size_t one = 1;
  ylm_numbers_combine_op op = (ylm_numbers_combine_op)named(L, 1, names);
  ylm_numbers x[2];
  double number[2];
  ylm_dtype t = YLM_FLOAT;
  for (int i = 0; i < 2; i++) {
    if (lua_type(L, 2 + i) == LUA_TNUMBER) {
      number[i] = (double)lua_tonumber(L, 2 + i);
      x[i] = (ylm_numbers){YLM_DOUBLE, 1, &one, &number[i]};
    } else {
      x[i] = numbers_of(ylmL_array_any(L, 2 + i));
      t = wider(t, x[i].dtype);
    }
  }
  uint32_t convention = (uint32_t)luaL_checknumber(L, 4);
  int axes;
  size_t shape[YLM_MAX_AXES];
  ylm_status s = ylm_numbers_broadcast(x[0].axes, x[0].shape, x[1].axes, x[1].shape, &axes, shape);
  if (s == YLM_ESHAPE) return 0;
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  ylmL_array *a = ylmL_array_unset(L, op >= YLM_COMBINE_less ? YLM_FLOAT : t, axes, shape);
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  a->convention = op >= YLM_COMBINE_less ? 0 : convention;
  return ylmL_result(L, 1, ylm_numbers_combine(op, &x[0], &x[1], t, a->data, 0), NULL);
}

/* map(op, array) -> array */
static int array_map(lua_State *L) {
  static const char *const names[] = {
#define X(name) #name,
      YLM_NUMBERS_MAP_LIST(X)
#undef X
          NULL};
  ylm_numbers_map_op op = (ylm_numbers_map_op)named(L, 1, names);
  ylmL_array *a = ylmL_array_any(L, 2);
  ylmL_array *b = ylmL_array_unset(L, ylm_numbers_wide(a->dtype), a->axes, a->shape);
  if (!b) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  b->convention = a->convention;
  ylm_numbers_map(op, a->dtype, a->count, a->data, b->data);
  return 1;
}

/* reduce(op, array, first axis, number of axes, keep) -> array without those axes (keep: with extents of 1), or a number
   where none is left; nil where there are no numbers to take it of */
static int array_reduce(lua_State *L) {
  static const char *const names[] = {
#define X(name) #name,
      YLM_NUMBERS_REDUCE_LIST(X)
#undef X
          NULL};
  ylm_numbers_reduce_op op = (ylm_numbers_reduce_op)named(L, 1, names);
  const ylmL_array *a = ylmL_array_any(L, 2);
  int first = (int)luaL_checkinteger(L, 3) - 1, many = (int)luaL_checkinteger(L, 4), axes = 0;
  bool keep = lua_toboolean(L, 5);
  size_t outer = 1, n = 1, inner = 1, shape[YLM_MAX_AXES], count;
  if (first < 0 || many < 1 || first + many > a->axes) return luaL_argerror(L, 3, "no such axes");
  for (int i = 0; i < a->axes; i++) {
    bool gone = i >= first && i < first + many;
    *(i < first ? &outer : gone ? &n : &inner) *= a->shape[i];
    if (!gone || keep) shape[axes++] = gone ? 1 : a->shape[i];
  }
  count = outer * inner;
  if (axes == 0) {
    double x;
    ylm_status s = ylm_numbers_reduce(op, a->dtype, 1, n, 1, a->data, &x);
    if (s == YLM_EDOMAIN) return 0;
    lua_pushnumber(L, (lua_Number)x);
    return ylmL_result(L, 1, s, NULL);
  }
  ylm_dtype t = ylm_numbers_wide(a->dtype);
  ylmL_array *b = ylmL_array_unset(L, t, axes, shape);
  double *out = !b ? NULL : t == YLM_DOUBLE ? b->data : ylm_alloc(count, sizeof *out);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  b->convention = first + many == a->axes ? 0 : a->convention;
  ylm_status s = ylm_numbers_reduce(op, a->dtype, outer, n, inner, a->data, out);
  if (t != YLM_DOUBLE) {
    if (s == YLM_OK) ylm_numbers_convert(YLM_DOUBLE, t, count, out, b->data, NULL);
    ylm_free(out);
  }
  return s == YLM_EDOMAIN ? 0 : ylmL_result(L, 1, s, NULL);
}

/* head(array, n) -> its first numbers, n at most, as a list */
static int array_head(lua_State *L) {
  const ylmL_array *a = ylmL_array_any(L, 1);
  size_t n = (size_t)luaL_checkinteger(L, 2);
  if (n > a->count) n = a->count;
  lua_createtable(L, (int)n, 0);
  for (size_t i = 0; i < n; i++) {
    double x;
    ylm_numbers_convert(a->dtype, YLM_DOUBLE, 1,
                        (const char *)a->data + i * ylm_numbers_size(a->dtype), &x, NULL);
    lua_pushnumber(L, (lua_Number)x);
    lua_rawseti(L, -2, (int)i + 1);
  }
  return 1;
}

/* bytes(array) -> string */
static int array_bytes(lua_State *L) {
  const ylmL_array *a = ylmL_array_any(L, 1);
  lua_pushlstring(L, a->data, a->count * ylm_numbers_size(a->dtype));
  return 1;
}

/* set_bytes(array, string) -> true; nil, the number of bytes that it has: another than the string's */
static int array_set_bytes(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1);
  size_t size, wanted = a->count * ylm_numbers_size(a->dtype);
  const char *bytes = luaL_checklstring(L, 2, &size);
  if (size != wanted) {
    lua_pushnil(L);
    ylmL_push_count(L, wanted);
    return 2;
  }
  ylm_copy(a->data, bytes, size);
  lua_pushboolean(L, 1);
  return 1;
}

static const luaL_Reg functions[] = {{"array_combine", array_combine},
                                     {"array_map", array_map},
                                     {"array_reduce", array_reduce},
                                     {"array_head", array_head},
                                     {"array_bytes", array_bytes},
                                     {"array_set_bytes", array_set_bytes},
                                     {NULL, NULL}};

void ylmL_open_array_math(lua_State *L) { luaL_setfuncs(L, functions, 0); }
