/*
** figure_numbers.c - arrays of numbers that pictures show: ranges, lengths, choices, colours.
*/
#include "../binding_figure.h"
#include "ylm_image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* mix(array, rows, offsets {0-based}, weights, width) -> [rows][width] doubles: in each row the
   weighted sum of pieces of `width` numbers at the offsets */
static int mix(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  size_t n = (size_t)luaL_checknumber(L, 2), width = (size_t)luaL_checknumber(L, 5);
  size_t pieces = lua_rawlen(L, 3), stride = n ? a->count / n : 0, shape[2] = {n, width};
  double offset[8], weight[8];
  if (pieces > 8) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  ylmL_numbers(L, 3, (int)pieces, offset);
  ylmL_numbers(L, 4, (int)pieces, weight);
  for (size_t k = 0; k < pieces; k++)
    if (n && !(offset[k] >= 0 && offset[k] + (double)width <= (double)stride))
      return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 2, shape);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *to = out->data;
  for (size_t i = 0; i < n; i++)
    for (size_t k = 0; k < pieces; k++)
      for (size_t j = 0; j < width; j++) {
        size_t at = i * stride + (size_t)offset[k] + j;
        to[i * width + j] += weight[k] * ylmL_array_get(a, at);
      }
  return 1;
}

/* lengths(array [n][k]) -> [n] */
static int lengths(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  size_t n = a->shape[0], k = n ? a->count / n : 0;
  const double *x = ylmL_doubles(L, 1, 1, NULL);
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 1, &n);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++) {
    double sum = 0;
    for (size_t j = 0; j < k; j++) sum += x[i * k + j] * x[i * k + j];
    ((double *)out->data)[i] = sqrt(sum);
  }
  return 1;
}

/* scaled(array [n][3], factor [n]) -> [n][3] */
static int scaled(lua_State *L) {
  size_t n;
  const double *x = ylmL_doubles(L, 1, 3, &n), *f = ylmL_doubles_of(L, 2, 1, n);
  size_t shape[2] = {n, 3};
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 2, shape);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < 3 * n; i++) ((double *)out->data)[i] = x[i] * f[i / 3];
  return 1;
}

/* range(array) -> least, largest, least above 0 of what is finite; nothing if there is none */
static int range(lua_State *L) {
  size_t n;
  const double *x = ylmL_doubles(L, 1, 1, &n);
  double lo = INFINITY, hi = -INFINITY, positive = INFINITY;
  for (size_t i = 0; i < n; i++) {
    if (!isfinite(x[i])) continue;
    lo = fmin(lo, x[i]);
    hi = fmax(hi, x[i]);
    if (x[i] > 0) positive = fmin(positive, x[i]);
  }
  if (lo > hi) return 0;
  lua_pushnumber(L, lo);
  lua_pushnumber(L, hi);
  if (!isfinite(positive)) return 2;
  lua_pushnumber(L, positive);
  return 3;
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* quantiles(array, part, ...) -> of the finite numbers above 0; nothing if there are none */
static int quantiles(lua_State *L) {
  size_t n, m = 0;
  const double *x = ylmL_doubles(L, 1, 1, &n);
  int wanted = lua_gettop(L) - 1;
  double part[8];
  for (int i = 0; i < wanted && i < 8; i++) part[i] = (double)luaL_checknumber(L, 2 + i);
  double *sorted = ylm_alloc(n, sizeof *sorted);
  if (!sorted) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++)
    if (isfinite(x[i]) && x[i] > 0) sorted[m++] = x[i];
  qsort(sorted, m, sizeof *sorted, ascending);
  for (int i = 0; i < wanted && i < 8 && m > 0; i++)
    lua_pushnumber(L, sorted[(size_t)(fmin(1, fmax(0, part[i])) * (double)(m - 1) + 0.5)]);
  ylm_free(sorted);
  return m > 0 ? (wanted < 8 ? wanted : 8) : 0;
}

/* bounds(origin [n][3], size [n][3] | nil) -> {x0 y0 z0 x1 y1 z1}, or nothing if n is 0 */
static int bounds(lua_State *L) {
  size_t n;
  const double *origin = ylmL_doubles(L, 1, 3, &n), *size = ylmL_doubles_of(L, 2, 3, n);
  double b[6];
  for (size_t i = 0; i < 3 * n; i++) {
    double lo = origin[i], hi = lo + (size ? size[i] : 0);
    size_t a = i % 3;
    if (i < 3 || lo < b[a]) b[a] = lo;
    if (i < 3 || hi > b[3 + a]) b[3 + a] = hi;
  }
  if (n == 0) return 0;
  ylmL_push_bounds(L, b);
  return 1;
}

/* thin(points [n][3], spacing, most) -> a mask [n] of points no two of which share a cube of that
 * size */
static int thin(lua_State *L) {
  size_t n, kept = 0, room = 64;
  const double *p = ylmL_doubles(L, 1, 3, &n);
  double spacing = (double)luaL_checknumber(L, 2), most = (double)luaL_checknumber(L, 3);
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 1, &n);
  while (room < 2 * n) room *= 2;
  int64_t(*slot)[4] = ylm_alloc_zero(room, sizeof *slot);
  if (!out || !slot) {
    ylm_free(slot);
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  }
  for (size_t i = 0; i < n && (double)kept < most; i++) {
    int64_t key[4] = {0, 0, 0, 1};
    for (size_t a = 0; a < 3; a++) key[a] = (int64_t)floor(p[3 * i + a] / spacing + 0.5);
    uint64_t h = (uint64_t)key[0] * 0x9E3779B97F4A7C15u ^ (uint64_t)key[1] * 0xBF58476D1CE4E5B9u ^
                 (uint64_t)key[2] * 0x94D049BB133111EBu;
    size_t k = (size_t)(h ^ h >> 32) & (room - 1);
    while (slot[k][3] && memcmp(slot[k], key, sizeof key) != 0) k = (k + 1) & (room - 1);
    if (slot[k][3]) continue;
    memcpy(slot[k], key, sizeof key);
    ((double *)out->data)[i] = 1;
    kept++;
  }
  ylm_free(slot);
  ylmL_push_count(L, kept);
  return 2;
}

/* pick(array [n][..], drawn [n]) -> the rows where drawn is not 0 */
static int pick(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  size_t n = a->shape[0], width = n ? a->count / n : 0, kept = 0, shape[YLM_MAX_AXES];
  const double *x = ylmL_doubles(L, 1, 1, NULL), *drawn = ylmL_doubles_of(L, 2, 1, n);
  for (size_t i = 0; i < n; i++) kept += drawn[i] != 0;
  memcpy(shape, a->shape, sizeof shape);
  shape[0] = kept;
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, a->axes, shape);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *to = out->data;
  for (size_t i = 0; i < n; i++) {
    if (drawn[i] == 0) continue;
    memcpy(to, x + i * width, width * sizeof *to);
    to += width;
  }
  return 1;
}

/* colours(array, none {r, g, b}, scale...) -> [..][3] */
static int colours(lua_State *L) {
  size_t n;
  const double *x = ylmL_doubles(L, 1, 1, &n);
  double none[3];
  ylmL_numbers(L, 2, 3, none);
  ylm_figure_scale scale = ylmL_scale(L, 3);
  size_t shape[2] = {n, 3};
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 2, shape);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 1, ylm_figure_colours(&scale, n, x, none, out->data), NULL);
}

static int map_names(lua_State *L) {
  lua_newtable(L);
  for (int i = 0; i < YLM_COLOURMAP_COUNT; i++) {
    lua_pushstring(L, ylm_colourmap_name((ylm_colourmap)i));
    lua_rawseti(L, -2, i + 1);
  }
  return 1;
}

static const luaL_Reg functions[] = {{"figure_mix", mix},
                                     {"figure_lengths", lengths},
                                     {"figure_scaled", scaled},
                                     {"figure_range", range},
                                     {"figure_bounds", bounds},
                                     {"figure_quantiles", quantiles},
                                     {"figure_pick", pick},
                                     {"figure_thin", thin},
                                     {"figure_colours", colours},
                                     {"figure_map_names", map_names},
                                     {NULL, NULL}};

void ylmL_open_figure_numbers(lua_State *L) { luaL_setfuncs(L, functions, 0); }
