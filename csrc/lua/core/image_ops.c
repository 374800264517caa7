/*
** image_ops.c - what is computed from images: metrics, resizing, drawing, colours, directions.
*/
#include "../binding.h"

#include <math.h>

#include "ylm_image.h"

static int integer(lua_State *L, int i) {
  double x = (double)luaL_checknumber(L, i);
  return x > 2e9 ? 2000000000 : x < -2e9 ? -2000000000 : (int)x;
}

/* The numbers of the table at `i` (missing ones are 0), for a colour of up to four channels. */
static void colour(lua_State *L, int i, float c[4]) {
  luaL_checktype(L, i, LUA_TTABLE);
  for (int k = 0; k < 4; k++) {
    lua_rawgeti(L, i, k + 1);
    c[k] = (float)lua_tonumber(L, -1);
    lua_pop(L, 1);
  }
}

/* The float array at `i` as a mask of the image's pixels; NULL where it is nil. Raises on a bad
   one, which lua/ylm/image/init.lua has excluded. */
static const float *mask(lua_State *L, int i, const ylm_image *image) {
  ylmL_array *a = ylmL_array_opt(L, i);
  if (!a) return NULL;
  if (a->dtype != YLM_FLOAT || a->count != (size_t)image->width * (size_t)image->height)
    luaL_argerror(L, i, "mask: a float array with the image's pixels expected");
  return a->data;
}

typedef struct compare_form {
  const char *layer;
  double peak, least, epsilon;
  int threads, mask, progress; /* mask, progress: on the stack */
} compare_form;

static const ylmL_entry compare_entries[] = {
    YLML(compare_form, layer, "layer", STRING, .optional = true),
    YLML(compare_form, mask, "mask", VALUE),
    YLML(compare_form, peak, "peak", DOUBLE, .optional = true),
    YLML(compare_form, least, "floor", DOUBLE, .optional = true),
    YLML(compare_form, epsilon, "epsilon", DOUBLE, .optional = true),
    YLML(compare_form, threads, "threads", INT),
    YLML(compare_form, progress, "progress", VALUE),
    {.name = NULL}};

/* image_compare(a, b, {layer or nil, mask or nil, peak, floor, epsilon, threads, progress}) -> table */
static int image_compare(lua_State *L) {
  compare_form f = {.layer = NULL};
  ylm_image *a = ylmL_image_check(L, 1), *b = ylmL_image_check(L, 2);
  ylmL_read(L, 3, compare_entries, &f);
  const float *where = mask(L, f.mask, a);
  ylm_error e = {0};
  ylm_metrics m;
  ylmL_progress progress;
  ylm_status s = ylm_image_compare(a, b, f.layer, where, f.peak, f.least, f.epsilon, f.threads,
                                   ylmL_progress_begin(L, f.progress, &progress), &m, &e);
  lua_createtable(L, 0, 12);
  ylmL_set_number(L, "mse", m.mse);
  ylmL_set_number(L, "rmse", m.rmse);
  ylmL_set_number(L, "psnr", m.psnr);
  ylmL_set_number(L, "peak", m.peak);
  ylmL_set_number(L, "mae", m.mae);
  ylmL_set_number(L, "mape", m.mape);
  ylmL_set_number(L, "floor", m.floor);
  ylmL_set_number(L, "relmse", m.relmse);
  ylmL_set_number(L, "epsilon", m.epsilon);
  ylmL_set_number(L, "ssim", m.ssim);
  ylmL_set_number(L, "max", m.max);
  ylmL_set_count(L, "pixels", m.pixels);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

typedef struct flip_form {
  ylm_flip o;
  const char *layer;
  int threads, mask, progress; /* mask, progress: on the stack */
} flip_form;

static const ylmL_entry flip_entries[] = {
    YLML(flip_form, layer, "layer", STRING, .optional = true),
    YLML(flip_form, mask, "mask", VALUE),
    YLML(flip_form, o.pixels_per_degree, "pixels_per_degree", DOUBLE),
    YLML(flip_form, o.hdr, "hdr", BOOL),
    YLML(flip_form, o.start, "start", DOUBLE, .optional = true),
    YLML(flip_form, o.stop, "stop", DOUBLE, .optional = true),
    YLML(flip_form, threads, "threads", INT),
    YLML(flip_form, progress, "progress", VALUE),
    {.name = NULL}};

/* image_flip(a, b, {layer or nil, mask or nil, pixels_per_degree, hdr, start or nil, stop or nil,
   threads, progress}) -> map, {mean, max, start, stop, exposures} */
static int image_flip(lua_State *L) {
  flip_form f = {.o = {.start = NAN, .stop = NAN}};
  ylm_image *a = ylmL_image_check(L, 1), *b = ylmL_image_check(L, 2);
  ylmL_read(L, 3, flip_entries, &f);
  const float *where = mask(L, f.mask, a);
  ylm_error e = {0};
  ylmL_progress p;
  const ylm_progress *progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_image **map = ylmL_image_new(L);
  ylm_status s = ylm_image_flip(a, b, f.layer, where, &f.o, f.threads, progress, map, &e);
  lua_createtable(L, 0, 5);
  ylmL_set_number(L, "mean", f.o.mean);
  ylmL_set_number(L, "max", f.o.max);
  ylmL_set_number(L, "start", f.o.start);
  ylmL_set_number(L, "stop", f.o.stop);
  ylmL_set_number(L, "exposures", f.o.exposures);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* image_agree(a, b, layer or nil, mask or nil) -> z2, largest z2 of a block, its left and top pixel
   from 1 */
static int image_agree(lua_State *L) {
  ylm_image *a = ylmL_image_check(L, 1), *b = ylmL_image_check(L, 2);
  lua_settop(L, 4);
  const float *where = mask(L, 4, a);
  ylm_error e = {0};
  ylm_agreement m;
  ylm_status s = ylm_image_agree(a, b, luaL_optstring(L, 3, NULL), where, &m, &e);
  lua_pushnumber(L, (lua_Number)m.z2);
  lua_pushnumber(L, (lua_Number)m.z2_block);
  ylmL_push_count(L, (uint64_t)m.block[0] + 1);
  ylmL_push_count(L, (uint64_t)m.block[1] + 1);
  return ylmL_result(L, 4, s, &e);
}

/* image_difference(a, b, layer or nil, kind, scale, floor) -> image */
static int image_difference(lua_State *L) {
  ylm_image *a = ylmL_image_check(L, 1), *b = ylmL_image_check(L, 2);
  ylm_error e = {0};
  const char *layer = luaL_optstring(L, 3, NULL);
  ylm_difference kind = (ylm_difference)luaL_checkoption(L, 4, NULL, ylmL_difference_choices);
  double scale = (double)luaL_checknumber(L, 5), floor = (double)luaL_checknumber(L, 6);
  ylm_image **out = ylmL_image_new(L);
  return ylmL_result(L, 1, ylm_image_difference(a, b, layer, kind, scale, floor, out, &e), &e);
}

/* image_crop(image, x, y, width, height) -> image; x and y from 0 */
static int image_crop(lua_State *L) {
  ylm_image *in = ylmL_image_check(L, 1);
  ylm_error e = {0};
  int x = integer(L, 2), y = integer(L, 3), w = integer(L, 4), h = integer(L, 5);
  ylm_image **out = ylmL_image_new(L);
  return ylmL_result(L, 1, ylm_image_crop(in, x, y, w, h, out, &e), &e);
}

/* image_resize(image, width, height, filter, threads, progress) -> image */
static int image_resize(lua_State *L) {
  ylm_image *in = ylmL_image_check(L, 1);
  ylm_error e = {0};
  int w = integer(L, 2), h = integer(L, 3), threads = integer(L, 5);
  ylm_filter filter = (ylm_filter)luaL_checkoption(L, 4, NULL, ylmL_filter_choices);
  lua_settop(L, 6);
  ylm_image **out = ylmL_image_new(L);
  ylmL_progress p;
  const ylm_progress *progress = ylmL_progress_begin(L, 6, &p);
  ylm_status s = ylm_image_resize(in, w, h, filter, threads, progress, out, &e);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* image_paste(target, to or nil, x, y, source, from or nil, mask or nil) -> true; x and y from 0 */
static int image_paste(lua_State *L) {
  ylm_image *target = ylmL_image_check(L, 1), *source = ylmL_image_check(L, 5);
  ylm_error e = {0};
  ylm_status s = ylm_image_paste(target, luaL_optstring(L, 2, NULL), integer(L, 3), integer(L, 4),
                                 source, luaL_optstring(L, 6, NULL), mask(L, 7, source), &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* image_fill(image, layer or nil, x, y, width, height, colour) -> true; x and y from 0 */
static int image_fill(lua_State *L) {
  ylm_image *image = ylmL_image_check(L, 1);
  ylm_error e = {0};
  float c[4];
  colour(L, 7, c);
  ylm_status s = ylm_image_fill(image, luaL_optstring(L, 2, NULL), integer(L, 3), integer(L, 4),
                                integer(L, 5), integer(L, 6), c, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* image_text(image, layer or nil, x, y, scale, text, colour) -> width, height of the text; x, y
 * from 0 */
static int image_text(lua_State *L) {
  ylm_image *image = ylmL_image_check(L, 1);
  ylm_error e = {0};
  float c[4];
  int w, h, scale = integer(L, 5);
  const char *text = luaL_checkstring(L, 6);
  colour(L, 7, c);
  ylm_status s = ylm_image_write_text(image, luaL_optstring(L, 2, NULL), integer(L, 3),
                                      integer(L, 4), scale, text, c, &e);
  ylm_image_measure_text(text, scale, &w, &h);
  lua_pushinteger(L, w);
  lua_pushinteger(L, h);
  return ylmL_result(L, 2, s, &e);
}

/* image_colours(image, layer or nil, map, lo, hi, logarithmic) -> image */
static int image_colours(lua_State *L) {
  ylm_image *in = ylmL_image_check(L, 1);
  ylm_error e = {0};
  ylm_colourmap map;
  const char *layer = luaL_optstring(L, 2, NULL);
  if (!ylm_colourmap_find(luaL_checkstring(L, 3), &map)) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  double lo = (double)luaL_checknumber(L, 4), hi = (double)luaL_checknumber(L, 5);
  bool logarithmic = lua_toboolean(L, 6);
  ylm_image **out = ylmL_image_new(L);
  return ylmL_result(L, 1, ylm_image_false_colour(in, layer, map, lo, hi, logarithmic, out, &e),
                     &e);
}

/* colourmap_at(name, t) -> r, g, b, sRGB-encoded */
static int colourmap_at(lua_State *L) {
  ylm_colourmap map;
  float c[3];
  if (!ylm_colourmap_find(luaL_checkstring(L, 1), &map)) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  ylm_colourmap_at(map, (double)luaL_checknumber(L, 2), c);
  for (int k = 0; k < 3; k++) lua_pushnumber(L, (lua_Number)c[k]);
  return 3;
}

/* tone_map(name, stops, array) -> a new array */
static int tone_map(lua_State *L) {
  ylm_tone tone;
  ylmL_array *a = ylmL_array_check(L, 3);
  if (!ylm_tone_find(luaL_checkstring(L, 1), &tone) || a->dtype != YLM_FLOAT)
    return ylmL_result(L, 0, YLM_EINVAL, NULL);
  ylmL_array *b = ylmL_array_new(L, YLM_FLOAT, a->axes, a->shape);
  if (!b) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_tone_map(tone, (double)luaL_checknumber(L, 2), a->count, a->data, b->data);
  return 1;
}

/* mapping_pixels(mapping, up, width, height) -> directions [h*w][3], solid angles [h*w], double */
static int mapping_pixels(lua_State *L) {
  ylm_mapping m = (ylm_mapping)luaL_checkoption(L, 1, NULL, ylmL_mapping_choices);
  ylm_up up = (ylm_up)luaL_checkoption(L, 2, NULL, ylmL_up_choices);
  int w = integer(L, 3), h = integer(L, 4);
  if (w < 1 || h < 1) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t shape[2] = {(size_t)w * (size_t)h, 3};
  ylmL_array *d = ylmL_array_new(L, YLM_DOUBLE, 2, shape),
             *a = d ? ylmL_array_new(L, YLM_DOUBLE, 1, shape) : NULL;
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 2, ylm_mapping_pixels(m, up, w, h, d->data, a->data), NULL);
}

/* mapping_positions(mapping, up, width, height, directions [n][3] double) -> [n][2] double from
   0 */
static int mapping_positions(lua_State *L) {
  ylm_mapping m = (ylm_mapping)luaL_checkoption(L, 1, NULL, ylmL_mapping_choices);
  ylm_up up = (ylm_up)luaL_checkoption(L, 2, NULL, ylmL_up_choices);
  int w = integer(L, 3), h = integer(L, 4);
  ylmL_array *d = ylmL_array_check(L, 5);
  if (d->dtype != YLM_DOUBLE || d->count % 3) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t shape[2] = {d->count / 3, 2};
  ylmL_array *p = ylmL_array_new(L, YLM_DOUBLE, 2, shape);
  if (!p) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  const double *x = d->data;
  double *y = p->data;
  for (size_t i = 0; i < shape[0]; i++)
    if (!ylm_mapping_position(m, up, w, h, x + 3 * i, y + 2 * i, y + 2 * i + 1)) {
      ylm_error e = {0};
      return ylmL_result(
          L, 0, ylm_fail(&e, YLM_EDOMAIN, "direction %zu is zero or not finite", i + 1), &e);
    }
  return 1;
}

/* image_expose(image, layer or nil, stops or nil) -> stops, black, white */
static int image_expose(lua_State *L) {
  ylm_error e = {0};
  ylm_exposure x = {0};
  double stops = (double)luaL_optnumber(L, 3, 0);
  ylm_status s = ylm_image_expose(ylmL_image_check(L, 1), luaL_optstring(L, 2, NULL),
                                  lua_isnoneornil(L, 3) ? NULL : &stops, &x, &e);
  lua_pushnumber(L, (lua_Number)x.stops);
  lua_pushnumber(L, (lua_Number)x.black);
  lua_pushnumber(L, (lua_Number)x.white);
  return ylmL_result(L, 3, s, &e);
}

static const luaL_Reg functions[] = {{"image_compare", image_compare},
                                     {"image_difference", image_difference},
                                     {"image_agree", image_agree},
                                     {"image_flip", image_flip},
                                     {"image_crop", image_crop},
                                     {"image_resize", image_resize},
                                     {"image_paste", image_paste},
                                     {"image_fill", image_fill},
                                     {"image_text", image_text},
                                     {"image_colours", image_colours},
                                     {"colourmap_at", colourmap_at},
                                     {"image_expose", image_expose},
                                     {"tone_map", tone_map},
                                     {"mapping_pixels", mapping_pixels},
                                     {"mapping_positions", mapping_positions},
                                     {NULL, NULL}};

void ylmL_open_image_ops(lua_State *L) { luaL_setfuncs(L, functions, 0); }
