/* shade_entries.c - what pictures of a view are made of, for those that make them on a
 * device. */
#include <string.h>

#include "shade.h"
#include "ylm_shade_over.h"

/* A new array, set as field `name` of the table on top, which keeps it; its numbers. */
static void *field(lua_State *L, const char *name, ylm_dtype t, int axes, const size_t *shape,
                   ylm_status *s) {
  ylmL_array *a = *s == YLM_OK ? ylmL_array_new(L, t, axes, shape) : NULL;
  if (!a) {
    *s = YLM_ENOMEM;
    return NULL;
  }
  lua_setfield(L, -2, name);
  return a->data;
}

/* shade_entries(view) -> { first [pixels+1], shown [pixels][4], weight [n], depth [n], camera [10],
   per vertex point [n][3], part [n][3] }: ylm_shade_entries */
static int shade_entries(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_shade_options *o = ylm_shade_view_options(v);
  size_t pixels = (size_t)o->width * (size_t)o->height, n = ylm_shade_view_entries(v, NULL);
  size_t shown[] = {pixels, 4}, three[] = {n, 3};
  ylm_status s = YLM_OK;
  ylm_shade_entries e = {0};
  lua_newtable(L);
  e.first = field(L, "first", YLM_DOUBLE, 1, (size_t[]){pixels + 1}, &s);
  e.shown = field(L, "shown", YLM_FLOAT, 2, shown, &s);
  e.weight = field(L, "weight", YLM_FLOAT, 1, &n, &s);
  e.depth = field(L, "depth", YLM_FLOAT, 1, &n, &s);
  if (o->per_vertex) {
    e.point = field(L, "point", YLM_DOUBLE, 2, three, &s);
    e.part = field(L, "part", YLM_FLOAT, 2, three, &s);
  }
  double *camera = field(L, "camera", YLM_DOUBLE, 1, (size_t[]){10}, &s);
  if (s == YLM_OK) {
    ylm_shade_view_entries(v, &e);
    ylm_shade_view_camera(v, camera);
  }
  return ylmL_result(L, 1, s, NULL);
}

/* shade_discs(view, lights) -> discs of the spheres in sight [..][YLM_SHADE_DISC]; nil where there
   are none */
static int shade_discs(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_scene_lamps lamps;
  lua_settop(L, 2);
  if (!ylmL_scene_lamps(L, 2, ylm_shade_view_origin(v), &lamps))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  size_t n = lamps.shape.spheres, seen = 0;
  ylmL_array *all = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, YLM_SHADE_DISC});
  if (!all) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_shade_view_discs(v, &lamps, all->data, &seen);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  if (!seen) return 0;
  if (!ylmL_array_part(L, lua_gettop(L), 0, 2, (size_t[]){seen, YLM_SHADE_DISC}))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return 1;
}

static const luaL_Reg functions[] = {
    {"shade_entries", shade_entries}, {"shade_discs", shade_discs}, {NULL, NULL}};

void ylmL_open_shade_entries(lua_State *L) { luaL_setfuncs(L, functions, 0); }
