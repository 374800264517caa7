/*
** sh.c - binds evaluation of spherical harmonics. Arguments come sorted from lua/ylm/sh/init.lua.
*/
#include "../binding.h"

#include "ylm_sh.h"

#include <string.h>

static void *data_of(ylmL_array *a) { return a ? a->data : NULL; }

/* The number of the method called `name`; -1 if there is none. */
static int method_of(const char *name) {
  for (int m = 0; m < YLM_SH_METHOD_COUNT; m++)
    if (strcmp(name, ylm_sh_method_name((ylm_sh_method)m)) == 0) return m;
  return -1;
}

int ylmL_isa(lua_State *L, int i) {
  if (lua_isnoneornil(L, i)) return -1;
  const char *name = luaL_checkstring(L, i);
  for (int k = 0; k < YLM_ISA_COUNT; k++)
    if (strcmp(name, ylm_isa_name((ylm_isa)k)) == 0) return k;
  return luaL_argerror(L, i, "no such kernel set");
}

/* sh_eval(lmax, points [n][3], {y, dy | nil, ddy | nil, solid, method, threads, isa | nil,
   progress}) fills y [n][count], dy [n][count][3], ddy [n][count][6], all of the points' type */
static int sh_eval(lua_State *L) {
  static const char *const names[] = {"y",       "dy",  "ddy",      "solid", "method",
                                      "threads", "isa", "progress", NULL};
  enum { Y = 4, DY, DDY, SOLID, METHOD, THREADS, ISA, PROGRESS };
  ylmL_named(L, 3, names);
  ylmL_array *p = ylmL_array_check(L, 2), *y = ylmL_array_check(L, Y);
  ylmL_array *dy = ylmL_array_opt(L, DY), *ddy = ylmL_array_opt(L, DDY);
  ylmL_progress progress;
  ylm_error e = {YLM_OK, ""};
  int lmax = (int)luaL_checknumber(L, 1), method = method_of(luaL_checkstring(L, METHOD));
  if (lmax < 0 || lmax > YLM_LMAX) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t n = p->count / 3, count = ylm_sh_count(lmax);
  if (method < 0) return ylmL_result(L, 0, YLM_EINVAL, NULL);
  if (p->count != 3 * n || y->count != n * count || (dy && dy->count != 3 * n * count) ||
      (ddy && (!dy || ddy->count != 6 * n * count)))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (y->dtype != p->dtype || (dy && dy->dtype != p->dtype) || (ddy && ddy->dtype != p->dtype))
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  ylm_sh_how how = {.derivatives = ddy  ? 2
                                   : dy ? 1
                                        : 0,
                    .solid = lua_toboolean(L, SOLID),
                    .method = (ylm_sh_method)method,
                    .isa = ylmL_isa(L, ISA),
                    .threads = (int)luaL_optnumber(L, THREADS, 0)};
  how.progress = ylmL_progress_begin(L, PROGRESS, &progress);
  ylm_status s =
      ylm_sh_eval_how(&how, lmax, p->dtype, n, p->data, y->data, data_of(dy), data_of(ddy), &e);
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
