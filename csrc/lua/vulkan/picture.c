/* picture.c - pictures in a device's memory; lua/ylm/vulkan/image.lua makes them. */
#include "vulkan.h"

#define PICTURE "ylm.gpu_picture"

/* The numbers of the array at `i`, which has `count` of that type; NULL and *s otherwise, and where
   it is nil and may be. */
static const void *array_of(lua_State *L, int i, ylm_dtype t, size_t count, bool optional,
                            ylm_status *s) {
  const ylmL_array *a = optional ? ylmL_array_opt(L, i) : ylmL_array_check(L, i);
  if (!a) return NULL;
  if (a->dtype != t)
    *s = YLM_ETYPE;
  else if (a->count != count)
    *s = YLM_ESHAPE;
  return a->data;
}

/* gpu_picture_create(gpu, width, height, points, { first, shown, weight, depth, camera, point |
   nil, part | nil }) -> picture; the arrays are those of ylm_gpu_pixels */
static int create(lua_State *L) {
  static const char *const names[] = {"first",  "shown", "weight", "depth",
                                      "camera", "point", "part"};
  ylm_error e = {YLM_OK, ""};
  ylm_status s = YLM_OK;
  ylm_gpu *g = ylmL_gpu_check(L, 1);
  ylm_gpu_pixels p = {.width = (size_t)luaL_checknumber(L, 2),
                      .height = (size_t)luaL_checknumber(L, 3),
                      .points = (size_t)luaL_checknumber(L, 4)};
  luaL_checktype(L, 5, LUA_TTABLE);
  lua_settop(L, 5);
  for (int i = 0; i < 7; i++) lua_getfield(L, 5, names[i]);
  p.entries = ylmL_array_check(L, 8)->count;
  p.first = array_of(L, 6, YLM_DOUBLE, p.width * p.height + 1, false, &s);
  p.shown = array_of(L, 7, YLM_FLOAT, 4 * p.width * p.height, false, &s);
  p.weight = array_of(L, 8, YLM_FLOAT, p.entries, false, &s);
  p.depth = array_of(L, 9, YLM_FLOAT, p.entries, false, &s);
  p.camera = array_of(L, 10, YLM_DOUBLE, 10, false, &s);
  p.point = array_of(L, 11, YLM_DOUBLE, 3 * p.entries, true, &s);
  p.part = array_of(L, 12, YLM_FLOAT, 3 * p.entries, true, &s);
  if (!p.point != !p.part) s = YLM_ESHAPE;
  ylm_gpu_picture **k = lua_newuserdata(L, sizeof *k);
  *k = NULL;
  luaL_getmetatable(L, PICTURE);
  lua_setmetatable(L, -2);
  if (s == YLM_OK) s = ylm_gpu_picture_create(g, &p, k, &e);
  return ylmL_result(L, 1, s, &e);
}

/* gpu_picture_make(picture, radiance [n][3], {r, g, b} of the background, discs [n][12] | nil,
   image [h][w][3], progress) -> image, times. Radiance and image may be on the device. */
static int make(lua_State *L) {
  lua_settop(L, 6);
  ylm_gpu_picture **k = ylmL_check(L, 1, PICTURE);
  if (!*k) luaL_argerror(L, 1, "the picture has been closed");
  ylmL_any_array radiance = ylmL_any(L, 2), image = ylmL_any(L, 5);
  const ylmL_array *discs = ylmL_array_opt(L, 4);
  float background[3];
  ylm_error e = {YLM_OK, ""};
  ylm_gpu_times times = {0};
  ylmL_progress p;
  luaL_checktype(L, 3, LUA_TTABLE);
  for (int c = 0; c < 3; c++) {
    lua_rawgeti(L, 3, c + 1);
    background[c] = (float)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  if (radiance.dtype != YLM_FLOAT || image.dtype != YLM_FLOAT ||
      (discs && discs->dtype != YLM_DOUBLE))
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  size_t points, pixels, n = discs ? discs->count / YLM_GPU_DISC : 0;
  ylm_gpu_picture_size(*k, &points, &pixels);
  if (radiance.count != 3 * points || image.count != 3 * pixels ||
      (discs && discs->count != n * YLM_GPU_DISC))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  const ylm_progress *progress = ylmL_progress_begin(L, 6, &p);
  ylm_status s =
      ylm_gpu_picture_make(*k, ylmL_gpu_input(&radiance), background, n, n ? discs->data : NULL,
                           (ylm_gpu_output){image.host, image.there}, &times, progress, &e);
  lua_pushvalue(L, 5);
  ylmL_gpu_push_times(L, &times);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* gpu_picture_close(picture): not while it is made */
static int gc(lua_State *L) {
  ylm_gpu_picture **k = ylmL_check(L, 1, PICTURE);
  ylm_gpu_picture_free(*k);
  *k = NULL;
  return 0;
}

static const luaL_Reg functions[] = {{"gpu_picture_create", create},
                                     {"gpu_picture_make", make},
                                     {"gpu_picture_close", gc},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", gc}, {NULL, NULL}};

void ylmL_open_vulkan_picture(lua_State *L) {
  luaL_setfuncs(L, functions, 0);
  ylmL_gpu_type(L, PICTURE, methods);
}
