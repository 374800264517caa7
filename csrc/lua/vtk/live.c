/* live.c - the window that answers: userdata "ylm.vtk.window". */
#include "../binding_figure.h"
#include "vtk.h"
#include "ylm_image.h"
#include "ylm_vtk.h"

#include <math.h>

#define WINDOW "ylm.vtk.window"

enum { ROOM = 64, TONES = 1024, FIRST = -12, LAST = 8 };

/* The window at argument 1, open. */
static ylm_vtk_live *window_at(lua_State *L) {
  ylm_vtk_live **w = ylmL_check(L, 1, WINDOW);
  if (!*w) luaL_error(L, "the window has been closed");
  return *w;
}

/* open(width, height, title, hidden) -> window */
static int window_open(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_vtk_live **w = lua_newuserdata(L, sizeof *w);
  *w = NULL;
  luaL_getmetatable(L, WINDOW);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_vtk_live_open((int)luaL_checknumber(L, 1), (int)luaL_checknumber(L, 2),
                                   luaL_checkstring(L, 3), lua_toboolean(L, 4), w, &e);
  return ylmL_result(L, 1, s, &e);
}

/* close(window): may be called again */
static int window_close(lua_State *L) {
  ylm_vtk_live **w = ylmL_check(L, 1, WINDOW);
  ylm_vtk_live_close(*w);
  *w = NULL;
  return 0;
}

static void push_event(lua_State *L, const ylm_vtk_event *event) {
  static const char *const kinds[] = {"move", "press",  "release", "wheel",
                                      "key",  "resize", "close"};
  static const char *const buttons[] = {"", "left", "middle", "right"};
  lua_newtable(L);
  lua_pushstring(L, kinds[event->kind]);
  lua_setfield(L, -2, "kind");
  ylmL_set_number(L, "x", event->x);
  ylmL_set_number(L, "y", event->y);
  lua_pushboolean(L, event->shift);
  lua_setfield(L, -2, "shift");
  lua_pushboolean(L, event->control);
  lua_setfield(L, -2, "control");
  if (event->age >= 0) ylmL_set_number(L, "age", event->age);
  if (event->kind == YLM_VTK_WHEEL) ylmL_set_number(L, "notches", event->button);
  if (event->kind == YLM_VTK_PRESS || event->kind == YLM_VTK_RELEASE) {
    lua_pushstring(L, buttons[event->button]);
    lua_setfield(L, -2, "button");
  }
  if (event->kind == YLM_VTK_KEY) {
    lua_pushstring(L, event->key);
    lua_setfield(L, -2, "key");
  }
}

/* poll(window, seconds) -> a list of { kind, x, y, shift, control, button, notches, key } */
static int window_poll(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_vtk_event event[ROOM];
  size_t n;
  ylm_status s =
      ylm_vtk_live_poll(window_at(L), (double)luaL_checknumber(L, 2), ROOM, event, &n, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  lua_createtable(L, (int)n, 0);
  for (size_t i = 0; i < n; i++) {
    push_event(L, &event[i]);
    lua_rawseti(L, -2, (int)i + 1);
  }
  return 1;
}

/* waiting(window) -> boolean */
static int window_waiting(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  bool some = false;
  ylm_status s = ylm_vtk_live_waiting(window_at(L), &some, &e);
  lua_pushboolean(L, some);
  return ylmL_result(L, 1, s, &e);
}

/* size(window) -> width, height */
static int window_size(lua_State *L) {
  int size[2];
  ylm_vtk_live_size(window_at(L), size);
  lua_pushnumber(L, size[0]);
  lua_pushnumber(L, size[1]);
  return 2;
}

/* resize(window, width, height): of hidden ones */
static int window_resize(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_status s = ylm_vtk_live_resize(window_at(L), (int)luaL_checknumber(L, 2),
                                     (int)luaL_checknumber(L, 3), &e);
  return ylmL_result(L, 0, s, &e);
}

/* picture(window, rgb [h][w][3], depth [h][w] or nil, x, y, width, height) */
static int window_picture(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylmL_array *rgb = ylmL_array_check(L, 2);
  ylmL_array *depth = lua_isnil(L, 3) ? NULL : ylmL_array_check(L, 3);
  int rectangle[4];
  for (int i = 0; i < 4; i++) rectangle[i] = (int)luaL_checknumber(L, 4 + i);
  if (rgb->dtype != YLM_FLOAT || rgb->axes != 3 || rgb->shape[2] != 3 ||
      (depth && (depth->dtype != YLM_FLOAT || depth->count * 3 != rgb->count)))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_status s = ylm_vtk_live_picture(window_at(L), (int)rgb->shape[1], (int)rgb->shape[0],
                                      rgb->data, depth ? depth->data : NULL, rectangle, &e);
  return ylmL_result(L, 0, s, &e);
}

/* tone(window, curve, stops of exposure) */
static int window_tone(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  float x[TONES], y[TONES];
  ylm_tone curve;
  ylm_vtk_live *w = window_at(L);
  if (!ylm_tone_find(luaL_checkstring(L, 2), &curve)) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  double stops = (double)luaL_checknumber(L, 3);
  for (int i = 0; i < TONES; i++)
    x[i] = (float)exp2(FIRST + (LAST - FIRST) * (double)i / (TONES - 1));
  ylm_tone_map(curve, 0, TONES, x, y);
  for (int i = 0; i < TONES; i++) y[i] = fminf(1, fmaxf(0, y[i]));
  ylm_status s = ylm_vtk_live_tone(w, TONES, y, FIRST - stops, LAST - stops, &e);
  return ylmL_result(L, 0, s, &e);
}

/* overlay(window, scene or nil, nearest, farthest) */
static int window_overlay(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_vtk_scene *scene =
      lua_isnil(L, 2) ? NULL : *(ylm_vtk_scene **)ylmL_check(L, 2, YLM_VTK_SCENE);
  ylm_status s = ylm_vtk_live_overlay(window_at(L), scene, (double)luaL_checknumber(L, 3),
                                      (double)luaL_checknumber(L, 4), &e);
  return ylmL_result(L, 0, s, &e);
}

/* panel(window, canvas or nil, x, y) */
static int window_panel(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_vtk_live *w = window_at(L);
  if (lua_isnil(L, 2)) return ylmL_result(L, 0, ylm_vtk_live_panel(w, 0, 0, 0, 0, NULL, &e), &e);
  ylm_figure_canvas *c = ylmL_check(L, 2, YLM_CANVAS);
  ylm_status s = ylm_vtk_live_panel(w, (int)luaL_checknumber(L, 3), (int)luaL_checknumber(L, 4),
                                    c->width, c->height, c->pixel, &e);
  return ylmL_result(L, 0, s, &e);
}

/* show(window) */
static int window_show(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  return ylmL_result(L, 0, ylm_vtk_live_show(window_at(L), &e), &e);
}

/* read(window, canvas): fills the canvas, which has the window's size */
static int window_read(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  int size[2];
  ylm_vtk_live *w = window_at(L);
  ylm_figure_canvas *c = ylmL_check(L, 2, YLM_CANVAS);
  ylm_vtk_live_size(w, size);
  if (c->width != size[0] || c->height != size[1]) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  return ylmL_result(L, 0, ylm_vtk_live_read(w, c->pixel, &e), &e);
}

static const luaL_Reg methods[] = {{"close", window_close},
                                   {"poll", window_poll},
                                   {"waiting", window_waiting},
                                   {"size", window_size},
                                   {"resize", window_resize},
                                   {"picture", window_picture},
                                   {"tone", window_tone},
                                   {"overlay", window_overlay},
                                   {"panel", window_panel},
                                   {"show", window_show},
                                   {"read", window_read},
                                   {"__gc", window_close},
                                   {NULL, NULL}};

void ylmL_vtk_open_live(lua_State *L) {
  ylmL_type(L, WINDOW, methods);
  lua_pop(L, 1);
}

int ylmL_vtk_live(lua_State *L) { return window_open(L); }
