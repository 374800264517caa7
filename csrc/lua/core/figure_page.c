/* figure_page.c - the bytes of pages as strings: lua/ylm/page/. */
#include "../binding_figure.h"
#include "../binding_grid.h"
#include "ylm_math.h"
#include "ylm_sh.h"

/* Room for `bytes` bytes, which goes with the stack. */
static void *room(lua_State *L, size_t bytes) { return lua_newuserdata(L, bytes ? bytes : 1); }

/* page_facts(grid) -> cells, octree cells, points, evaluated, channels, coefficients, leaves with sides, parts; exponent, the
   root's origin [3] and level, or nil, message, code */
static int page_facts(lua_State *L) {
  const ylm_grid *g = ylmL_grid_check(L, 1);
  const ylm_grid_contents *v = ylm_grid_look(g);
  int exponent;
  ylm_error e = {0};
  ylmL_push_count(L, v->cells);
  ylmL_push_count(L, v->octree_cells);
  ylmL_push_count(L, v->points);
  ylmL_push_count(L, v->evaluated);
  lua_pushinteger(L, v->form.channels);
  lua_pushinteger(L, v->count);
  ylmL_push_count(L, v->sides);
  ylmL_push_count(L, v->parts);
  ylm_status s = ylm_figure_page_exponent(g, &exponent, &e);
  if (s != YLM_OK) return 8 + ylmL_result(L, 0, s, &e);
  lua_pushinteger(L, exponent);
  for (int a = 0; a < 3; a++) ylmL_push_count(L, v->root[a]);
  ylmL_push_count(L, (size_t)v->root_level);
  return 13;
}

/* page_cells(grid, another of the same octree or nil) -> bytes of uint32 [cells + parts][12]; with the other, its
   estimated errors, and 0 where the octree of a small file says it */
static int page_cells(lua_State *L) {
  const ylm_grid *g = ylmL_grid_check(L, 1),
                 *from = lua_isnoneornil(L, 2) ? NULL : ylmL_grid_check(L, 2);
  const ylm_grid_contents *v = ylm_grid_look(g);
  size_t bytes = (v->cells + v->parts) * YLM_FIGURE_PAGE_WORDS * sizeof(uint32_t);
  uint32_t *cell = room(L, bytes);
  ylm_figure_page_cells(g, cell);
  if (from) ylm_figure_page_errors(g, from, cell);
  if (from) ylm_figure_page_rest(g, cell);
  lua_pushlstring(L, (const char *)cell, bytes);
  return 1;
}

/* page_frame(grid) -> bytes of doubles: the voxel's edges [3], the cosine's factors over pi [lmax + 1] */
static int page_frame(lua_State *L) {
  const ylm_grid_contents *v = ylm_grid_look(ylmL_grid_check(L, 1));
  double frame[3 + YLM_LMAX + 1];
  for (int a = 0; a < 3; a++)
    frame[a] = (v->form.bounds[a + 3] - v->form.bounds[a]) / v->resolution[a];
  for (int l = 0; l <= v->form.lmax; l++) frame[3 + l] = ylm_sh_cosine_factor(l) / YLM_PI;
  lua_pushlstring(L, (const char *)frame, (3 + (size_t)v->form.lmax + 1) * sizeof *frame);
  return 1;
}

/* page_sides(grid) -> bytes of uint32 [leaves with sides][29] */
static int page_sides(lua_State *L) {
  const ylm_grid *g = ylmL_grid_check(L, 1);
  size_t bytes = ylm_grid_look(g)->sides * YLM_FIGURE_PAGE_SIDE * sizeof(uint32_t);
  uint32_t *record = room(L, bytes);
  ylm_figure_page_sides(g, record);
  lua_pushlstring(L, (const char *)record, bytes);
  return 1;
}

/* page_table(uniform grid) -> bytes of uint32 [z][y][x] */
static int page_table(lua_State *L) {
  const ylm_grid *g = ylmL_grid_check(L, 1);
  const uint32_t *n = ylm_grid_look(g)->resolution;
  size_t bytes = (size_t)n[0] * n[1] * n[2] * sizeof(uint32_t);
  uint32_t *cell = room(L, bytes);
  ylm_figure_page_table(g, cell);
  lua_pushlstring(L, (const char *)cell, bytes);
  return 1;
}

/* page_flags(grid) -> bytes [evaluated]: 1 where a point is in a light or a body, + 8 where it is a ghost */
static int page_flags(lua_State *L) {
  const ylm_grid_contents *v = ylm_grid_look(ylmL_grid_check(L, 1));
  unsigned char *flag = room(L, v->evaluated);
  for (size_t i = 0; i < v->evaluated; i++)
    flag[i] = v->flags[i] & (YLM_GRID_POINT_INVALID | YLM_GRID_POINT_GHOST);
  lua_pushlstring(L, (const char *)flag, v->evaluated);
  return 1;
}

/* Pushes n floats as bytes, of halves where `half`; beyond their range, the largest. */
static void push_numbers(lua_State *L, const float *x, size_t n, bool half) {
  uint16_t *h = half ? room(L, n * sizeof *h) : NULL;
  if (half) ylm_numbers_convert(YLM_FLOAT, YLM_FLOAT16, n, x, h, NULL);
  lua_pushlstring(L, half ? (const char *)h : (const char *)x, n * (half ? sizeof *h : sizeof *x));
  if (half) lua_remove(L, -2);
}

/* page_rows(grid, exponent, precision) -> bytes of rows; of "byte" those of values, slopes, scales */
static int page_rows(lua_State *L) {
  const ylm_grid *g = ylmL_grid_check(L, 1);
  const ylm_grid_contents *v = ylm_grid_look(g);
  int exponent = (int)luaL_checkinteger(L, 2),
      how = luaL_checkoption(L, 3, NULL, ylmL_precision_choices);
  size_t n = v->evaluated, width = (size_t)v->form.channels * (size_t)v->count;
  float *row = room(L, 4 * n * width * sizeof *row);
  ylm_figure_page_rows(g, exponent, row);
  if (how < 2) {
    push_numbers(L, row, 4 * n * width, how == 0);
    return 1;
  }
  float *value = room(L, n * width * sizeof *value), *scale = room(L, 3 * n * sizeof *scale);
  int8_t *slope = room(L, 3 * n * width);
  ylm_figure_page_bytes(n, width, row, value, scale, slope);
  push_numbers(L, value, n * width, true);
  lua_pushlstring(L, (const char *)slope, 3 * n * width);
  push_numbers(L, scale, 3 * n, false);
  return 3;
}

static const float *floats(lua_State *L, int i, size_t *rows) {
  const ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_FLOAT || a->count % 3) luaL_argerror(L, i, "floats [n][3] expected");
  *rows = a->count / 3;
  return a->data;
}

/* page_positions(float array [n][3], {lo}, {step}) -> bytes of uint16 [n][3] */
static int page_positions(lua_State *L) {
  size_t n;
  double lo[3], step[3];
  const float *x = floats(L, 1, &n);
  ylmL_numbers(L, 2, 3, lo);
  ylmL_numbers(L, 3, 3, step);
  uint16_t *out = room(L, 3 * n * sizeof *out);
  ylm_figure_page_positions(n, x, lo, step, out);
  lua_pushlstring(L, (const char *)out, 3 * n * sizeof *out);
  return 1;
}

/* page_normals(float array [n][3]) -> bytes of int16 [n][2] */
static int page_normals(lua_State *L) {
  size_t n;
  const float *x = floats(L, 1, &n);
  int16_t *out = room(L, 2 * n * sizeof *out);
  ylm_figure_page_normals(n, x, out);
  lua_pushlstring(L, (const char *)out, 2 * n * sizeof *out);
  return 1;
}

/* page_triangles(int32 array [m][3] of one-based indices, added) -> bytes of uint32 [m][3], zero-based */
static int page_triangles(lua_State *L) {
  const ylmL_array *a = ylmL_array_any(L, 1);
  uint32_t added = (uint32_t)luaL_checknumber(L, 2), *out = room(L, a->count * sizeof *out);
  for (size_t i = 0; i < a->count; i++) {
    int32_t k;
    ylm_copy(&k, (const char *)a->data + i * sizeof k, sizeof k);
    out[i] = (uint32_t)k - 1 + added;
  }
  lua_pushlstring(L, (const char *)out, a->count * sizeof *out);
  return 1;
}

/* page_planes(bytes, bytes of a number, columns or 0) -> bytes */
static int page_planes(lua_State *L) {
  size_t size;
  const char *in = luaL_checklstring(L, 1, &size);
  size_t bytes = (size_t)luaL_checkinteger(L, 2), columns = (size_t)luaL_checkinteger(L, 3);
  if ((bytes != 1 && bytes != 2 && bytes != 4) || size % bytes)
    return luaL_argerror(L, 2, "1, 2 or 4 bytes");
  unsigned char *out = room(L, size);
  ylm_figure_planes(size / bytes, bytes, columns, in, out);
  lua_pushlstring(L, (const char *)out, size);
  return 1;
}

/* page_base64(bytes) -> text */
static int page_base64(lua_State *L) {
  size_t size;
  const char *in = luaL_checklstring(L, 1, &size);
  size_t length = (size + 2) / 3 * 4;
  char *out = room(L, length);
  ylm_figure_base64(size, (const unsigned char *)in, out);
  lua_pushlstring(L, out, length);
  return 1;
}

/* page_unbase64(text) -> bytes, or nil */
static int page_unbase64(lua_State *L) {
  size_t length, size;
  const char *in = luaL_checklstring(L, 1, &length);
  char *out = room(L, length / 4 * 3 + 1);
  if (!ylm_figure_unbase64(length, in, (unsigned char *)out, &size)) return 0;
  lua_pushlstring(L, out, size);
  return 1;
}

static const luaL_Reg functions[] = {
    {"page_facts", page_facts},       {"page_cells", page_cells},
    {"page_frame", page_frame},       {"page_sides", page_sides},
    {"page_table", page_table},       {"page_flags", page_flags},
    {"page_rows", page_rows},         {"page_positions", page_positions},
    {"page_normals", page_normals},   {"page_triangles", page_triangles},
    {"page_planes", page_planes},     {"page_base64", page_base64},
    {"page_unbase64", page_unbase64}, {NULL, NULL}};

void ylmL_open_figure_page(lua_State *L) { luaL_setfuncs(L, functions, 0); }
