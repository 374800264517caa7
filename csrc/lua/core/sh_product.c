/* sh_product.c - binds products and their matrices. Arguments come sorted from
 * lua/ylm/sh/product.lua. */
#include "../binding.h"

#include "ylm_sh.h"
#include "ylm_sh_exponential.h"

#define PRODUCT "ylm.sh_product_plan"

typedef struct handle {
  ylm_sh_product *plan;
  int lmax, factors;
} handle;

static int product_gc(lua_State *L) {
  handle *h = ylmL_check(L, 1, PRODUCT);
  ylm_sh_product_free(h->plan);
  h->plan = NULL;
  return 0;
}

/* sh_product_plan(lmax, factors, method, inner) -> plan, method that is used, integrals */
static int sh_product_plan(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  int lmax = (int)luaL_checknumber(L, 1), factors = (int)luaL_checknumber(L, 2);
  const char *const *methods = ylmL_sh_product_choices;
  ylm_sh_product_method method = (ylm_sh_product_method)luaL_checkoption(L, 3, "auto", methods),
                        inner = (ylm_sh_product_method)luaL_checkoption(L, 4, "auto", methods);
  handle *h = lua_newuserdata(L, sizeof *h);
  *h = (handle){NULL, lmax, factors};
  luaL_getmetatable(L, PRODUCT);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_sh_product_create(lmax, factors, method, inner, &h->plan, &e);
  if (s != YLM_OK) return ylmL_result(L, 0, s, &e);
  ylmL_charge(L, (size_t)lmax * (size_t)lmax * (size_t)lmax * (size_t)factors * 32);
  lua_pushstring(L, ylm_sh_product_method_name(ylm_sh_product_method_of(h->plan)));
  lua_pushnumber(L, (lua_Number)ylm_sh_product_integrals(h->plan));
  return 3;
}

/* The first n arrays of the list at 2, left on the stack, where a progress function must not close them. A factor of one
   row, of `count` numbers, has stride 0. Returns `s`, or why an array is none that goes with `out`. */
static ylm_status read_factors(lua_State *L, size_t n, size_t count, const ylmL_array *out,
                               const void **factor, size_t *stride, ylm_status s) {
  for (size_t i = 0; i < n; i++) {
    lua_rawgeti(L, 2, (int)i + 1);
    const ylmL_array *a = ylmL_array_check(L, -1);
    factor[i] = a->data;
    stride[i] = a->count == count && out->count / count != 1 ? 0 : count;
    if (a->count != count && a->count != out->count) s = YLM_ESHAPE;
    if (a->dtype != out->dtype) s = YLM_ETYPE;
    if (a->data == out->data) s = YLM_EINVAL;
  }
  return s;
}

/* sh_product(plan, {arrays}, out, threads, want stages, progress) -> true, or seconds of the three
   stages. A factor of one row is used for all rows of out. */
static int sh_product(lua_State *L) {
  handle *h = ylmL_check(L, 1, PRODUCT);
  luaL_checktype(L, 2, LUA_TTABLE);
  ylmL_array *out = ylmL_array_check(L, 3);
  const void *factor[YLM_SH_PRODUCT_FACTORS];
  size_t stride[YLM_SH_PRODUCT_FACTORS], count = ylm_sh_count(h->lmax), rows = out->count / count;
  double stage[3] = {0, 0, 0};
  lua_settop(L, 6);
  luaL_checkstack(L, YLM_SH_PRODUCT_FACTORS + 4, "factors");
  ylm_status s = out->count == rows * count && h->plan ? YLM_OK : YLM_ESHAPE;
  s = read_factors(L, (size_t)h->factors, count, out, factor, stride, s);
  bool timed = lua_toboolean(L, 5);
  ylmL_progress progress;
  const ylm_progress *report = ylmL_progress_begin(L, 6, &progress);
  if (s == YLM_OK)
    s = ylm_sh_product_apply(h->plan, out->dtype, rows, factor, stride, out->data,
                             (int)luaL_optnumber(L, 4, 0), report, timed ? stage : NULL);
  if (s != YLM_OK) return ylmL_result_progress(L, 0, s, NULL, &progress);
  if (!timed) {
    lua_pushboolean(L, 1);
    return 1;
  }
  for (int i = 0; i < 3; i++) lua_pushnumber(L, stage[i]);
  return 3;
}

/* sh_product_matrix(c double [count of clmax], clmax, lmax, out double [count][count]) -> true */
static int sh_product_matrix(lua_State *L) {
  ylmL_array *c = ylmL_array_check(L, 1), *out = ylmL_array_check(L, 4);
  int clmax = (int)luaL_checknumber(L, 2), lmax = (int)luaL_checknumber(L, 3);
  ylm_error e = {YLM_OK, ""};
  ylm_status s = YLM_ERANGE;
  if (clmax >= 0 && clmax <= YLM_LMAX && lmax >= 0 && lmax <= YLM_LMAX) {
    size_t n = ylm_sh_count(lmax);
    s = c->count == ylm_sh_count(clmax) && out->count == n * n && c->dtype == YLM_DOUBLE &&
                out->dtype == YLM_DOUBLE
            ? YLM_OK
            : YLM_ESHAPE;
  }
  if (s == YLM_OK) s = ylm_sh_product_matrix(clmax, c->data, lmax, out->data, &e);
  lua_pushboolean(L, 1);
  return ylmL_result(L, 1, s, &e);
}

/* sh_apply(matrix [n][n], in [rows][n], out, threads, progress) -> true */
static int sh_apply(lua_State *L) {
  ylmL_array *m = ylmL_array_check(L, 1), *in = ylmL_array_check(L, 2),
             *out = ylmL_array_check(L, 3);
  ylmL_progress progress;
  const ylm_progress *report = ylmL_progress_begin(L, 5, &progress);
  size_t n = m->shape[m->axes - 1];
  ylm_status s =
      n && m->count == n * n && in->count % n == 0 && in->count == out->count ? YLM_OK : YLM_ESHAPE;
  if (s == YLM_OK && (m->dtype != in->dtype || in->dtype != out->dtype)) s = YLM_ETYPE;
  if (s == YLM_OK && in->data == out->data) s = YLM_EINVAL;
  if (s == YLM_OK)
    s = ylm_sh_apply(n, in->dtype, m->data, in->count / n, in->data, out->data,
                     (int)luaL_optnumber(L, 4, 0), report);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, NULL, &progress);
}

/* sh_matrices_apply(matrices [..][a][b], in [period][rows][b], out, period, threads, progress)
   -> true */
static int sh_matrices_apply(lua_State *L) {
  ylmL_array *m = ylmL_array_check(L, 1), *in = ylmL_array_check(L, 2),
             *out = ylmL_array_check(L, 3);
  ylmL_progress progress;
  size_t period = (size_t)luaL_checknumber(L, 4);
  const ylm_progress *report = ylmL_progress_begin(L, 6, &progress);
  size_t b = m->shape[m->axes - 1], a = m->axes > 1 ? m->shape[m->axes - 2] : 1;
  size_t n = a && b ? m->count / (a * b) : 0, rows = n && period ? in->count / (period * b) : 0;
  bool fits = in->count == period * rows * b && out->count == n * rows * a;
  ylm_status s = n == 0 || fits ? YLM_OK : YLM_ESHAPE;
  if (s == YLM_OK && (m->dtype != in->dtype || in->dtype != out->dtype)) s = YLM_ETYPE;
  if (s == YLM_OK)
    s = ylm_sh_matrices_apply(n, a, b, in->dtype, m->data, period, rows, in->data, out->data,
                              (int)luaL_optnumber(L, 5, 0), report);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, NULL, &progress);
}

/* sh_symmetric(matrix [n][n]) -> whether it is, exactly */
static int sh_symmetric(lua_State *L) {
  const ylmL_array *m = ylmL_array_check(L, 1);
  size_t n = m->shape[0];
  bool same = m->axes == 2 && m->shape[1] == n;
  for (size_t i = 0; same && i < n; i++)
    for (size_t k = 0; same && k < i; k++)
      same = ylm_get(m->dtype, m->data, i * n + k) == ylm_get(m->dtype, m->data, k * n + i);
  lua_pushboolean(L, same);
  return 1;
}

#define NODES "ylm.sh_nodes"

typedef struct nodes {
  ylm_sh_nodes *of;
  int lmax;
} nodes;

static int nodes_gc(lua_State *L) {
  nodes *n = ylmL_check(L, 1, NODES);
  ylm_sh_nodes_free(n->of);
  n->of = NULL;
  return 0;
}

/* sh_nodes(lmax, degree) -> nodes */
static int sh_nodes(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  nodes *n = lua_newuserdata(L, sizeof *n);
  *n = (nodes){NULL, (int)luaL_checknumber(L, 1)};
  luaL_getmetatable(L, NODES);
  lua_setmetatable(L, -2);
  int degree = (int)luaL_checknumber(L, 2);
  ylm_status s = ylm_sh_nodes_create(n->lmax, degree, &n->of, &e);
  if (s == YLM_OK) ylmL_charge(L, (size_t)n->lmax * (size_t)n->lmax * (size_t)degree * 16);
  return ylmL_result(L, 1, s, &e);
}

/* sh_nodes_product(nodes, {arrays}, out, threads, progress) -> true. A factor of one row is used for all rows of out. */
static int sh_nodes_product(lua_State *L) {
  nodes *n = ylmL_check(L, 1, NODES);
  luaL_checktype(L, 2, LUA_TTABLE);
  ylmL_array *out = ylmL_array_check(L, 3);
  size_t factors = lua_rawlen(L, 2), count = ylm_sh_count(n->lmax), rows = out->count / count;
  lua_settop(L, 5);
  luaL_checkstack(L, (int)(factors < 10000 ? factors : 10000) + 8, "factors");
  const void **factor = lua_newuserdata(L, (factors + 1) * sizeof *factor);
  size_t *stride = lua_newuserdata(L, (factors + 1) * sizeof *stride);
  ylm_status s = out->count == rows * count && n->of && factors ? YLM_OK : YLM_ESHAPE;
  s = read_factors(L, factors, count, out, factor, stride, s);
  ylmL_progress progress;
  const ylm_progress *report = ylmL_progress_begin(L, 5, &progress);
  if (s == YLM_OK)
    s = ylm_sh_nodes_product(n->of, out->dtype, factors, rows, factor, stride, out->data,
                             (int)luaL_optnumber(L, 4, 0), report);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, NULL, &progress);
}

/* The rows of an array of coefficients of lmax; 0 where out is of another shape. */
static size_t rows_of(const ylmL_array *in, const ylmL_array *out, int lmax, ylm_status *s) {
  size_t count = lmax >= 0 && lmax <= YLM_LMAX ? ylm_sh_count(lmax) : 0;
  *s = !count || in->count % count || in->count != out->count ? YLM_ESHAPE
       : in->dtype != out->dtype                              ? YLM_ETYPE
       : in->data == out->data && in->count                   ? YLM_EINVAL
                                                              : YLM_OK;
  return *s == YLM_OK ? in->count / count : 0;
}

/* sh_log(c, lmax, epsilon, out, threads, progress), sh_exp(c, lmax, terms, out, threads, progress) -> true */
static int sh_function(lua_State *L, bool log) {
  ylmL_array *in = ylmL_array_check(L, 1), *out = ylmL_array_check(L, 4);
  int lmax = (int)luaL_checknumber(L, 2), threads = (int)luaL_optnumber(L, 5, 0);
  double x = (double)luaL_checknumber(L, 3);
  ylm_error e = {YLM_OK, ""};
  ylm_status s;
  ylmL_progress progress;
  const ylm_progress *report = ylmL_progress_begin(L, 6, &progress);
  size_t rows = rows_of(in, out, lmax, &s);
  if (s == YLM_OK && log)
    s = ylm_sh_log(lmax, in->dtype, rows, x, in->data, out->data, threads, report, &e);
  else if (s == YLM_OK)
    s = ylm_sh_exp(lmax, in->dtype, rows, (int)x, in->data, out->data, threads, report, &e);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

static int sh_log(lua_State *L) { return sh_function(L, true); }
static int sh_exp(lua_State *L) { return sh_function(L, false); }

/* sh_exponential(c, lmax, method, out, threads, progress) -> true: PS of 9 terms, OL or HYB, by tables */
static int sh_exponential(lua_State *L) {
  ylmL_array *in = ylmL_array_check(L, 1), *out = ylmL_array_check(L, 4);
  int lmax = (int)luaL_checknumber(L, 2), threads = (int)luaL_optnumber(L, 5, 0);
  ylm_sh_exp_method method = (ylm_sh_exp_method)luaL_checkoption(L, 3, NULL, ylmL_sh_exp_choices);
  ylm_error e = {YLM_OK, ""};
  ylm_status s;
  ylm_sh_exponential *tables = NULL;
  ylmL_progress progress;
  const ylm_progress *report = ylmL_progress_begin(L, 6, &progress);
  size_t rows = rows_of(in, out, lmax, &s);
  if (s == YLM_OK) s = ylm_sh_exponential_create(lmax, method, 9, &tables, &e);
  if (s == YLM_OK)
    s = ylm_sh_exponential_apply(tables, in->dtype, rows, 0, in->data, out->data, threads, report,
                                 &e);
  ylm_sh_exponential_free(tables);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* sh_circle_log(lmax, angle, epsilon) -> double [lmax+1] */
static int sh_circle_log(lua_State *L) {
  int lmax = (int)luaL_checknumber(L, 1);
  double angle = (double)luaL_checknumber(L, 2), epsilon = (double)luaL_checknumber(L, 3);
  ylm_error e = {YLM_OK, ""};
  ylmL_array *z = ylmL_array_unset(L, YLM_DOUBLE, 1, (size_t[]){(size_t)lmax + 1});
  if (!z) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 1, ylm_sh_circle_log(lmax, angle, epsilon, z->data, &e), &e);
}

static const luaL_Reg functions[] = {{"sh_product_plan", sh_product_plan},
                                     {"sh_nodes", sh_nodes},
                                     {"sh_nodes_product", sh_nodes_product},
                                     {"sh_log", sh_log},
                                     {"sh_exp", sh_exp},
                                     {"sh_exponential", sh_exponential},
                                     {"sh_circle_log", sh_circle_log},
                                     {"sh_product", sh_product},
                                     {"sh_product_matrix", sh_product_matrix},
                                     {"sh_apply", sh_apply},
                                     {"sh_matrices_apply", sh_matrices_apply},
                                     {"sh_symmetric", sh_symmetric},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", product_gc}, {NULL, NULL}};
static const luaL_Reg nodes_methods[] = {{"__gc", nodes_gc}, {NULL, NULL}};

void ylmL_open_sh_product(lua_State *L) {
  ylmL_type(L, PRODUCT, methods);
  ylmL_type(L, NODES, nodes_methods);
  lua_pop(L, 2);
  luaL_setfuncs(L, functions, 0);
}
