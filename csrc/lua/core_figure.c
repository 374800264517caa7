/* core_figure.c - shapes, volumes and canvases: what pictures are made of. For lua/ylm/view*.lua.
 */
#include "figure.h"
#include "ylm_image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- shapes ------------------------------------------------------------------- */

static ylm_figure_shape *shape_at(lua_State *L, int i) { return ylmL_check(L, i, YLM_SHAPE); }

static int shape_gc(lua_State *L) {
  ylm_figure_shape_clear(shape_at(L, 1));
  return 0;
}

/* shape(corners) */
static int shape_new(lua_State *L) {
  int corners = (int)luaL_checknumber(L, 1);
  ylm_figure_shape *s = lua_newuserdata(L, sizeof *s);
  ylm_figure_shape_init(s, corners == 2 ? 2 : 3);
  luaL_getmetatable(L, YLM_SHAPE);
  lua_setmetatable(L, -2);
  return 1;
}

static void push_bounds(lua_State *L, const double b[6]) {
  lua_createtable(L, 6, 0);
  for (int i = 0; i < 6; i++) {
    lua_pushnumber(L, b[i]);
    lua_rawseti(L, -2, i + 1);
  }
}

/* info(shape) -> points, cells, {x0 y0 z0 x1 y1 z1} or nil */
static int shape_info(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  double b[6];
  ylmL_push_count(L, s->points);
  ylmL_push_count(L, s->cells);
  if (!ylm_figure_shape_bounds(s, b)) return 2;
  push_bounds(L, b);
  return 3;
}

/* One-based triangles [m][3] of an array of either type as indices; NULL if one is out of range. */
static uint32_t *indices(const ylmL_array *a, size_t points) {
  uint32_t *out = ylm_alloc(a->count, sizeof *out);
  for (size_t i = 0; out && i < a->count; i++) {
    double x = a->dtype == YLM_DOUBLE ? ((double *)a->data)[i] : (double)((float *)a->data)[i];
    if (!(x >= 1 && x <= (double)points)) {
      ylm_free(out);
      return NULL;
    }
    out[i] = (uint32_t)x - 1;
  }
  return out;
}

/* mesh(shape, position, normal | nil, colour, triangles (one-based), opacity) */
static int shape_mesh(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  size_t n, colours;
  const double *position = ylmL_doubles(L, 2, 3, &n), *normal = ylmL_doubles_of(L, 3, 3, n);
  const double *colour = ylmL_doubles(L, 4, 3, &colours);
  ylmL_array *t = ylmL_array_check(L, 5);
  if (colours != n && colours != 1) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  double opacity = (double)luaL_checknumber(L, 6);
  uint32_t *index = indices(t, n);
  if (!index) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  ylm_status status = ylm_figure_add_mesh(s, n, position, normal, colour, colours == 1,
                                          t->count / 3, index, opacity);
  ylm_free(index);
  return ylmL_result(L, 0, status, NULL);
}

/* spheres(shape, centre, radius, colour, detail) */
static int shape_spheres(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  size_t n;
  const double *centre = ylmL_doubles(L, 2, 3, &n), *radius = ylmL_doubles_of(L, 3, 1, n),
               *colour = ylmL_doubles_of(L, 4, 3, n);
  return ylmL_result(
      L, 0, ylm_figure_add_spheres(s, n, centre, radius, colour, (int)luaL_checknumber(L, 5)),
      NULL);
}

/* arrows(shape, at, along, colour) */
static int shape_arrows(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  size_t n;
  const double *at = ylmL_doubles(L, 2, 3, &n), *along = ylmL_doubles_of(L, 3, 3, n),
               *colour = ylmL_doubles_of(L, 4, 3, n);
  return ylmL_result(L, 0, ylm_figure_add_arrows(s, n, at, along, colour), NULL);
}

/* segments(shape, from, to, {r, g, b, a}) */
static int shape_segments(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  size_t n;
  double colour[4];
  const double *from = ylmL_doubles(L, 2, 3, &n), *to = ylmL_doubles_of(L, 3, 3, n);
  ylmL_numbers(L, 4, 4, colour);
  return ylmL_result(L, 0, ylm_figure_add_segments(s, n, from, to, colour), NULL);
}

/* lobes(shape, coefficient [n][count], centre, scale, positive, negative, detail, basis, fit) */
static int shape_lobes(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  ylmL_array *c = ylmL_array_check(L, 2);
  size_t n, rows;
  const double *centre = ylmL_doubles(L, 3, 3, &n), *scale = ylmL_doubles_of(L, 4, 1, n);
  double positive[3], negative[3];
  ylmL_numbers(L, 5, 3, positive);
  ylmL_numbers(L, 6, 3, negative);
  int detail = (int)luaL_checknumber(L, 7);
  if (n == 0) return 0;
  size_t count = c->count / n;
  const double *basis = ylmL_doubles(L, 8, count ? count : 1, &rows);
  if (c->dtype != YLM_DOUBLE || c->count != n * count || detail < 0 || detail > 6 ||
      rows != ((size_t)4 << 2 * detail) + 2)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  return ylmL_result(L, 0,
                     ylm_figure_add_lobes(s, n, (int)count, detail, basis, c->data, centre, scale,
                                          lua_toboolean(L, 9), positive, negative),
                     NULL);
}

/* sphere(detail) -> directions [points][3] */
static int sphere(lua_State *L) {
  size_t points, triangles;
  double *direction;
  uint32_t *index;
  ylm_status s =
      ylm_figure_sphere((int)luaL_checknumber(L, 1), &points, &direction, &triangles, &index);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  size_t shape[2] = {points, 3};
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 2, shape);
  if (a) memcpy(a->data, direction, points * 3 * sizeof(double));
  ylm_free(direction);
  ylm_free(index);
  return ylmL_result(L, 1, a ? YLM_OK : YLM_ENOMEM, NULL);
}

/* Cells from i on: origin, size, level | nil, drawn | nil, corner | nil. */
static ylm_figure_cells cells_at(lua_State *L, int i) {
  ylm_figure_cells c = {0, NULL, NULL, NULL, NULL, NULL};
  c.origin = ylmL_doubles(L, i, 3, &c.n);
  c.size = ylmL_doubles_of(L, i + 1, 3, c.n);
  c.level = ylmL_doubles_of(L, i + 2, 1, c.n);
  c.drawn = ylmL_doubles_of(L, i + 3, 1, c.n);
  c.corner = ylmL_doubles_of(L, i + 4, 8, c.n);
  return c;
}

/* edges(shape, colours [levels][4], cells...) */
static int shape_edges(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  size_t levels;
  const double *colours = ylmL_doubles(L, 2, 4, &levels);
  ylm_figure_cells c = cells_at(L, 3);
  return ylmL_result(L, 0, ylm_figure_add_edges(s, &c, levels, colours), NULL);
}

/* boxes(shape, colour [n][3], shrink, opacity, cells...) */
static int shape_boxes(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  ylm_figure_cells c = cells_at(L, 5);
  const double *colour = ylmL_doubles_of(L, 2, 3, c.n);
  return ylmL_result(L, 0,
                     ylm_figure_add_boxes(s, &c, colour, (double)luaL_checknumber(L, 3),
                                          (double)luaL_checknumber(L, 4)),
                     NULL);
}

static int shape_save(lua_State *L) {
  ylm_error e;
  ylm_status s = ylm_figure_save_shape(luaL_checkstring(L, 2), shape_at(L, 1), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* -- volumes ------------------------------------------------------------------ */

static ylm_figure_volume *volume_at(lua_State *L, int i) { return ylmL_check(L, i, YLM_VOLUME); }

static size_t voxels(const ylm_figure_volume *v) { return v->size[0] * v->size[1] * v->size[2]; }

static int volume_gc(lua_State *L) {
  ylm_figure_volume_clear(volume_at(L, 1));
  return 0;
}

/* volume({x0 y0 z0 x1 y1 z1}, {nx, ny, nz}, components) */
static int volume_new(lua_State *L) {
  double b[6], size[3];
  ylmL_numbers(L, 1, 6, b);
  ylmL_numbers(L, 2, 3, size);
  size_t n[3];
  for (int a = 0; a < 3; a++) {
    if (!(size[a] >= 1 && size[a] <= 65536)) return ylmL_result(L, 0, YLM_ERANGE, NULL);
    n[a] = (size_t)size[a];
  }
  int components = (int)luaL_optnumber(L, 3, 1);
  ylm_figure_volume *v = lua_newuserdata(L, sizeof *v);
  memset(v, 0, sizeof *v);
  luaL_getmetatable(L, YLM_VOLUME);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_figure_volume_init(v, b, n, components);
  if (s == YLM_OK) ylmL_charge(L, voxels(v) * (size_t)components * sizeof(float));
  return ylmL_result(L, 1, s, NULL);
}

/* fill(volume, value, pointwise, cells...) */
static int volume_fill(lua_State *L) {
  ylm_figure_volume *v = volume_at(L, 1);
  bool pointwise = lua_toboolean(L, 3);
  ylm_figure_cells c = cells_at(L, 4);
  size_t rows;
  const double *value = ylmL_doubles(L, 2, pointwise ? (size_t)v->components : 1, &rows);
  if (!pointwise && rows != c.n) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  return ylmL_result(L, 0, ylm_figure_fill(v, &c, value, rows, pointwise), NULL);
}

/* set(volume, array [nz][ny][nx][components]) */
static int volume_set(lua_State *L) {
  ylm_figure_volume *v = volume_at(L, 1);
  ylmL_array *a = ylmL_array_check(L, 2);
  if (a->count != voxels(v) * (size_t)v->components) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  for (size_t i = 0; i < a->count; i++)
    v->value[i] = a->dtype == YLM_FLOAT ? ((float *)a->data)[i] : (float)((double *)a->data)[i];
  return 0;
}

/* resample(to, from) */
static int volume_resample(lua_State *L) {
  ylm_figure_volume *to = volume_at(L, 1), *from = volume_at(L, 2);
  if (to->components != from->components) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_figure_resample(to, from);
  return 0;
}

/* values(volume) -> array [nz][ny][nx][components] */
static int volume_values(lua_State *L) {
  ylm_figure_volume *v = volume_at(L, 1);
  size_t shape[4] = {v->size[2], v->size[1], v->size[0], (size_t)v->components};
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 4, shape);
  if (a) memcpy(a->data, v->value, a->count * sizeof(float));
  return ylmL_result(L, 1, a ? YLM_OK : YLM_ENOMEM, NULL);
}

/* centres(volume) -> the voxels' middles [voxels][3] */
static int volume_centres(lua_State *L) {
  ylm_figure_volume *v = volume_at(L, 1);
  size_t shape[2] = {voxels(v), 3}, i = 0;
  ylmL_array *a = ylmL_array_new(L, YLM_DOUBLE, 2, shape);
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *p = a->data;
  for (size_t z = 0; z < v->size[2]; z++)
    for (size_t y = 0; y < v->size[1]; y++)
      for (size_t x = 0; x < v->size[0]; x++, i++) {
        p[3 * i] = v->origin[0] + v->spacing[0] * (double)x;
        p[3 * i + 1] = v->origin[1] + v->spacing[1] * (double)y;
        p[3 * i + 2] = v->origin[2] + v->spacing[2] * (double)z;
      }
  return 1;
}

/* range(volume) -> least, largest, least above 0; nothing if it is empty */
static int volume_range(lua_State *L) {
  double lo, hi, positive;
  if (!ylm_figure_volume_range(volume_at(L, 1), &lo, &hi, &positive)) return 0;
  lua_pushnumber(L, lo);
  lua_pushnumber(L, hi);
  if (!isfinite(positive)) return 2;
  lua_pushnumber(L, positive);
  return 3;
}

static int volume_smooth(lua_State *L) {
  return ylmL_result(L, 0, ylm_figure_volume_smooth(volume_at(L, 1), (int)luaL_checknumber(L, 2)),
                     NULL);
}

static int volume_save(lua_State *L) {
  ylm_error e;
  ylm_status s =
      ylm_figure_save_volume(luaL_checkstring(L, 2), volume_at(L, 1), luaL_checkstring(L, 3), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* streamlines(shape, volume, seeds, step, room, fewest, radius, scale...) */
static int shape_streamlines(lua_State *L) {
  size_t n;
  const double *seed = ylmL_doubles(L, 3, 3, &n);
  ylm_figure_scale scale = ylmL_scale(L, 8);
  return ylmL_result(L, 0,
                     ylm_figure_add_streamlines(
                         shape_at(L, 1), volume_at(L, 2), n, seed, (double)luaL_checknumber(L, 4),
                         (size_t)luaL_checknumber(L, 5), (size_t)luaL_checknumber(L, 6),
                         (double)luaL_checknumber(L, 7), &scale),
                     NULL);
}

/* -- numbers ------------------------------------------------------------------- */

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
        double x =
            a->dtype == YLM_DOUBLE ? ((double *)a->data)[at] : (double)((float *)a->data)[at];
        to[i * width + j] += weight[k] * x;
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
  push_bounds(L, b);
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

/* -- colours ------------------------------------------------------------------- */

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

/* -- canvases ------------------------------------------------------------------ */

static ylm_figure_canvas *canvas_at(lua_State *L, int i) { return ylmL_check(L, i, YLM_CANVAS); }

static int canvas_gc(lua_State *L) {
  ylm_figure_canvas_clear(canvas_at(L, 1));
  return 0;
}

/* canvas(width, height, {r, g, b}) */
static int canvas_new(lua_State *L) {
  int64_t w, h;
  double rgb[3];
  if (!ylmL_toint64(L, 1, &w) || !ylmL_toint64(L, 2, &h) || w < 1 || h < 1 || w > 32768 ||
      h > 32768)
    return ylmL_result(L, 0, YLM_ERANGE, NULL);
  ylmL_numbers(L, 3, 3, rgb);
  ylm_figure_canvas *c = lua_newuserdata(L, sizeof *c);
  memset(c, 0, sizeof *c);
  luaL_getmetatable(L, YLM_CANVAS);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_figure_canvas_init(c, (int)w, (int)h, rgb);
  if (s == YLM_OK) ylmL_charge(L, (size_t)(w * h * 3));
  return ylmL_result(L, 1, s, NULL);
}

static int canvas_size(lua_State *L) {
  ylm_figure_canvas *c = canvas_at(L, 1);
  lua_pushnumber(L, c->width);
  lua_pushnumber(L, c->height);
  return 2;
}

/* rectangle(canvas, x, y, w, h, {r, g, b, a}) */
static int canvas_rectangle(lua_State *L) {
  double rgba[4];
  ylmL_numbers(L, 6, 4, rgba);
  ylm_figure_canvas_rectangle(canvas_at(L, 1), (double)luaL_checknumber(L, 2),
                              (double)luaL_checknumber(L, 3), (double)luaL_checknumber(L, 4),
                              (double)luaL_checknumber(L, 5), rgba);
  return 0;
}

/* line(canvas, x0, y0, x1, y1, width, {r, g, b, a}) */
static int canvas_line(lua_State *L) {
  double rgba[4];
  ylmL_numbers(L, 7, 4, rgba);
  ylm_figure_canvas_line(canvas_at(L, 1), (double)luaL_checknumber(L, 2),
                         (double)luaL_checknumber(L, 3), (double)luaL_checknumber(L, 4),
                         (double)luaL_checknumber(L, 5), (double)luaL_checknumber(L, 6), rgba);
  return 0;
}

/* copy(canvas, x, y, w, h, from, sx, sy, sw, sh, sharp) */
static int canvas_copy(lua_State *L) {
  ylm_figure_canvas_copy(canvas_at(L, 1), (int)luaL_checknumber(L, 2), (int)luaL_checknumber(L, 3),
                         (int)luaL_checknumber(L, 4), (int)luaL_checknumber(L, 5), canvas_at(L, 6),
                         (double)luaL_checknumber(L, 7), (double)luaL_checknumber(L, 8),
                         (double)luaL_checknumber(L, 9), (double)luaL_checknumber(L, 10),
                         lua_toboolean(L, 11));
  return 0;
}

/* set(canvas, array [h][w][3]): display values 0 .. 1 */
static int canvas_set(lua_State *L) {
  ylm_figure_canvas *c = canvas_at(L, 1);
  ylmL_array *a = ylmL_array_check(L, 2);
  if (a->count != (size_t)c->width * (size_t)c->height * 3)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  for (size_t i = 0; i < a->count; i++) {
    double x = a->dtype == YLM_DOUBLE ? ((double *)a->data)[i] : (double)((float *)a->data)[i];
    c->pixel[i] = x >= 1 ? 255 : x > 0 ? (uint8_t)(x * 255 + 0.5) : 0;
  }
  return 0;
}

/* image(image, layer | nil, tone, stops) -> canvas of the layer's first three channels (or one) */
static int canvas_image(lua_State *L) {
  ylm_image *image = ylmL_image_check(L, 1);
  const ylm_layer *layer = ylm_image_find(image, luaL_optstring(L, 2, NULL));
  ylm_tone tone;
  static const double black[3] = {0, 0, 0};
  if (!layer || !ylm_tone_find(luaL_checkstring(L, 3), &tone))
    return ylmL_result(L, 0, YLM_EINVAL, NULL);
  double stops = (double)luaL_checknumber(L, 4);
  ylm_figure_canvas *c = lua_newuserdata(L, sizeof *c);
  memset(c, 0, sizeof *c);
  luaL_getmetatable(L, YLM_CANVAS);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_figure_canvas_init(c, image->width, image->height, black);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  size_t k = (size_t)layer->channels;
  for (size_t i = 0; i < (size_t)c->width * (size_t)c->height; i++) {
    float y[4];
    ylm_tone_map(tone, stops, k, layer->data + i * k, y);
    for (size_t a = 0; a < 3; a++)
      c->pixel[3 * i + a] = (uint8_t)(255 * fminf(1, fmaxf(0, y[k >= 3 ? a : 0])) + 0.5f);
  }
  return 1;
}

/* pixels(canvas) -> float array [h][w][3], 0 .. 1 */
static int canvas_pixels(lua_State *L) {
  ylm_figure_canvas *c = canvas_at(L, 1);
  size_t shape[3] = {(size_t)c->height, (size_t)c->width, 3};
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 3, shape);
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < a->count; i++) ((float *)a->data)[i] = (float)c->pixel[i] / 255;
  return 1;
}

/* -- files ---------------------------------------------------------------------- */

/* The arrays of the list {{name, array}, ...} at i; returns their number. */
static int file_arrays(lua_State *L, int i, size_t rows, ylm_figure_data *out, int room) {
  luaL_checktype(L, i, LUA_TTABLE);
  int n = (int)lua_rawlen(L, i);
  if (n > room) luaL_argerror(L, i, "too many arrays");
  for (int k = 0; k < n; k++) {
    lua_rawgeti(L, i, k + 1);
    lua_rawgeti(L, -1, 1);
    lua_rawgeti(L, -2, 2);
    ylmL_array *a = ylmL_array_check(L, lua_gettop(L));
    out[k].name = lua_tostring(L, -2);
    out[k].type = a->dtype == YLM_DOUBLE ? YLM_FIGURE_F64 : YLM_FIGURE_F32;
    out[k].n = rows;
    out[k].components = rows ? (int)(a->count / rows) : 1;
    out[k].data = a->data;
    if (!out[k].name || (rows && a->count % rows)) luaL_argerror(L, i, "arrays do not fit");
    lua_pop(L, 3); /* the list keeps them */
  }
  return n;
}

/* save_cells(path, points [n][3], corners [m][8] one-based, point arrays, cell arrays) */
static int save_cells(lua_State *L) {
  const char *path = luaL_checkstring(L, 1);
  size_t points, cells;
  const double *point = ylmL_doubles(L, 2, 3, &points), *corner = ylmL_doubles(L, 3, 8, &cells);
  ylm_figure_data p[24], c[24];
  int np = file_arrays(L, 4, points, p, 24), nc = file_arrays(L, 5, cells, c, 24);
  int64_t *index = ylm_alloc(cells, 8 * sizeof *index);
  if (!index) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < 8 * cells; i++)
    index[i] = isfinite(corner[i]) ? (int64_t)corner[i] - 1 : -1;
  ylm_error e;
  ylm_status s = ylm_figure_save_cells(path, points, point, cells, index, np, p, nc, c, &e);
  ylm_free(index);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
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

static const luaL_Reg functions[] = {{"shape", shape_new},
                                     {"shape_info", shape_info},
                                     {"shape_mesh", shape_mesh},
                                     {"shape_spheres", shape_spheres},
                                     {"shape_arrows", shape_arrows},
                                     {"shape_segments", shape_segments},
                                     {"shape_lobes", shape_lobes},
                                     {"shape_edges", shape_edges},
                                     {"shape_boxes", shape_boxes},
                                     {"shape_streamlines", shape_streamlines},
                                     {"shape_save", shape_save},
                                     {"figure_sphere", sphere},
                                     {"volume", volume_new},
                                     {"volume_fill", volume_fill},
                                     {"volume_set", volume_set},
                                     {"volume_values", volume_values},
                                     {"volume_centres", volume_centres},
                                     {"volume_range", volume_range},
                                     {"volume_smooth", volume_smooth},
                                     {"volume_resample", volume_resample},
                                     {"volume_save", volume_save},
                                     {"figure_mix", mix},
                                     {"figure_lengths", lengths},
                                     {"figure_scaled", scaled},
                                     {"figure_range", range},
                                     {"figure_bounds", bounds},
                                     {"figure_quantiles", quantiles},
                                     {"figure_pick", pick},
                                     {"figure_thin", thin},
                                     {"figure_colours", colours},
                                     {"figure_map_names", map_names},
                                     {"canvas", canvas_new},
                                     {"canvas_size", canvas_size},
                                     {"canvas_rectangle", canvas_rectangle},
                                     {"canvas_line", canvas_line},
                                     {"canvas_copy", canvas_copy},
                                     {"canvas_set", canvas_set},
                                     {"canvas_image", canvas_image},
                                     {"canvas_pixels", canvas_pixels},
                                     {"figure_save_cells", save_cells},
                                     {NULL, NULL}};

static const luaL_Reg shape_methods[] = {{"__gc", shape_gc}, {NULL, NULL}};
static const luaL_Reg volume_methods[] = {{"__gc", volume_gc}, {NULL, NULL}};
static const luaL_Reg canvas_methods[] = {{"__gc", canvas_gc}, {NULL, NULL}};

void ylmL_open_figure(lua_State *L) {
  ylmL_type(L, YLM_SHAPE, shape_methods);
  ylmL_type(L, YLM_VOLUME, volume_methods);
  ylmL_type(L, YLM_CANVAS, canvas_methods);
  lua_pop(L, 3);
  luaL_setfuncs(L, functions, 0);
}
