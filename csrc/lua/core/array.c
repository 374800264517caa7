/* array.c - functions on ylm.array; the type itself is in binding_array.c, Lua methods in
   lua/ylm/array.lua. */
#include "../binding.h"

#include <string.h>

static ylm_dtype check_dtype(lua_State *L, int i) {
  const char *name = luaL_optstring(L, i, "double");
  int t = 0;
  while (t < YLM_NUMBERS_TYPES && strcmp(ylm_numbers_type_name((ylm_dtype)t), name) != 0) t++;
  if (t == YLM_NUMBERS_TYPES) luaL_argerror(L, i, "no element type");
  return (ylm_dtype)t;
}

/* Number k of an array of any type. */
static double get(const ylmL_array *a, size_t k) {
  double x;
  ylm_numbers_convert(a->dtype, YLM_DOUBLE, 1,
                      (const char *)a->data + k * ylm_numbers_size(a->dtype), &x, NULL);
  return x;
}

/* x as number k; false where its type does not hold it. */
static bool put(const ylmL_array *a, size_t k, double x) {
  return ylm_numbers_convert(YLM_DOUBLE, a->dtype, 1, &x,
                             (char *)a->data + k * ylm_numbers_size(a->dtype), NULL) == YLM_OK;
}

/* The shape in the table at `i`. YLM_ESHAPE, YLM_EOVERFLOW. */
static ylm_status check_shape(lua_State *L, int i, int *axes, size_t shape[YLM_MAX_AXES],
                              ylm_error *e) {
  luaL_checktype(L, i, LUA_TTABLE);
  size_t length = lua_rawlen(L, i), count;
  double elements = 1;
  bool fits = true, is_empty = false;
  if (length < 1 || length > YLM_MAX_AXES) return YLM_ESHAPE;
  for (size_t k = 0; k < length; k++) {
    int64_t n = 0;
    lua_rawgeti(L, i, (int)k + 1);
    double extent = (double)lua_tonumber(L, -1);
    if (!(extent >= 0)) return YLM_ESHAPE;
    is_empty = is_empty || extent == 0;
    elements *= extent == 0 ? 1 : extent;
    fits = fits && ylmL_toint64(L, -1, &n);
    shape[k] = (size_t)n;
    lua_pop(L, 1);
  }
  *axes = (int)length;
  if (fits && ylm_shape_count(*axes, shape, &count)) return YLM_OK;
  return ylm_fail(e, YLM_EOVERFLOW,
                  is_empty ? "extents of %g beside one of 0 are too large"
                           : "%g elements are more than any memory holds",
                  elements);
}

/* zeros(shape table, dtype) */
static int array_zeros(lua_State *L) {
  ylm_dtype t = check_dtype(L, 2);
  int axes;
  size_t shape[YLM_MAX_AXES] = {0};
  ylm_error e = {0};
  ylm_status s = check_shape(L, 1, &axes, shape, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  return ylmL_result(L, 1, ylmL_array_new(L, t, axes, shape) ? YLM_OK : YLM_ENOMEM, NULL);
}

static void give_nothing_back(void *owner) { (void)owner; }

/* wrap(address: lightuserdata or number, shape table, dtype, keep) -> an array over that memory; or nil, "null" | "aligned" */
static int array_wrap(lua_State *L) {
  ylm_dtype t = check_dtype(L, 3);
  int axes;
  size_t shape[YLM_MAX_AXES] = {0};
  ylm_error e = {0};
  lua_settop(L, 4);
  ylm_status s = check_shape(L, 2, &axes, shape, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  int64_t address = 0;
  char *data = lua_touserdata(L, 1);
  if (lua_type(L, 1) == LUA_TNUMBER && ylmL_toint64(L, 1, &address) && address > 0)
    data = (char *)(uintptr_t)address;
  const char *fault = !data ? "null" : (uintptr_t)data % ylm_numbers_size(t) ? "aligned" : NULL;
  if (fault) {
    lua_pushnil(L);
    lua_pushstring(L, fault);
    return 2;
  }
  if (!ylmL_array_share(L, t, axes, shape, data, give_nothing_back, NULL))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylmL_array_keep(L, 4);
  return 1;
}

/* fill(array, nested table): the table's nesting and lengths must be the array's shape. */
static bool fill(lua_State *L, ylmL_array *a, int axis, size_t *next) {
  if (axis == a->axes) {
    if (lua_type(L, -1) != LUA_TNUMBER || !put(a, *next, (double)lua_tonumber(L, -1))) return false;
    ++*next;
    return true;
  }
  if (!lua_istable(L, -1) || lua_rawlen(L, -1) != a->shape[axis]) return false;
  luaL_checkstack(L, 4, "nested table");
  for (size_t i = 1; i <= a->shape[axis]; i++) {
    lua_rawgeti(L, -1, (int)i);
    bool ok = fill(L, a, axis + 1, next);
    lua_pop(L, 1);
    if (!ok) return false;
  }
  return true;
}

/* fill(array, table) -> true, or nil, flat index (1-based) of the first misfit */
static int array_fill(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1);
  luaL_checktype(L, 2, LUA_TTABLE);
  lua_settop(L, 2);
  size_t next = 0;
  if (fill(L, a, 0, &next)) {
    lua_pushboolean(L, 1);
    return 1;
  }
  lua_pushnil(L);
  ylmL_push_count(L, next + 1);
  return 2;
}

static void push_nested(lua_State *L, const ylmL_array *a, int axis, size_t *next) {
  if (axis == a->axes) {
    lua_pushnumber(L, (lua_Number)get(a, (*next)++));
    return;
  }
  luaL_checkstack(L, 4, "nested table");
  lua_createtable(L, a->shape[axis] < INT32_MAX ? (int)a->shape[axis] : 0, 0);
  for (size_t i = 1; i <= a->shape[axis]; i++) {
    push_nested(L, a, axis + 1, next);
    lua_rawseti(L, -2, (int)i);
  }
}

static int array_totable(lua_State *L) {
  size_t next = 0;
  push_nested(L, ylmL_array_any(L, 1), 0, &next);
  return 1;
}

/* info(array) -> shape table, dtype name, convention number, is open */
static int array_info(lua_State *L) {
  ylmL_array *a = ylmL_check(L, 1, YLM_ARRAY);
  lua_createtable(L, a->axes, 0);
  for (int i = 0; i < a->axes; i++) {
    lua_pushinteger(L, (lua_Integer)a->shape[i]);
    lua_rawseti(L, -2, i + 1);
  }
  lua_pushstring(L, ylm_numbers_type_name(a->dtype));
  lua_pushinteger(L, (lua_Integer)a->convention);
  lua_pushboolean(L, a->data != NULL);
  return 4;
}

static int array_set_convention(lua_State *L) {
  ylmL_array_any(L, 1)->convention = (uint32_t)luaL_checknumber(L, 2);
  return 0;
}

/* The flat offset of one-based indices at stack positions 2 ..; false if one is out of range. */
static bool offset(lua_State *L, const ylmL_array *a, int given, size_t *out) {
  size_t k = 0;
  for (int i = 0; i < given; i++) {
    int64_t x;
    if (!ylmL_toint64(L, 2 + i, &x) || x < 1 || (uint64_t)x > a->shape[i]) return false;
    k = k * a->shape[i] + (size_t)(x - 1);
  }
  *out = k;
  return true;
}

/* get(array, i, j, ...) -> number, or nil if an index is out of range or their number is wrong */
static int array_get(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1);
  size_t k;
  if (lua_gettop(L) - 1 != a->axes || !offset(L, a, a->axes, &k)) return 0;
  lua_pushnumber(L, (lua_Number)get(a, k));
  return 1;
}

/* set(array, i, j, ..., value) -> true, false where the type does not hold it, or nothing as for get */
static int array_set(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1);
  size_t k;
  int last = lua_gettop(L);
  if (last - 2 != a->axes || lua_type(L, last) != LUA_TNUMBER || !offset(L, a, a->axes, &k))
    return 0;
  lua_pushboolean(L, put(a, k, (double)lua_tonumber(L, last)));
  return 1;
}

/* view(array, i) -> view of row i (axes > 1), or nil */
static int array_view(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1);
  size_t k;
  if (a->axes < 2 || !offset(L, a, 1, &k)) return 0;
  ylmL_array_part(L, 1, a->shape[0] ? k * (a->count / a->shape[0]) : 0, a->axes - 1, a->shape + 1);
  return 1;
}

/* reshape(array, shape table) -> view with the same number of elements, or nil */
static int array_reshape(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1);
  luaL_checktype(L, 2, LUA_TTABLE);
  size_t axes = lua_rawlen(L, 2), shape[YLM_MAX_AXES], count;
  if (axes < 1 || axes > YLM_MAX_AXES) return 0;
  for (size_t i = 0; i < axes; i++) {
    int64_t n;
    lua_rawgeti(L, 2, (int)i + 1);
    if (!ylmL_toint64(L, -1, &n) || n < 0) return 0;
    shape[i] = (size_t)n;
    lua_pop(L, 1);
  }
  if (!ylm_shape_count((int)axes, shape, &count) || count != a->count) return 0;
  ylmL_array_part(L, 1, 0, (int)axes, shape);
  return 1;
}

/* convert(array, dtype) -> a copy with that element type; nil, one-based flat index, number: the first that it does not
   hold */
static int array_convert(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1);
  ylm_dtype t = check_dtype(L, 2);
  ylmL_array *b = ylmL_array_unset(L, t, a->axes, a->shape);
  if (!b) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  b->convention = a->convention;
  size_t where;
  if (ylm_numbers_convert(a->dtype, t, a->count, a->data, b->data, &where) == YLM_OK) return 1;
  lua_pushnil(L);
  ylmL_push_count(L, where + 1);
  lua_pushnumber(L, (lua_Number)get(a, where));
  return 3;
}

static int array_pointer(lua_State *L) {
  lua_pushlightuserdata(L, ylmL_array_any(L, 1)->data);
  return 1;
}

/* finite(array) -> true, or false, one-based flat index of the first that is not */
static int array_finite(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  size_t where;
  bool ok = ylm_all_finite(a->dtype, a->data, a->count, &where);
  lua_pushboolean(L, ok);
  if (ok) return 1;
  ylmL_push_count(L, where + 1);
  return 2;
}

/* within(array, limit) -> whether all numbers are from -limit to limit */
static int array_within(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  double limit = (double)luaL_checknumber(L, 2);
  lua_pushboolean(L, ylm_all_within(a->dtype, a->data, a->count, limit));
  return 1;
}

/* distance(a, b) -> largest |a-b|, sqrt of the sum of squares of a-b, of b: for whole-array
   tests */
static int array_distance(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1), *b = ylmL_array_check(L, 2);
  if (a->count != b->count) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  double largest = 0, sum = 0, norm = 0;
  for (size_t i = 0; i < a->count; i++) {
    double x = ylmL_array_get(a, i), y = ylmL_array_get(b, i), d = x > y ? x - y : y - x;
    if (d > largest || d != d) largest = d; /* NaN sticks */
    sum += d * d;
    norm += y * y;
  }
  lua_pushnumber(L, (lua_Number)largest);
  lua_pushnumber(L, (lua_Number)__builtin_sqrt(sum));
  lua_pushnumber(L, (lua_Number)__builtin_sqrt(norm));
  return 3;
}

static int array_close(lua_State *L) {
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylmL_array_close(ylmL_check(L, 1, YLM_ARRAY));
  ylmL_disown(L, 1);
  return 0;
}

/* array_is_free(array) -> true where no call whose progress function runs uses its elements */
static int array_is_free(lua_State *L) {
  ylm_status s = ylmL_array_busy(L, ylmL_array_any(L, 1));
  lua_pushboolean(L, true);
  return ylmL_result(L, 1, s, NULL);
}

/* array_overlap(a, b) -> true where they have an element's memory in common */
static int array_overlap(lua_State *L) {
  const ylmL_array *a = ylmL_array_any(L, 1), *b = ylmL_array_any(L, 2);
  lua_pushboolean(L, ylmL_array_overlaps(a, b));
  return 1;
}

static const luaL_Reg functions[] = {{"array_zeros", array_zeros},
                                     {"array_wrap", array_wrap},
                                     {"array_fill", array_fill},
                                     {"array_totable", array_totable},
                                     {"array_info", array_info},
                                     {"array_get", array_get},
                                     {"array_set", array_set},
                                     {"array_view", array_view},
                                     {"array_reshape", array_reshape},
                                     {"array_convert", array_convert},
                                     {"array_pointer", array_pointer},
                                     {"array_finite", array_finite},
                                     {"array_within", array_within},
                                     {"array_distance", array_distance},
                                     {"array_overlap", array_overlap},
                                     {"array_close", array_close},
                                     {"array_is_free", array_is_free},
                                     {"array_set_convention", array_set_convention},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", array_close}, {NULL, NULL}};

void ylmL_open_array(lua_State *L) {
  ylmL_type(L, YLM_ARRAY, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
