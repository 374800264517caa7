/* grid.c - ylm.grid: the object and its light field, sampling. lua/ylm/grid/object.lua,
   grid/sample.lua. */
#include <string.h>

#include "grid.h"

static const ylm_field *field_of(void *object) {
  ylm_grid **g = object;
  return *g && !ylm_grid_updating(*g) && !ylm_grid_spent(*g) ? ylm_grid_field(*g) : NULL;
}

typedef struct sample_form {
  ylm_grid_query q;
  int derivatives;
  int value, gradient, progress, normals, walls; /* on the stack */
} sample_form;

static const ylmL_entry sample_entries[] = {
    YLML(sample_form, q.interpolation, "interpolation", CHOICE,
         .choices = ylmL_interpolation_choices),
    YLML(sample_form, derivatives, "derivatives", INT),
    YLML(sample_form, q.nan_outside, "outside", EITHER, .choices = ylmL_outside_choices),
    YLML(sample_form, q.dtype, "dtype", CHOICE, .choices = ylmL_dtype_choices),
    YLML(sample_form, q.threads, "threads", INT, .optional = true),
    YLML(sample_form, progress, "progress", VALUE),
    YLML(sample_form, value, "value", VALUE),
    YLML(sample_form, gradient, "gradient", VALUE),
    YLML(sample_form, normals, "normals", VALUE),
    YLML(sample_form, walls, "walls", VALUE),
    {.name = NULL}};

/*
** grid_sample(grid, points [n][3], {interpolation, derivatives, outside, dtype, threads, progress,
**             value | nil, gradient | nil: arrays to be written; normals [n][3] of float | nil, walls: bytes of a
**             ylm_grid_walls | nil})
**   -> value, gradient | nil, outside, unbaked, seconds; of a grid in bricks, too
*/
static int grid_sample(lua_State *L) {
  sample_form f = {.derivatives = 0};
  ylmL_read(L, 3, sample_entries, &f);
  ylm_grid_set *set = ylmL_grid_set_test(L, 1);
  if (set && ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_grid *grid = set ? NULL : ylmL_grid_check(L, 1);
  const ylm_grid_contents *v = set ? ylm_grid_set_look(set) : ylm_grid_look(grid);
  ylmL_array *points = ylmL_array_check(L, 2), *value, *gradient = NULL;
  ylmL_progress progress;
  ylm_grid_query q = f.q;
  q.point_dtype = points->dtype;
  ylm_grid_walls walls;
  ylmL_array *normals = ylmL_array_opt(L, f.normals);
  if (normals && normals->dtype == YLM_FLOAT && normals->count == points->count)
    q.normals = normals->data;
  q.walls = ylmL_grid_walls(L, f.walls, &walls);
  q.progress = ylmL_progress_begin(L, f.progress, &progress);
  size_t shape[4] = {points->count / 3, (size_t)v->form.channels, (size_t)v->count, 3};
  ylm_grid_report report = {0};
  ylm_error e = {0};
  ylm_status s = YLM_OK;
  value = ylmL_array_result(L, f.value, q.dtype, 3, shape, &s);
  if (f.derivatives > 0)
    gradient = ylmL_array_result(L, f.gradient, q.dtype, 4, shape, &s);
  else
    lua_pushnil(L);
  void *slope = gradient ? gradient->data : NULL;
  if (s == YLM_OK)
    s = set ? ylm_grid_set_sample(set, &q, shape[0], points->data, value->data, slope, &report, &e)
            : ylm_grid_sample(grid, &q, shape[0], points->data, value->data, slope, &report, &e);
  if (s == YLM_OK) {
    ylmL_push_count(L, report.outside);
    ylmL_push_count(L, report.unbaked);
    lua_pushnumber(L, report.seconds);
  }
  return ylmL_result_progress(L, 5, s, &e, &progress);
}

/* grid_flags(grid, points [n][3], dtype, threads, out | nil) -> [n] YLM_GRID_SAMPLE_* */
static int grid_flags(lua_State *L) {
  lua_settop(L, 5);
  const ylm_grid *g = ylmL_grid_check(L, 1);
  const ylmL_array *points = ylmL_array_check(L, 2);
  ylm_dtype type = (ylm_dtype)luaL_checkoption(L, 3, NULL, ylmL_dtype_choices);
  size_t n = points->count / 3;
  ylm_status s = YLM_OK;
  ylmL_array *flags = ylmL_array_result(L, 5, type, 1, &n, &s);
  if (s == YLM_OK)
    s = ylm_grid_flags(g, n, points->dtype, points->data, type, flags->data,
                       (int)luaL_checknumber(L, 4));
  return ylmL_result(L, 1, s, NULL);
}

/* grid_is_open(value) -> true for a grid that has not been closed, false for a closed one, else
   nil; whether it is being updated; whether an update has spent it */
static int grid_is_open(lua_State *L) {
  ylm_grid **g = ylmL_test(L, 1, YLM_GRID_TYPE);
  if (!g) return 0;
  lua_pushboolean(L, *g != NULL);
  lua_pushboolean(L, *g && ylm_grid_updating(*g));
  lua_pushboolean(L, *g && ylm_grid_spent(*g));
  return 3;
}

static int grid_close(lua_State *L) {
  ylm_grid **g = ylmL_check(L, 1, YLM_GRID_TYPE);
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_grid_free(*g);
  *g = NULL;
  ylmL_disown(L, 1);
  return 0;
}

/* grid_take(grid, other): the grid becomes what the other is, which is closed. */
static int grid_take(lua_State *L) {
  ylm_grid *g = ylmL_grid_check(L, 1), **from;
  ylmL_grid_check(L, 2);
  from = lua_touserdata(L, 2);
  if (*from == g) return luaL_argerror(L, 2, "another grid expected");
  if (ylmL_busy(L, 1) != YLM_OK) return ylmL_result(L, 0, YLM_EBUSY, NULL);
  ylm_grid_take(g, *from);
  *from = NULL;
  lua_pushboolean(L, 1);
  return 1;
}

static const luaL_Reg functions[] = {{"grid_sample", grid_sample},   {"grid_flags", grid_flags},
                                     {"grid_is_open", grid_is_open}, {"grid_close", grid_close},
                                     {"grid_take", grid_take},       {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", grid_close}, {NULL, NULL}};

void ylmL_open_grid(lua_State *L) {
  ylmL_type(L, YLM_GRID_TYPE, methods);
  ylmL_type_has_field(L, field_of);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
