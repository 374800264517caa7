/* sh.c - spherical harmonics on a device. Arguments come sorted from lua/ylm/sh/init.lua. */
#include "vulkan.h"
#include "ylm_sh.h"

static void *data_of(ylmL_array *a) { return a ? a->data : NULL; }

typedef struct eval_form {
  ylmL_array *y, *dy, *ddy;
  bool solid;
  int progress; /* on the stack */
} eval_form;

static const ylmL_entry eval_entries[] = {YLML(eval_form, y, "y", ARRAY),
                                          YLML(eval_form, dy, "dy", ARRAY, .optional = true),
                                          YLML(eval_form, ddy, "ddy", ARRAY, .optional = true),
                                          YLML(eval_form, solid, "solid", BOOL),
                                          YLML(eval_form, progress, "progress", VALUE),
                                          {.name = NULL}};

/* gpu_sh_eval(gpu, lmax, points [n][3], {y, dy | nil, ddy | nil, solid, progress}) -> true,
   times */
static int sh_eval(lua_State *L) {
  eval_form f = {.solid = false};
  ylm_gpu *g = ylmL_gpu_check(L, 1);
  ylmL_read(L, 4, eval_entries, &f);
  ylmL_array *p = ylmL_array_check(L, 3), *y = f.y, *dy = f.dy, *ddy = f.ddy;
  ylmL_progress progress;
  ylm_gpu_times times = {0};
  ylm_error e = {YLM_OK, ""};
  int lmax = (int)luaL_checknumber(L, 2), order = ddy ? 2 : dy ? 1 : 0;
  if (lmax < 0 || lmax > YLM_LMAX) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t n = p->count / 3, count = ylm_sh_count(lmax);
  if (p->count != 3 * n || y->count != n * count || (dy && dy->count != 3 * n * count) ||
      (ddy && (!dy || ddy->count != 6 * n * count)))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (y->dtype != p->dtype || (dy && dy->dtype != p->dtype) || (ddy && ddy->dtype != p->dtype))
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  const ylm_progress *report = ylmL_progress_begin(L, f.progress, &progress);
  ylm_status s = ylm_gpu_sh_eval(g, lmax, order, f.solid, p->dtype, n, p->data, y->data,
                                 data_of(dy), data_of(ddy), &times, report, &e);
  lua_pushboolean(L, s == YLM_OK);
  ylmL_gpu_push_times(L, &times);
  return ylmL_result_progress(L, 2, s, &e, &progress);
}

static const luaL_Reg functions[] = {{"gpu_sh_eval", sh_eval}, {NULL, NULL}};

void ylmL_open_vulkan_sh(lua_State *L) { luaL_setfuncs(L, functions, 0); }
