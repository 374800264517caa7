/* shade_picture.c - pictures of a view from numbers at its points, and their differences. */
#include "shade.h"
#include "ylm_shade_over.h"

/* shade_difference(a, b, out): out = |a - b|; float arrays of one size */
static int shade_difference(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1), *b = ylmL_array_check(L, 2), *c = ylmL_array_check(L, 3);
  if (a->dtype != YLM_FLOAT || b->dtype != YLM_FLOAT || c->dtype != YLM_FLOAT)
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (a->count != b->count || a->count != c->count) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  const float *x = a->data, *y = b->data;
  for (size_t i = 0; i < a->count; i++)
    ((float *)c->data)[i] = x[i] > y[i] ? x[i] - y[i] : y[i] - x[i];
  lua_pushvalue(L, 3);
  return 1;
}

/* shade_resolve(view, values [n][c] or [n], fill or nil, covered, threads, out [h][w][c] or nil)
   -> out; fill is a table of c numbers */
static int shade_resolve(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylmL_array *values = ylmL_array_check(L, 2);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  double fill[4] = {0};
  float fills[4];
  ylm_status s = YLM_OK;
  size_t channels = values->axes > 1 ? values->shape[values->axes - 1] : 1;
  bool covered = lua_toboolean(L, 4);
  int threads = (int)luaL_checknumber(L, 5);
  lua_settop(L, 6);
  if (channels < 1 || channels > 4 || values->dtype != YLM_FLOAT ||
      values->count != ylmL_shade_points(v) * channels)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (!lua_isnil(L, 3)) ylmL_scene_numbers(L, 3, (int)channels, fill);
  for (int c = 0; c < 4; c++) fills[c] = (float)fill[c];
  ylmL_array *out =
      ylmL_shade_result(L, 6, 3, (size_t[]){(size_t)o->height, (size_t)o->width, channels}, &s);
  if (s == YLM_OK)
    s = ylm_shade_resolve(v, (int)channels, values->data, fills, covered, threads, out->data);
  return ylmL_result(L, 1, s, NULL);
}

/* shade_compose(view, colours [n][3], background {r, g, b}, threads, out [h][w][3] or nil) ->
   out */
static int shade_compose(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylmL_array *colours = ylmL_array_check(L, 2);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  double b[3];
  ylm_status s = YLM_OK;
  ylmL_scene_numbers(L, 3, 3, b);
  int threads = (int)luaL_checknumber(L, 4);
  lua_settop(L, 5);
  if (colours->dtype != YLM_FLOAT || colours->count != 3 * ylmL_shade_points(v))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out =
      ylmL_shade_result(L, 5, 3, (size_t[]){(size_t)o->height, (size_t)o->width, 3}, &s);
  if (s == YLM_OK)
    s = ylm_shade_compose(v, colours->data, (float[]){(float)b[0], (float)b[1], (float)b[2]},
                          threads, out->data);
  return ylmL_result(L, 1, s, NULL);
}

/* shade_layer(view, name, threads, out or nil) -> out [h][w][c] */
static int shade_layer(lua_State *L) {
  static const char *const names[] = {"lamps",    "depth",  "coverage", "emitter", "normal",
                                      "position", "albedo", "object",   NULL};
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_layer layer = (ylm_shade_layer)luaL_checkoption(L, 2, NULL, names);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  int threads = (int)luaL_checknumber(L, 3);
  ylm_status s = YLM_OK;
  lua_settop(L, 4);
  size_t shape[3] = {(size_t)o->height, (size_t)o->width, (size_t)ylm_shade_layer_channels(layer)};
  ylmL_array *out = ylmL_shade_result(L, 4, 3, shape, &s);
  if (s == YLM_OK) s = ylm_shade_layer_write(v, layer, threads, out->data);
  return ylmL_result(L, 1, s, NULL);
}

/* shade_ambient(view, by rays, radius, threads, progress) -> openness [points] */
static int shade_ambient(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_ambience how = lua_toboolean(L, 2) ? YLM_SHADE_AMBIENT_RAYS : YLM_SHADE_SCREEN;
  double radius = luaL_checknumber(L, 3);
  int threads = (int)luaL_checknumber(L, 4);
  lua_settop(L, 5);
  ylmL_progress bar;
  const ylm_progress *progress = ylmL_progress_begin(L, 5, &bar);
  ylm_status s = YLM_OK;
  size_t n = ylmL_shade_points(v);
  ylmL_array *out = ylmL_shade_result(L, 6, 1, (size_t[]){n}, &s);
  if (s == YLM_OK) s = ylm_shade_ambient(v, how, radius, threads, progress, out->data);
  return ylmL_result_progress(L, 1, s, NULL, &bar);
}

/* shade_darken(radiance [n][3], openness [n]) -> their product */
static int shade_darken(lua_State *L) {
  ylmL_array *radiance = ylmL_array_check(L, 1), *open = ylmL_array_check(L, 2);
  ylm_status s = YLM_OK;
  lua_settop(L, 2);
  if (radiance->dtype != YLM_FLOAT || open->dtype != YLM_FLOAT ||
      radiance->count != 3 * open->count)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_shade_result(L, 3, 2, (size_t[]){open->count, 3}, &s);
  const float *r = radiance->data, *a = open->data;
  for (size_t i = 0; s == YLM_OK && i < 3 * open->count; i++)
    ((float *)out->data)[i] = r[i] * a[i / 3];
  return ylmL_result(L, 1, s, NULL);
}

/* The body at index i: { view, at = {3}, rotation = {9}, scale =, radiance = [n][3] or nil }; stays in its table. */
static ylm_shade_body body_at(lua_State *L, int i) {
  ylm_shade_body b = {.view = NULL};
  luaL_checktype(L, i, LUA_TTABLE);
  luaL_checkstack(L, 6, "body");
  lua_rawgeti(L, i, 1);
  b.view = ylmL_shade_view(L, lua_gettop(L));
  lua_getfield(L, i, "at");
  ylmL_scene_numbers(L, lua_gettop(L), 3, b.at);
  lua_getfield(L, i, "rotation");
  ylmL_scene_numbers(L, lua_gettop(L), 9, b.rotation);
  lua_getfield(L, i, "scale");
  b.scale = luaL_checknumber(L, -1);
  lua_getfield(L, i, "radiance");
  const ylmL_array *a = ylmL_array_opt(L, lua_gettop(L));
  if (a && a->dtype == YLM_FLOAT && a->count == 3 * ylmL_shade_points(b.view)) b.radiance = a->data;
  lua_pop(L, 5);
  return b;
}

/* shade_body_field(body, object with a light field, threads, progress) -> radiance [n][3], pairs */
static int shade_body_field(lua_State *L) {
  ylm_shade_body b = body_at(L, 1);
  const ylm_field *field = ylmL_field_check(L, 2);
  int threads = (int)luaL_checknumber(L, 3);
  ylm_error e = {0};
  ylmL_progress p;
  uint64_t pairs = 0;
  lua_settop(L, 4);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylmL_shade_points(b.view), 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  const ylm_progress *progress = ylmL_progress_begin(L, 4, &p);
  ylm_status s = ylm_shade_body_field(&b, field, threads, progress, out->data, &pairs, &e);
  if (s == YLM_OK) ylmL_push_count(L, pairs);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* shade_draw_bodies(view, threads, image [h][w][3], list of bodies with radiance) -> rays */
static int shade_draw_bodies(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  int threads = (int)luaL_checknumber(L, 2);
  ylmL_array *image = ylmL_array_check(L, 3);
  luaL_checktype(L, 4, LUA_TTABLE);
  lua_settop(L, 4);
  if (image->dtype != YLM_FLOAT || image->count != 3 * (size_t)o->width * (size_t)o->height)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = lua_rawlen(L, 4);
  ylm_shade_body *body = lua_newuserdata(L, (n + 1) * sizeof *body);
  for (size_t k = 0; k < n; k++) {
    lua_rawgeti(L, 4, (int)k + 1);
    body[k] = body_at(L, lua_gettop(L));
    lua_pop(L, 1); /* the list keeps it */
    if (!body[k].radiance) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  }
  ylm_error e = {0};
  uint64_t rays = 0;
  ylm_status s = ylm_shade_draw_bodies(v, n, body, threads, image->data, &rays, &e);
  ylmL_push_count(L, rays);
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {{"shade_difference", shade_difference},
                                     {"shade_body_field", shade_body_field},
                                     {"shade_draw_bodies", shade_draw_bodies},
                                     {"shade_ambient", shade_ambient},
                                     {"shade_darken", shade_darken},
                                     {"shade_resolve", shade_resolve},
                                     {"shade_compose", shade_compose},
                                     {"shade_layer", shade_layer},
                                     {NULL, NULL}};

void ylmL_open_shade_picture(lua_State *L) { luaL_setfuncs(L, functions, 0); }
