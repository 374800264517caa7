/*
** sh.c - binds evaluation of spherical harmonics. Arguments come sorted from lua/ylm/sh/init.lua.
*/
#include "../binding.h"

#include "ylm_sh.h"

static void *data_of(ylmL_array *a) { return a ? a->data : NULL; }

typedef struct eval_form {
  ylmL_array *y, *dy, *ddy;
  ylm_sh_how how;
  int progress; /* on the stack */
} eval_form;

static const ylmL_entry eval_entries[] = {
    YLML(eval_form, y, "y", ARRAY),
    YLML(eval_form, dy, "dy", ARRAY, .optional = true),
    YLML(eval_form, ddy, "ddy", ARRAY, .optional = true),
    YLML(eval_form, how.solid, "solid", BOOL),
    YLML(eval_form, how.method, "method", CHOICE, .choices = ylmL_sh_method_choices),
    YLML(eval_form, how.threads, "threads", INT, .optional = true),
    YLML(eval_form, how.isa, "isa", CHOICE, .choices = ylmL_isa_choices, .optional = true),
    YLML(eval_form, progress, "progress", VALUE),
    {.name = NULL}};

/* sh_eval(lmax, points [n][3], {y, dy | nil, ddy | nil, solid, method, threads, isa | nil,
   progress}) fills y [n][count], dy [n][count][3], ddy [n][count][6], all of the points' type */
static int sh_eval(lua_State *L) {
  eval_form f = {.how = {.isa = -1}};
  ylmL_read(L, 3, eval_entries, &f);
  const ylmL_array *p = ylmL_array_check(L, 2), *y = f.y, *dy = f.dy, *ddy = f.ddy;
  ylmL_progress progress;
  ylm_error e = {YLM_OK, ""};
  int lmax = (int)luaL_checknumber(L, 1);
  if (lmax < 0 || lmax > YLM_LMAX) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t n = p->count / 3, count = ylm_sh_count(lmax);
  if (p->count != 3 * n || y->count != n * count || (dy && dy->count != 3 * n * count) ||
      (ddy && (!dy || ddy->count != 6 * n * count)))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (y->dtype != p->dtype || (dy && dy->dtype != p->dtype) || (ddy && ddy->dtype != p->dtype))
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  f.how.derivatives = ddy ? 2 : dy ? 1 : 0;
  f.how.progress = ylmL_progress_begin(L, f.progress, &progress);
  ylm_status s = ylm_sh_eval_how(&f.how, lmax, p->dtype, n, p->data, f.y->data, data_of(f.dy),
                                 data_of(f.ddy), &e);
  lua_pushboolean(L, s == YLM_OK);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* sh_reconstruct(lmax, c [rows][count], points [n][3], out [rows][n], threads, progress), all of
 * one type */
static int sh_reconstruct(lua_State *L) {
  ylmL_array *c = ylmL_array_check(L, 2), *p = ylmL_array_check(L, 3),
             *out = ylmL_array_check(L, 4);
  ylm_error e = {YLM_OK, ""};
  ylmL_progress progress;
  int lmax = (int)luaL_checknumber(L, 1);
  if (lmax < 0 || lmax > YLM_LMAX) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t count = ylm_sh_count(lmax), rows = c->count / count, n = p->count / 3;
  if (c->count != rows * count || p->count != 3 * n || out->count != rows * n)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (c->dtype != p->dtype || out->dtype != p->dtype) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  ylm_status s =
      ylm_sh_reconstruct(lmax, p->dtype, rows, c->data, n, p->data, out->data,
                         (int)luaL_optnumber(L, 5, 0), ylmL_progress_begin(L, 6, &progress), &e);
  lua_pushboolean(L, s == YLM_OK);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* sh_error(lmax, a, b), both [n][count] or [n][count][width]: the largest |a-b| of a degree at a
   point relative to the largest |b| there, over all degrees and points: how evaluation is judged */
static int sh_error(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 2), *b = ylmL_array_check(L, 3);
  int lmax = (int)luaL_checknumber(L, 1);
  if (lmax < 0 || lmax > YLM_LMAX) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t last = a->shape[a->axes - 1], count = ylm_sh_count(lmax), width = last == count ? 1 : last;
  if (a->count != b->count || a->count % (count * width))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  double worst = 0;
  for (size_t i = 0; i < a->count; i += count * width)
    for (int l = 0; l <= lmax; l++) {
      double largest = 0, difference = 0;
      for (size_t k = ylm_sh_index(l, -l) * width; k < (ylm_sh_index(l, l) + 1) * width; k++) {
        double x = ylmL_array_get(a, i + k), y = ylmL_array_get(b, i + k),
               d = x > y ? x - y : y - x;
        if (!(d <= difference)) difference = d; /* NaN sticks */
        if (y > largest || -y > largest) largest = y > 0 ? y : -y;
      }
      double relative = largest > 0 ? difference / largest : difference;
      if (!(relative <= worst)) worst = relative;
    }
  lua_pushnumber(L, (lua_Number)worst);
  return 1;
}

static const luaL_Reg functions[] = {
    {"sh_eval", sh_eval}, {"sh_reconstruct", sh_reconstruct}, {"sh_error", sh_error}, {NULL, NULL}};

void ylmL_open_sh(lua_State *L) { luaL_setfuncs(L, functions, 0); }
