/* figure.c - shapes, what pictures are made of, and files of cells. For lua/ylm/view/. */
#include "../binding_figure.h"

#include <math.h>
#include <string.h>

#define PIECES "ylm.figure_pieces"

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

/* info(shape) -> points, cells, {x0 y0 z0 x1 y1 z1} or nil */
static int shape_info(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  double b[6];
  ylmL_push_count(L, s->points);
  ylmL_push_count(L, s->cells);
  if (!ylm_figure_shape_bounds(s, b)) return 2;
  ylmL_push_bounds(L, b);
  return 3;
}

/* reach(shape, directions [n][3], doubles) -> list of the largest products of points and
   directions */
static int shape_reach(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  size_t n;
  const double *direction = ylmL_doubles(L, 2, 3, &n);
  double *reach = ylm_alloc(n, sizeof *reach);
  if (!reach) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_figure_shape_reach(s, n, direction, reach);
  lua_createtable(L, (int)n, 0);
  for (size_t i = 0; i < n; i++) {
    lua_pushnumber(L, reach[i]);
    lua_rawseti(L, -2, (int)i + 1);
  }
  ylm_free(reach);
  return 1;
}

/* One-based triangles [m][3] of an array of either type as indices, which the caller frees. */
static ylm_status indices(const ylmL_array *a, size_t points, uint32_t **out) {
  *out = ylm_alloc(a->count, sizeof **out);
  if (!*out) return YLM_ENOMEM;
  for (size_t i = 0; i < a->count; i++) {
    double x = ylmL_array_get(a, i);
    if (!(x >= 1 && x <= (double)points)) return YLM_ERANGE;
    (*out)[i] = (uint32_t)x - 1;
  }
  return YLM_OK;
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
  uint32_t *index;
  ylm_status status = indices(t, n, &index);
  if (status == YLM_OK)
    status = ylm_figure_add_mesh(s, n, position, normal, colour, colours == 1, t->count / 3, index,
                                 opacity);
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

typedef struct lobes_form {
  ylmL_array *coefficients;
  int centre, scale, basis; /* on the stack */
  double positive[3], negative[3];
  int detail;
  bool fit;
} lobes_form;

static const ylmL_entry lobes_entries[] = {
    YLML(lobes_form, coefficients, "coefficients", ARRAY),
    YLML(lobes_form, centre, "centre", VALUE),
    YLML(lobes_form, scale, "scale", VALUE),
    YLML(lobes_form, positive, "positive", NUMBERS),
    YLML(lobes_form, negative, "negative", NUMBERS),
    YLML(lobes_form, detail, "detail", INT, .least = 0, .most = 6),
    YLML(lobes_form, basis, "basis", VALUE),
    YLML(lobes_form, fit, "fit", BOOL),
    {.name = NULL}};

/* lobes(shape, {coefficients [n][count], centre, scale, positive, negative, detail, basis, fit}) */
static int shape_lobes(lua_State *L) {
  lobes_form f = {.detail = 0};
  ylm_figure_shape *s = shape_at(L, 1);
  ylmL_read(L, 2, lobes_entries, &f);
  const ylmL_array *c = f.coefficients;
  size_t n, rows;
  const double *centre = ylmL_doubles(L, f.centre, 3, &n),
               *scale = ylmL_doubles_of(L, f.scale, 1, n);
  if (n == 0) return 0;
  size_t count = c->count / n;
  const double *basis = ylmL_doubles(L, f.basis, count ? count : 1, &rows);
  if (c->dtype != YLM_DOUBLE || c->count != n * count || rows != ((size_t)4 << 2 * f.detail) + 2)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  return ylmL_result(L, 0,
                     ylm_figure_add_lobes(s, n, (int)count, f.detail, basis, c->data, centre, scale,
                                          f.fit, f.positive, f.negative),
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

/* edges(shape, colours [levels][4], cells...) */
static int shape_edges(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  size_t levels;
  const double *colours = ylmL_doubles(L, 2, 4, &levels);
  ylm_figure_cells c = ylmL_cells(L, 3);
  return ylmL_result(L, 0, ylm_figure_add_edges(s, &c, levels, colours), NULL);
}

/* boxes(shape, colour [n][3], shrink, opacity, cells...) */
static int shape_boxes(lua_State *L) {
  ylm_figure_shape *s = shape_at(L, 1);
  ylm_figure_cells c = ylmL_cells(L, 5);
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

/* Room for the arrays of hexahedra. */
typedef struct arrays {
  ylm_figure_data point[24], cell[24];
} arrays;

/* Hexahedra from i on: points [n][3], corners [m][8] one-based, point arrays, cell arrays. The caller
   frees the corners, which are NULL where memory ran out. */
static ylm_figure_hexahedra hexahedra_at(lua_State *L, int i, arrays *a) {
  ylm_figure_hexahedra h = {.point_data = a->point, .cell_data = a->cell};
  h.point = ylmL_doubles(L, i, 3, &h.points);
  const double *corner = ylmL_doubles(L, i + 1, 8, &h.cells);
  h.point_arrays = file_arrays(L, i + 2, h.points, a->point, 24);
  h.cell_arrays = file_arrays(L, i + 3, h.cells, a->cell, 24);
  int64_t *index = ylm_alloc(h.cells, 8 * sizeof *index);
  for (size_t k = 0; index && k < 8 * h.cells; k++)
    index[k] = isfinite(corner[k]) ? (int64_t)corner[k] - 1 : -1;
  h.corner = index;
  return h;
}

/* save_cells(path, hexahedra...) */
static int save_cells(lua_State *L) {
  arrays a;
  ylm_error e = {0};
  const char *path = luaL_checkstring(L, 1);
  ylm_figure_hexahedra h = hexahedra_at(L, 2, &a);
  ylm_status s = h.corner ? ylm_figure_save_cells(path, &h, &e) : YLM_ENOMEM;
  ylm_free((void *)(uintptr_t)h.corner);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static ylm_figure_pieces **pieces_at(lua_State *L) { return ylmL_check(L, 1, PIECES); }

static int pieces_gc(lua_State *L) {
  ylm_figure_pieces **p = pieces_at(L);
  ylm_figure_pieces_free(*p);
  *p = NULL;
  return 0;
}

/* pieces(path, n) -> a file of n pieces; nothing of it stays without pieces_end */
static int pieces(lua_State *L) {
  ylm_error e = {0};
  const char *path = luaL_checkstring(L, 1);
  size_t n = (size_t)luaL_checknumber(L, 2);
  ylm_figure_pieces **p = lua_newuserdata(L, sizeof *p);
  *p = NULL;
  luaL_getmetatable(L, PIECES);
  lua_setmetatable(L, -2);
  return ylmL_result(L, 1, ylm_figure_pieces_begin(path, n, p, &e), &e);
}

/* pieces_add(pieces, hexahedra...) */
static int pieces_add(lua_State *L) {
  arrays a;
  ylm_error e = {0};
  ylm_figure_pieces **p = pieces_at(L);
  if (!*p) return luaL_argerror(L, 1, "the file has been ended");
  ylm_figure_hexahedra h = hexahedra_at(L, 2, &a);
  ylm_status s = h.corner ? ylm_figure_pieces_add(*p, &h, &e) : YLM_ENOMEM;
  ylm_free((void *)(uintptr_t)h.corner);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* pieces_end(pieces) */
static int pieces_end(lua_State *L) {
  ylm_error e = {0};
  ylm_figure_pieces **p = pieces_at(L), *mine = *p;
  if (!mine) return luaL_argerror(L, 1, "the file has been ended");
  *p = NULL;
  ylm_status s = ylm_figure_pieces_end(mine, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {{"shape", shape_new},
                                     {"shape_info", shape_info},
                                     {"shape_reach", shape_reach},
                                     {"shape_mesh", shape_mesh},
                                     {"shape_spheres", shape_spheres},
                                     {"shape_arrows", shape_arrows},
                                     {"shape_segments", shape_segments},
                                     {"shape_lobes", shape_lobes},
                                     {"shape_edges", shape_edges},
                                     {"shape_boxes", shape_boxes},
                                     {"shape_save", shape_save},
                                     {"figure_sphere", sphere},
                                     {"figure_save_cells", save_cells},
                                     {"figure_pieces", pieces},
                                     {"figure_pieces_add", pieces_add},
                                     {"figure_pieces_end", pieces_end},
                                     {"figure_pieces_discard", pieces_gc},
                                     {"__gc", shape_gc},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", shape_gc}, {NULL, NULL}};
static const luaL_Reg pieces_methods[] = {{"__gc", pieces_gc}, {NULL, NULL}};

void ylmL_open_figure(lua_State *L) {
  ylmL_type(L, PIECES, pieces_methods);
  lua_pop(L, 1);
  ylmL_type(L, YLM_SHAPE, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
