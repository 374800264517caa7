/* figure_canvas.c - canvases: pictures as they are put together. */
#include "../binding_figure.h"
#include "ylm_image.h"

#include <math.h>
#include <string.h>

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

/* copy(canvas, {x, y, width, height}, from, {x, y, width, height}, sharp) */
static int canvas_copy(lua_State *L) {
  double to[4], part[4];
  ylmL_numbers(L, 2, 4, to);
  ylmL_numbers(L, 4, 4, part);
  ylm_figure_canvas_copy(canvas_at(L, 1), (int)to[0], (int)to[1], (int)to[2], (int)to[3],
                         canvas_at(L, 3), part[0], part[1], part[2], part[3], lua_toboolean(L, 5));
  return 0;
}

/* set(canvas, array [h][w][3]): display values 0 .. 1 */
static int canvas_set(lua_State *L) {
  ylm_figure_canvas *c = canvas_at(L, 1);
  ylmL_array *a = ylmL_array_check(L, 2);
  if (a->count != (size_t)c->width * (size_t)c->height * 3)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  for (size_t i = 0; i < a->count; i++) {
    double x = ylmL_array_get(a, i);
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

static const luaL_Reg functions[] = {{"canvas", canvas_new},
                                     {"canvas_size", canvas_size},
                                     {"canvas_rectangle", canvas_rectangle},
                                     {"canvas_line", canvas_line},
                                     {"canvas_copy", canvas_copy},
                                     {"canvas_set", canvas_set},
                                     {"canvas_image", canvas_image},
                                     {"canvas_pixels", canvas_pixels},
                                     {"__gc", canvas_gc},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", canvas_gc}, {NULL, NULL}};

void ylmL_open_figure_canvas(lua_State *L) {
  ylmL_type(L, YLM_CANVAS, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
