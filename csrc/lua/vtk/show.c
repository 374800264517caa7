/* show.c - the interactive window. */
#include "../binding_figure.h"
#include "vtk.h"
#include "ylm_vtk.h"

#include <string.h>

/* A picked point in Lua's words. */
typedef struct picking {
  lua_State *L;
  int index;
  char text[500];
} picking;

static const char *pick(void *user, const double p[3]) {
  picking *k = user;
  lua_State *L = k->L;
  lua_pushvalue(L, k->index);
  for (int a = 0; a < 3; a++) lua_pushnumber(L, p[a]);
  if (lua_pcall(L, 3, 1, 0) != 0 || !lua_tostring(L, -1))
    strcpy(k->text, "?");
  else {
    strncpy(k->text, lua_tostring(L, -1), sizeof k->text - 1);
    k->text[sizeof k->text - 1] = 0;
  }
  lua_pop(L, 1);
  return k->text;
}

/* The overlay as RGBA: what two canvases, drawn on black and on white, have in common is opaque. */
static uint8_t *overlay(const ylm_figure_canvas *black, const ylm_figure_canvas *white) {
  size_t n = (size_t)black->width * (size_t)black->height;
  uint8_t *rgba = ylm_alloc(n, 4);
  for (size_t i = 0; rgba && i < n; i++) {
    const uint8_t *b = black->pixel + 3 * i, *w = white->pixel + 3 * i;
    int alpha = 255 - (w[1] > b[1] ? w[1] - b[1] : 0);
    for (size_t a = 0; a < 3; a++) {
      int x = alpha ? b[a] * 255 / alpha : 0;
      rgba[4 * i + a] = (uint8_t)(x > 255 ? 255 : x);
    }
    rgba[4 * i + 3] = (uint8_t)alpha;
  }
  return rgba;
}

/* show(scene, {r, g, b}, overlay on black, overlay on white, title, pick function | nil) */
int ylmL_vtk_show(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  ylm_vtk_scene *scene = *(ylm_vtk_scene **)ylmL_check(L, 1, YLM_VTK_SCENE);
  double background[3];
  ylmL_numbers(L, 2, 3, background);
  ylm_figure_canvas *black = ylmL_check(L, 3, YLM_CANVAS), *white = ylmL_check(L, 4, YLM_CANVAS);
  const char *title = luaL_checkstring(L, 5);
  picking k = {L, 6, ""};
  bool picks = lua_isfunction(L, 6);
  if (black->width != white->width || black->height != white->height)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  uint8_t *rgba = overlay(black, white);
  if (!rgba) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_vtk_show(scene, black->width, black->height, background, rgba, title,
                              picks ? pick : NULL, &k, &e);
  ylm_free(rgba);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}
