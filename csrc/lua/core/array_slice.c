/* array_slice.c - parts of arrays: views where they lie together in memory, else copies. */
#include "../binding.h"

/* Slices in the list at `i`: first (from 1), step, count of each axis of `a`, in order; raises where one leaves its axis. */
static void check_slices(lua_State *L, int i, const ylmL_array *a, ylm_slice slice[YLM_MAX_AXES]) {
  luaL_checktype(L, i, LUA_TTABLE);
  for (int k = 0; k < a->axes; k++) {
    double x[3];
    for (int j = 0; j < 3; j++) {
      lua_rawgeti(L, i, 3 * k + j + 1);
      x[j] = (double)lua_tonumber(L, -1);
      lua_pop(L, 1);
    }
    double last = x[0] + x[1] * (x[2] - 1), extent = (double)a->shape[k];
    bool within =
        x[2] == 0 || (x[2] > 0 && x[0] >= 1 && x[0] <= extent && last >= 1 && last <= extent);
    if (!within) luaL_argerror(L, i, "a slice leaves its axis");
    slice[k] = (ylm_slice){x[2] == 0 ? 0 : (size_t)x[0] - 1, (ptrdiff_t)x[1], (size_t)x[2]};
  }
}

/* The shape in the list at `i`; raises where it is none. */
static int check_shape(lua_State *L, int i, size_t shape[YLM_MAX_AXES]) {
  luaL_checktype(L, i, LUA_TTABLE);
  size_t axes = lua_rawlen(L, i);
  if (axes < 1 || axes > YLM_MAX_AXES) luaL_argerror(L, i, "no shape");
  for (size_t k = 0; k < axes; k++) {
    lua_rawgeti(L, i, (int)k + 1);
    shape[k] = (size_t)lua_tonumber(L, -1);
    lua_pop(L, 1);
  }
  return (int)axes;
}

/* slice(array, slices, shape of the result, convention) -> array, whether it is a view */
static int array_slice(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1), *b;
  ylm_slice slice[YLM_MAX_AXES];
  size_t shape[YLM_MAX_AXES], start, count = 1, got;
  check_slices(L, 2, a, slice);
  int axes = check_shape(L, 3, shape);
  for (int k = 0; k < a->axes; k++) count *= slice[k].count;
  if (!ylm_shape_count(axes, shape, &got) || got != count)
    return luaL_argerror(L, 3, "another number of elements");
  bool view = count > 0 && ylm_slices_run(a->axes, a->shape, slice, &start);
  if (view)
    b = ylmL_array_part(L, 1, start, axes, shape);
  else {
    b = ylmL_array_unset(L, a->dtype, axes, shape);
    if (!b) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
    ylm_slices_gather(a->axes, a->shape, slice, ylm_numbers_size(a->dtype), a->data, b->data);
  }
  b->convention = (uint32_t)luaL_checknumber(L, 4);
  lua_pushboolean(L, view);
  return 2;
}

/* put(array, slices, array of its type whose elements, in order, are those of the slices) */
static int array_put(lua_State *L) {
  ylmL_array *a = ylmL_array_any(L, 1), *b = ylmL_array_any(L, 3);
  ylm_slice slice[YLM_MAX_AXES];
  size_t count = 1;
  check_slices(L, 2, a, slice);
  for (int k = 0; k < a->axes; k++) count *= slice[k].count;
  if (a->dtype != b->dtype || b->count != count || ylmL_array_overlaps(a, b))
    return luaL_argerror(L, 3, "elements that do not fit");
  ylm_slices_scatter(a->axes, a->shape, slice, ylm_numbers_size(a->dtype), a->data, b->data);
  return 0;
}

/* select(array, float mask, number of its axes) -> [n][..]: the parts of the array where the mask, whose shape is that of
   the array's first axes, is not 0 */
static int array_select(lua_State *L) {
  const ylmL_array *a = ylmL_array_any(L, 1), *mask = ylmL_array_check(L, 2);
  int many = (int)luaL_checkinteger(L, 3);
  if (mask->dtype != YLM_FLOAT || many < 1 || many > a->axes) return luaL_argerror(L, 2, "no mask");
  const float *m = mask->data;
  size_t shape[YLM_MAX_AXES] = {0}, part = ylm_numbers_size(a->dtype), count = 1;
  for (int k = 0; k < many; k++) count *= a->shape[k];
  if (mask->count != count) return luaL_argerror(L, 2, "another number of elements");
  for (size_t i = 0; i < count; i++) shape[0] += m[i] != 0;
  for (int k = many; k < a->axes; k++) {
    shape[k - many + 1] = a->shape[k];
    part *= a->shape[k];
  }
  ylmL_array *b = ylmL_array_unset(L, a->dtype, a->axes - many + 1, shape);
  if (!b) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  b->convention = many == a->axes ? 0 : a->convention;
  char *out = b->data;
  for (size_t i = 0; i < count; i++) {
    if (m[i] == 0) continue;
    ylm_copy(out, (const char *)a->data + i * part, part);
    out += part;
  }
  return 1;
}

static const luaL_Reg functions[] = {{"array_slice", array_slice},
                                     {"array_put", array_put},
                                     {"array_select", array_select},
                                     {NULL, NULL}};

void ylmL_open_array_slice(lua_State *L) { luaL_setfuncs(L, functions, 0); }
