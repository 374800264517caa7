/* sh_rotate.c - binds rotation and conventions. Arguments come sorted from
   lua/ylm/sh/rotate.lua and sh/convert.lua. */
#include "../binding.h"

#include "ylm_sh.h"

#include <string.h>

#define ROTATOR "ylm.sh_rotator"
#define ROTATION "ylm.sh_rotation"

typedef struct handle {
  void *object;
} handle;

static handle *push_handle(lua_State *L, const char *type) {
  handle *h = lua_newuserdata(L, sizeof *h);
  h->object = NULL;
  luaL_getmetatable(L, type);
  lua_setmetatable(L, -2);
  return h;
}

static int rotator_gc(lua_State *L) {
  handle *h = ylmL_check(L, 1, ROTATOR);
  ylm_sh_rotator_free(h->object);
  h->object = NULL;
  return 0;
}

static int rotation_gc(lua_State *L) {
  handle *h = ylmL_check(L, 1, ROTATION);
  ylm_sh_rotation_free(h->object);
  h->object = NULL;
  return 0;
}

/* sh_rotator(lmax) -> plan */
static int sh_rotator(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  int lmax = (int)luaL_checknumber(L, 1);
  handle *h = push_handle(L, ROTATOR);
  ylm_status s = ylm_sh_rotator_create(lmax, (ylm_sh_rotator **)&h->object, &e);
  if (s == YLM_OK) ylmL_charge(L, (size_t)lmax * (size_t)lmax * (size_t)lmax * 16);
  return ylmL_result(L, 1, s, &e);
}

/* n numbers of the table at i */
static void numbers(lua_State *L, int i, int n, double *out) {
  luaL_checktype(L, i, LUA_TTABLE);
  for (int k = 0; k < n; k++) {
    lua_rawgeti(L, i, k + 1);
    out[k] = (double)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
}

/* sh_rotation_matrix(kind, {numbers}) -> list of 9, the nearest rotation, row-major
   kind "matrix" 9 | "axis" x y z angle | "quaternion" w x y z | "zyz" a b c */
static int sh_rotation_matrix(lua_State *L) {
  static const char *const kinds[] = {"matrix", "axis", "quaternion", "zyz", NULL};
  static const int widths[] = {9, 4, 4, 3};
  int kind = luaL_checkoption(L, 1, NULL, kinds);
  double x[9], r[9];
  ylm_error e = {YLM_OK, ""};
  ylm_status s = YLM_OK;
  numbers(L, 2, widths[kind], x);
  switch (kind) {
  case 1: s = ylm_sh_rotation_from_axis(x, x[3], r, &e); break;
  case 2: s = ylm_sh_rotation_from_quaternion(x, r, &e); break;
  case 3: s = ylm_sh_rotation_from_zyz(x, r, &e); break;
  default: memcpy(r, x, sizeof r);
  }
  if (s == YLM_OK) s = ylm_sh_rotation_check(r, r, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  lua_createtable(L, 9, 0);
  for (int k = 0; k < 9; k++) {
    lua_pushnumber(L, r[k]);
    lua_rawseti(L, -2, k + 1);
  }
  return 1;
}

/* Rows of in and out for lmax; a status if they do not fit. */
static ylm_status rows_of(int lmax, const ylmL_array *in, const ylmL_array *out, size_t *rows) {
  if (lmax < 0 || lmax > YLM_SH_ROTATE_LMAX) return YLM_ERANGE;
  size_t count = ylm_sh_count(lmax);
  *rows = in->count / count;
  if (in->count != *rows * count || out->count != in->count) return YLM_ESHAPE;
  return in->dtype == out->dtype ? YLM_OK : YLM_ETYPE;
}

/* sh_rotate(plan, {9}, lmax, in, out, threads, progress) -> true */
static int sh_rotate(lua_State *L) {
  handle *h = ylmL_check(L, 1, ROTATOR);
  double r[9];
  ylm_error e = {YLM_OK, ""};
  numbers(L, 2, 9, r);
  int lmax = (int)luaL_checknumber(L, 3);
  ylmL_array *in = ylmL_array_check(L, 4), *out = ylmL_array_check(L, 5);
  ylmL_progress progress;
  size_t rows;
  ylm_status s = rows_of(lmax, in, out, &rows);
  const ylm_progress *report = ylmL_progress_begin(L, 7, &progress);
  if (s == YLM_OK)
    s = ylm_sh_rotate(h->object, r, lmax, in->dtype, rows, in->data, out->data,
                      (int)luaL_optnumber(L, 6, 0), report, &e);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* sh_rotate_each(plan, frames [n][3][3], lmax, in [n][..][count], out, threads, progress) -> true */
static int sh_rotate_each(lua_State *L) {
  handle *h = ylmL_check(L, 1, ROTATOR);
  ylmL_array *frames = ylmL_array_check(L, 2);
  ylm_error e = {YLM_OK, ""};
  int lmax = (int)luaL_checknumber(L, 3);
  ylmL_array *in = ylmL_array_check(L, 4), *out = ylmL_array_check(L, 5);
  ylmL_progress progress;
  size_t rows, n = frames->count / 9;
  ylm_status s = rows_of(lmax, in, out, &rows);
  const ylm_progress *report = ylmL_progress_begin(L, 7, &progress);
  if (s == YLM_OK && (n == 0 ? rows > 0 : rows % n != 0)) s = YLM_ESHAPE;
  if (s == YLM_OK && frames->dtype != in->dtype) s = YLM_ETYPE;
  if (s == YLM_OK && rows > 0)
    s = ylm_sh_rotate_each(h->object, lmax, in->dtype, n, frames->data, (int)(rows / n), false,
                           in->data, out->data, (int)luaL_optnumber(L, 6, 0), report, &e);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* sh_rotation(plan, {9}, lmax, dtype) -> rotation */
static int sh_rotation(lua_State *L) {
  handle *plan = ylmL_check(L, 1, ROTATOR);
  double r[9];
  ylm_error e = {YLM_OK, ""};
  numbers(L, 2, 9, r);
  int lmax = (int)luaL_checknumber(L, 3);
  ylm_dtype t = (ylm_dtype)luaL_checkoption(L, 4, "double", ylmL_dtype_choices);
  handle *h = push_handle(L, ROTATION);
  ylm_status s =
      ylm_sh_rotation_create(plan->object, r, lmax, t, (ylm_sh_rotation **)&h->object, &e);
  return ylmL_result(L, 1, s, &e);
}

/* sh_rotation_apply(rotation, lmax, in, out, threads, progress) -> true */
static int sh_rotation_apply(lua_State *L) {
  handle *h = ylmL_check(L, 1, ROTATION);
  int lmax = (int)luaL_checknumber(L, 2);
  ylmL_array *in = ylmL_array_check(L, 3), *out = ylmL_array_check(L, 4);
  ylmL_progress progress;
  const ylm_progress *report = ylmL_progress_begin(L, 6, &progress);
  size_t rows;
  ylm_status s = rows_of(lmax, in, out, &rows);
  if (s == YLM_OK && in->dtype != ylm_sh_rotation_dtype(h->object)) s = YLM_ETYPE;
  if (s == YLM_OK)
    s = ylm_sh_rotation_apply(h->object, lmax, rows, in->data, out->data,
                              (int)luaL_optnumber(L, 5, 0), report);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, NULL, &progress);
}

/* sh_rotation_block(rotation, l, out double [2l+1][2l+1]) -> true */
static int sh_rotation_block(lua_State *L) {
  handle *h = ylmL_check(L, 1, ROTATION);
  int l = (int)luaL_checknumber(L, 2);
  ylmL_array *out = ylmL_array_check(L, 3);
  ylm_status s = YLM_OK;
  if (l < 0 || l > YLM_SH_ROTATE_LMAX)
    s = YLM_ERANGE;
  else if (out->count != (size_t)(2 * l + 1) * (size_t)(2 * l + 1) || out->dtype != YLM_DOUBLE)
    s = YLM_ESHAPE;
  if (s == YLM_OK) s = ylm_sh_rotation_block(h->object, l, out->data);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, NULL);
}

/* sh_rotation_reference({9}, lmax, out double [sum of (2l+1)^2]) -> true */
static int sh_rotation_reference(lua_State *L) {
  double r[9];
  numbers(L, 1, 9, r);
  int lmax = (int)luaL_checknumber(L, 2);
  ylmL_array *out = ylmL_array_check(L, 3);
  ylm_status s = YLM_ERANGE;
  if (lmax >= 0 && lmax <= YLM_SH_ROTATE_LMAX) {
    size_t n = (size_t)lmax + 1;
    s = out->count == n * (2 * n - 1) * (2 * n + 1) / 3 && out->dtype == YLM_DOUBLE ? YLM_OK
                                                                                    : YLM_ESHAPE;
  }
  if (s == YLM_OK) s = ylm_sh_rotation_reference(r, lmax, out->data);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, NULL);
}

/* sh_convention(text) -> number */
static int sh_convention(lua_State *L) {
  uint32_t c = 0;
  ylm_error e = {YLM_OK, ""};
  ylm_status s = ylm_sh_convention_parse(luaL_checkstring(L, 1), &c, &e);
  lua_pushnumber(L, c);
  return ylmL_result(L, 1, s, &e);
}

/* sh_convention_name(number) -> text, or nil */
static int sh_convention_name(lua_State *L) {
  char text[64];
  int64_t c;
  if (!ylmL_toint64(L, 1, &c) || c < 0 || c > UINT32_MAX ||
      ylm_sh_convention_name((uint32_t)c, text) != YLM_OK)
    return 0;
  lua_pushstring(L, text);
  return 1;
}

typedef struct convert_form {
  uint64_t from, to;
  size_t rows;
  int lmax, threads, progress; /* progress: on the stack */
} convert_form;

static const ylmL_entry convert_entries[] = {
    YLML(convert_form, from, "from", UINT64, .least = 0, .most = UINT32_MAX),
    YLML(convert_form, to, "to", UINT64, .least = 0, .most = UINT32_MAX),
    YLML(convert_form, lmax, "lmax", INT, .least = 0, .most = YLM_LMAX),
    YLML(convert_form, rows, "rows", COUNT),
    YLML(convert_form, threads, "threads", INT, .optional = true),
    YLML(convert_form, progress, "progress", VALUE),
    {.name = NULL}};

/* The numbers of n rows of coefficients to lmax in a convention. */
static size_t numbers_in(uint32_t convention, size_t n, int lmax) {
  size_t count = ylm_sh_count(lmax);
  switch (ylm_sh_convention_system(convention)) {
  case YLM_SH_SYSTEM_scipy: return 2 * n * count;
  case YLM_SH_SYSTEM_unity: return n / 3 * 28;
  case YLM_SH_SYSTEM_mrtrix:
  case YLM_SH_SYSTEM_dipy: return n * (count + (size_t)lmax + 1) / 2;
  default: return n * count;
  }
}

/* sh_convert(in, out, {from, to, lmax, rows, threads, progress}) -> true; the arrays' sizes were
 * made to fit by the caller */
static int sh_convert(lua_State *L) {
  convert_form f = {.threads = 0};
  ylmL_read(L, 3, convert_entries, &f);
  uint32_t from = (uint32_t)f.from, to = (uint32_t)f.to;
  ylmL_array *in = ylmL_array_check(L, 1), *out = ylmL_array_check(L, 2);
  ylm_error e = {YLM_OK, ""};
  ylmL_progress progress;
  const ylm_progress *report = ylmL_progress_begin(L, f.progress, &progress);
  ylm_status s = YLM_OK;
  if (in->count != numbers_in(from, f.rows, f.lmax) ||
      out->count != numbers_in(to, f.rows, f.lmax) || in->dtype != out->dtype)
    s = YLM_ESHAPE;
  if (s == YLM_OK)
    s = ylm_sh_convert(from, to, f.lmax, in->dtype, f.rows, in->data, out->data, f.threads, report,
                       &e);
  if (s == YLM_OK) out->convention = to;
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* sh_resize(lmax, new lmax, rows, in, out) -> true */
static int sh_resize(lua_State *L) {
  int from = (int)luaL_checknumber(L, 1), to = (int)luaL_checknumber(L, 2);
  int64_t rows;
  ylmL_array *in = ylmL_array_check(L, 4), *out = ylmL_array_check(L, 5);
  if (from < 0 || from > YLM_LMAX || to < 0 || to > YLM_LMAX || !ylmL_toint64(L, 3, &rows) ||
      rows < 0)
    return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t a = ylm_sh_count(from), b = ylm_sh_count(to), n = (size_t)rows;
  if (in->count != n * a || out->count != n * b || in->dtype != out->dtype)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t size = ylm_dtype_size(in->dtype);
  memset(out->data, 0, out->count * size);
  for (size_t i = 0; i < n; i++)
    memcpy((char *)out->data + i * b * size, (const char *)in->data + i * a * size,
           (a < b ? a : b) * size);
  lua_pushboolean(L, 1);
  return 1;
}

static int sh_cosine_factor(lua_State *L) {
  lua_pushnumber(L, ylm_sh_cosine_factor((int)luaL_checknumber(L, 1)));
  return 1;
}

static const luaL_Reg functions[] = {{"sh_rotator", sh_rotator},
                                     {"sh_rotation_matrix", sh_rotation_matrix},
                                     {"sh_rotate", sh_rotate},
                                     {"sh_rotate_each", sh_rotate_each},
                                     {"sh_rotation", sh_rotation},
                                     {"sh_rotation_apply", sh_rotation_apply},
                                     {"sh_rotation_block", sh_rotation_block},
                                     {"sh_rotation_reference", sh_rotation_reference},
                                     {"sh_convention", sh_convention},
                                     {"sh_convention_name", sh_convention_name},
                                     {"sh_convert", sh_convert},
                                     {"sh_resize", sh_resize},
                                     {"sh_cosine_factor", sh_cosine_factor},
                                     {NULL, NULL}};

static const luaL_Reg rotator_methods[] = {{"__gc", rotator_gc}, {NULL, NULL}};
static const luaL_Reg rotation_methods[] = {{"__gc", rotation_gc}, {NULL, NULL}};

void ylmL_open_sh_rotate(lua_State *L) {
  ylmL_type(L, ROTATOR, rotator_methods);
  ylmL_type(L, ROTATION, rotation_methods);
  lua_pop(L, 2);
  luaL_setfuncs(L, functions, 0);
}
