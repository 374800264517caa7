/* vtk.c - opens ylm.c.vtk: scenes drawn by libylm_vtk.so. For lua/ylm/view*.lua. */
#include "vtk.h"
#include "../binding_figure.h"
#include "ylm_vtk.h"

#include <string.h>

static ylm_vtk_scene *scene_at(lua_State *L, int i) {
  return *(ylm_vtk_scene **)ylmL_check(L, i, YLM_VTK_SCENE);
}

static int scene_gc(lua_State *L) {
  ylm_vtk_scene **s = ylmL_check(L, 1, YLM_VTK_SCENE);
  if (*s) ylm_vtk_scene_free(*s);
  *s = NULL;
  return 0;
}

static int scene_new(lua_State *L) {
  ylm_error e;
  ylm_vtk_scene **s = lua_newuserdata(L, sizeof *s);
  *s = NULL;
  luaL_getmetatable(L, YLM_VTK_SCENE);
  lua_setmetatable(L, -2);
  return ylmL_result(L, 1, ylm_vtk_scene_create(s, &e), &e);
}

typedef struct style_form {
  ylm_vtk_style style;
  bool flat;
} style_form;

static const ylmL_entry style_entries[] = {YLML(style_form, style.ambient, "ambient", DOUBLE),
                                           YLML(style_form, style.diffuse, "diffuse", DOUBLE),
                                           YLML(style_form, style.specular, "specular", DOUBLE),
                                           YLML(style_form, style.line_width, "line_width", DOUBLE),
                                           YLML(style_form, style.opacity, "opacity", DOUBLE),
                                           YLML(style_form, flat, "flat", BOOL),
                                           {.name = NULL}};

/* shape(scene, shape, {ambient, diffuse, specular, line_width, opacity, flat}) */
static int scene_shape(lua_State *L) {
  ylm_error e;
  style_form f = {.flat = false};
  ylmL_read(L, 3, style_entries, &f);
  f.style.flat = f.flat;
  ylm_status s = ylm_vtk_add_shape(scene_at(L, 1), ylmL_check(L, 2, YLM_SHAPE), &f.style, &e);
  return ylmL_result(L, 0, s, &e);
}

/* volume(scene, volume, table [256][4], distance, smooth, scale...) */
static int scene_volume(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  size_t rows;
  ylm_figure_volume place;
  const double *table = ylmL_doubles(L, 3, 4, &rows);
  if (rows != 256) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_figure_scale scale = ylmL_scale(L, 6);
  double distance = (double)luaL_checknumber(L, 4);
  ylm_status s = ylm_figure_places(ylmL_check(L, 2, YLM_VOLUME), &scale, &place);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  s = ylm_vtk_add_volume(scene_at(L, 1), &place, table, distance, lua_toboolean(L, 5), &e);
  ylm_figure_volume_clear(&place);
  return ylmL_result(L, 0, s, &e);
}

/* isosurfaces(scene, volume, values [n], colours [n][4]) */
static int scene_isosurfaces(lua_State *L) {
  ylm_error e;
  size_t n;
  const double *value = ylmL_doubles(L, 3, 1, &n), *colour = ylmL_doubles_of(L, 4, 4, n);
  ylm_status s =
      ylm_vtk_add_isosurfaces(scene_at(L, 1), ylmL_check(L, 2, YLM_VOLUME), n, value, colour, &e);
  return ylmL_result(L, 0, s, &e);
}

/* Corner and edges of the plane that a flat volume's voxels cover; the image's axes in u and v. */
static void plane(const ylm_figure_volume *v, double corner[3], double u[3], double w[3], int *nu,
                  int *nw) {
  int flat = v->size[2] == 1   ? 2
             : v->size[1] == 1 ? 1
                               : 0,
      a = flat == 0 ? 1 : 0, b = flat == 2 ? 1 : 2;
  memset(u, 0, 3 * sizeof *u);
  memset(w, 0, 3 * sizeof *w);
  memcpy(corner, v->origin, 3 * sizeof *corner);
  corner[a] -= v->spacing[a] / 2;
  corner[b] -= v->spacing[b] / 2;
  u[a] = v->spacing[a] * (double)v->size[a];
  w[b] = v->spacing[b] * (double)v->size[b];
  *nu = (int)v->size[a];
  *nw = (int)v->size[b];
}

/* slice(scene, flat volume, opacity, smooth, scale...) */
static int scene_slice(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_figure_volume *v = ylmL_check(L, 2, YLM_VOLUME);
  double corner[3], u[3], w[3];
  int nu, nw;
  ylm_figure_scale scale = ylmL_scale(L, 5);
  double opacity = (double)luaL_checknumber(L, 3);
  plane(v, corner, u, w, &nu, &nw);
  if ((size_t)nu * (size_t)nw != v->size[0] * v->size[1] * v->size[2])
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  uint8_t *rgba = ylm_alloc((size_t)nu * (size_t)nw, 4);
  ylm_status s = rgba ? ylm_figure_pixels(v, &scale, opacity, rgba) : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm_vtk_add_picture(scene_at(L, 1), corner, u, w, nu, nw, rgba, lua_toboolean(L, 4), &e);
  ylm_free(rgba);
  return ylmL_result(L, 0, s, &e);
}

/* camera(scene, from, at, up, fov) */
static int scene_camera(lua_State *L) {
  double from[3], at[3], up[3];
  ylmL_numbers(L, 2, 3, from);
  ylmL_numbers(L, 3, 3, at);
  ylmL_numbers(L, 4, 3, up);
  ylm_vtk_camera(scene_at(L, 1), from, at, up, (double)luaL_checknumber(L, 5));
  return 0;
}

/* render(scene, canvas, supersample, {r, g, b}): fills the canvas */
static int scene_render(lua_State *L) {
  ylm_error e;
  ylm_figure_canvas *c = ylmL_check(L, 2, YLM_CANVAS);
  double background[3];
  ylmL_numbers(L, 4, 3, background);
  ylm_status s = ylm_vtk_render(scene_at(L, 1), c->width, c->height, (int)luaL_checknumber(L, 3),
                                background, c->pixel, &e);
  return ylmL_result(L, 0, s, &e);
}

/* text(canvas | nil, text, x, y, size, bold, {r, g, b}) -> width, height
   x, y is the upper left corner */
static int text(lua_State *L) {
  ylm_error e;
  ylm_figure_canvas *c = lua_isnoneornil(L, 1) ? NULL : ylmL_check(L, 1, YLM_CANVAS);
  int w, h;
  double rgb[3];
  uint8_t *rgba;
  const char *words = luaL_checkstring(L, 2);
  double x = (double)luaL_checknumber(L, 3), y = (double)luaL_checknumber(L, 4);
  ylmL_numbers(L, 7, 3, rgb);
  ylm_status s = ylm_vtk_text(words, (double)luaL_checknumber(L, 5), lua_toboolean(L, 6), rgb, &w,
                              &h, &rgba, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  if (c && rgba) ylm_figure_canvas_blend(c, (int)x, (int)y, w, h, rgba);
  ylm_free(rgba);
  lua_pushnumber(L, w);
  lua_pushnumber(L, h);
  return 2;
}

/* save_png(path, canvas) */
static int save_png(lua_State *L) {
  ylm_error e;
  ylm_status s = ylm_vtk_save_png(luaL_checkstring(L, 1), ylmL_check(L, 2, YLM_CANVAS), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* scene_save(scene, path, width, height) -> true */
static int scene_save(lua_State *L) {
  ylm_error e;
  ylm_status s = ylm_vtk_save_gltf(scene_at(L, 1), (int)luaL_checknumber(L, 3),
                                   (int)luaL_checknumber(L, 4), luaL_checkstring(L, 2), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* describe(path) -> what VTK's reader finds */
static int describe(lua_State *L) {
  ylm_error e;
  char *words = NULL;
  ylm_status s = ylm_vtk_describe(luaL_checkstring(L, 1), &words, &e);
  if (s == YLM_OK) lua_pushstring(L, words);
  ylm_free(words);
  return ylmL_result(L, 1, s, &e);
}

/* where() -> "egl" | "x" | "xvfb" */
static int where(lua_State *L) {
  ylm_error e;
  const char *name = NULL;
  ylm_status s = ylm_vtk_where(&name, &e);
  lua_pushstring(L, name);
  return ylmL_result(L, 1, s, &e);
}

static int version(lua_State *L) {
  lua_pushstring(L, ylm_vtk_version());
  return 1;
}

static const luaL_Reg functions[] = {{"scene", scene_new},
                                     {"scene_shape", scene_shape},
                                     {"scene_volume", scene_volume},
                                     {"scene_isosurfaces", scene_isosurfaces},
                                     {"scene_slice", scene_slice},
                                     {"scene_camera", scene_camera},
                                     {"scene_render", scene_render},
                                     {"scene_save", scene_save},
                                     {"text", text},
                                     {"save_png", save_png},
                                     {"describe", describe},
                                     {"where", where},
                                     {"version", version},
                                     {"plot", ylmL_vtk_plot},
                                     {"save_pdf", ylmL_vtk_save_pdf},
                                     {"show", ylmL_vtk_show},
                                     {"live", ylmL_vtk_live},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", scene_gc}, {NULL, NULL}};

int luaopen_ylm_c_vtk(lua_State *L) {
  ylmL_check_abi(L);
  ylmL_type(L, YLM_VTK_SCENE, methods);
  lua_pop(L, 1);
  ylmL_vtk_open_live(L);
  lua_newtable(L);
  luaL_setfuncs(L, functions, 0);
  return 1;
}
