/* chart.c - line plots, for lua/ylm/plot. */
#include "../binding_figure.h"
#include "vtk.h"
#include "ylm_vtk.h"

#include <string.h>

#define SERIES 64
#define TICKS 64

/* field(table, name) as a string, "" where it is missing; the table keeps it */
static const char *word(lua_State *L, int i, const char *name) {
  lua_getfield(L, i, name);
  const char *s = lua_tostring(L, -1);
  lua_pop(L, 1);
  return s ? s : "";
}

static void colour(lua_State *L, int i, const char *name, int n, double *out) {
  lua_getfield(L, i, name);
  ylmL_numbers(L, lua_gettop(L), n, out);
  lua_pop(L, 1);
}

/* The axis table `name` of the chart at 1. */
static void axis(lua_State *L, const char *name, ylm_vtk_axis *a, double *tick,
                 const char **label) {
  lua_getfield(L, 1, name);
  int i = lua_gettop(L);
  a->least = ylmL_vtk_number(L, i, "least", 0);
  a->largest = ylmL_vtk_number(L, i, "largest", 0);
  lua_getfield(L, i, "log");
  a->logarithmic = lua_toboolean(L, -1);
  lua_getfield(L, i, "ticks");
  lua_getfield(L, i, "labels");
  a->ticks = lua_rawlen(L, -1) < TICKS ? lua_rawlen(L, -1) : TICKS;
  for (size_t k = 0; k < a->ticks; k++) {
    lua_rawgeti(L, i + 2, (int)k + 1);
    lua_rawgeti(L, i + 3, (int)k + 1);
    tick[k] = (double)lua_tonumber(L, -2);
    label[k] = lua_tostring(L, -1);
    if (!label[k]) label[k] = "";
    lua_pop(L, 2);
  }
  a->tick = tick;
  a->label = label;
  lua_settop(L, i - 1);
}

/* One series: the table on top. */
static void series(lua_State *L, ylm_vtk_series *s) {
  int i = lua_gettop(L);
  size_t n;
  lua_getfield(L, i, "x");
  s->x = ylmL_doubles(L, i + 1, 1, &n);
  lua_getfield(L, i, "y");
  s->y = ylmL_doubles_of(L, i + 2, 1, n);
  lua_pop(L, 2);
  s->n = n;
  s->label = word(L, i, "label");
  colour(L, i, "colour", 4, s->colour);
  s->width = ylmL_vtk_number(L, i, "width", 0);
  s->marker = ylmL_vtk_choice(L, i, "marker", ylmL_marker_choices);
  s->marker_size = ylmL_vtk_number(L, i, "marker_size", 0);
  s->dash = ylmL_vtk_choice(L, i, "dash", ylmL_dash_choices);
}

/* plot(chart table, canvas): fills the canvas */
int ylmL_vtk_plot(lua_State *L) {
  ylm_error e;
  ylm_vtk_chart c;
  ylm_vtk_series all[SERIES];
  double ticks[2][TICKS];
  const char *labels[2][TICKS];
  luaL_checktype(L, 1, LUA_TTABLE);
  ylm_figure_canvas *canvas = ylmL_check(L, 2, YLM_CANVAS);
  lua_settop(L, 2);
  memset(&c, 0, sizeof c);
  c.width = canvas->width;
  c.height = canvas->height;
  c.supersample = (int)ylmL_vtk_number(L, 1, "supersample", 0);
  c.left = ylmL_vtk_number(L, 1, "left", 0);
  c.right = ylmL_vtk_number(L, 1, "right", 0);
  c.top = ylmL_vtk_number(L, 1, "top", 0);
  c.bottom = ylmL_vtk_number(L, 1, "bottom", 0);
  c.legend = ylmL_vtk_choice(L, 1, "legend", ylmL_legend_choices);
  c.font = ylmL_vtk_number(L, 1, "font", 0);
  colour(L, 1, "background", 3, c.background);
  colour(L, 1, "foreground", 3, c.foreground);
  axis(L, "x", &c.x, ticks[0], labels[0]);
  axis(L, "y", &c.y, ticks[1], labels[1]);
  lua_getfield(L, 1, "series");
  c.n = lua_rawlen(L, -1);
  if (c.n > SERIES) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  for (size_t k = 0; k < c.n; k++) {
    lua_rawgeti(L, 3, (int)k + 1);
    series(L, &all[k]);
    lua_pop(L, 1);
  }
  c.series = all;
  return ylmL_result(L, 0, ylm_vtk_plot(&c, canvas->pixel, &e), &e);
}
