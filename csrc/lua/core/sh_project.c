/* sh_project.c - binds projection of samples. Arguments come sorted from
 * lua/ylm/sh/project.lua. */
#include "../binding.h"

#include "ylm_sh.h"

#include <math.h>

/* sh_rule(nodes, azimuths, lo, hi) -> directions [n][3], weights [n] */
static int sh_rule(lua_State *L) {
  int nodes = (int)luaL_checknumber(L, 1), azimuths = (int)luaL_checknumber(L, 2);
  if (nodes < 1 || azimuths < 1) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t shape[2] = {(size_t)nodes * (size_t)azimuths, 3};
  ylmL_array *d = ylmL_array_new(L, YLM_DOUBLE, 2, shape),
             *w = d ? ylmL_array_new(L, YLM_DOUBLE, 1, shape) : NULL;
  if (!w) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 2,
                     ylm_sh_sphere_rule(nodes, azimuths, (double)luaL_checknumber(L, 3),
                                        (double)luaL_checknumber(L, 4), d->data, w->data),
                     NULL);
}

/* sh_samples(side, seed, stream) -> directions [side^2][3] */
static int sh_samples(lua_State *L) {
  int side = (int)luaL_checknumber(L, 1);
  if (side < 1 || side > 100000) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t shape[2] = {(size_t)side * (size_t)side, 3};
  ylmL_array *d = ylmL_array_new(L, YLM_DOUBLE, 2, shape);
  if (!d) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_sh_sphere_samples(side, (uint64_t)luaL_checknumber(L, 2), (uint64_t)luaL_checknumber(L, 3),
                        d->data);
  return 1;
}

typedef struct project_form {
  ylmL_array *directions, *weights, *values, *out, *squares;
  int threads, progress; /* progress: on the stack */
} project_form;

static const ylmL_entry project_entries[] = {
    YLML(project_form, directions, "directions", ARRAY),
    YLML(project_form, weights, "weights", ARRAY, .optional = true),
    YLML(project_form, values, "values", ARRAY),
    YLML(project_form, out, "out", ARRAY),
    YLML(project_form, squares, "squares", ARRAY, .optional = true),
    YLML(project_form, threads, "threads", INT, .optional = true),
    YLML(project_form, progress, "progress", VALUE),
    {.name = NULL}};

/* sh_project(lmax, {directions [n][3], weights [n] | nil, values [n][channels], out
   [channels][count], squares [channels][count] | nil, threads, progress})
   -> true; all double */
static int sh_project(lua_State *L) {
  project_form f = {.threads = 0};
  int lmax = (int)luaL_checknumber(L, 1);
  ylmL_read(L, 2, project_entries, &f);
  const ylmL_array *d = f.directions, *w = f.weights, *v = f.values, *out = f.out,
                   *square = f.squares;
  ylm_error e = {YLM_OK, ""};
  ylmL_progress progress;
  size_t n = d->count / 3;
  if (lmax < 0 || lmax > YLM_LMAX) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t channels = n ? v->count / n : 1, count = ylm_sh_count(lmax);
  if (d->count != 3 * n || v->count != n * channels || (n && channels == 0) || channels > 1000 ||
      (w && w->count != n) || out->count != channels * count ||
      (square && square->count != out->count))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (d->dtype != YLM_DOUBLE || v->dtype != YLM_DOUBLE || out->dtype != YLM_DOUBLE ||
      (w && w->dtype != YLM_DOUBLE) || (square && square->dtype != YLM_DOUBLE))
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  const ylm_progress *report = ylmL_progress_begin(L, f.progress, &progress);
  ylm_status s =
      ylm_sh_project_samples(lmax, n, d->data, w ? w->data : NULL, (int)channels, v->data,
                             out->data, square ? square->data : NULL, f.threads, report, &e);
  lua_pushboolean(L, 1);
  return ylmL_result_progress(L, 1, s, &e, &progress);
}

/* sh_halve(width, height, faces, directions, weights, values [n][channels]) -> the same three,
 * coarser */
static int sh_halve(lua_State *L) {
  int width = (int)luaL_checknumber(L, 1), height = (int)luaL_checknumber(L, 2),
      faces = (int)luaL_checknumber(L, 3);
  ylmL_array *d = ylmL_array_check(L, 4), *w = ylmL_array_check(L, 5), *v = ylmL_array_check(L, 6);
  size_t n = w->count;
  if (width < 1 || faces < 1 || height < faces || height % faces ||
      n != (size_t)width * (size_t)height || d->count != 3 * n || v->count % n)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (d->dtype != YLM_DOUBLE || w->dtype != YLM_DOUBLE || v->dtype != YLM_DOUBLE)
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  size_t channels = v->count / n, coarse = ylm_sh_halved(width, height, faces);
  size_t d_shape[2] = {coarse, 3}, v_shape[2] = {coarse, channels};
  ylmL_array *d2 = ylmL_array_new(L, YLM_DOUBLE, 2, d_shape),
             *w2 = d2 ? ylmL_array_new(L, YLM_DOUBLE, 1, d_shape) : NULL,
             *v2 = w2 ? ylmL_array_new(L, YLM_DOUBLE, 2, v_shape) : NULL;
  if (!v2) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_sh_halve_pixels(width, height, faces, (int)channels, d->data, w->data, v->data, d2->data,
                      w2->data, v2->data);
  return 3;
}

/* sh_degree_scale(c [..][count], out, lmax, {factor of each degree}) -> true; out may be c */
static int sh_degree_scale(lua_State *L) {
  ylmL_array *c = ylmL_array_check(L, 1), *out = ylmL_array_check(L, 2);
  int lmax = (int)luaL_checknumber(L, 3);
  luaL_checktype(L, 4, LUA_TTABLE);
  if (lmax < 0 || lmax > YLM_LMAX) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  size_t count = ylm_sh_count(lmax), rows = c->count / count;
  if (c->count != rows * count || out->count != c->count)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (c->dtype != out->dtype) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  for (int l = 0; l <= lmax; l++) {
    lua_rawgeti(L, 4, l + 1);
    double f = (double)luaL_checknumber(L, -1);
    lua_pop(L, 1);
    for (size_t r = 0; r < rows; r++)
      for (int k = l * l; k < (l + 1) * (l + 1); k++) {
        size_t i = r * count + (size_t)k;
        if (c->dtype == YLM_DOUBLE)
          ((double *)out->data)[i] = f * ((const double *)c->data)[i];
        else
          ((float *)out->data)[i] = (float)(f * (double)((const float *)c->data)[i]);
      }
  }
  lua_pushboolean(L, 1);
  return 1;
}

/* sh_windowed_range(parts double [rows][lmax+1][n], {factor of each degree}) -> smallest, largest
   of the sums over degrees of factor times part */
static int windowed_range(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  luaL_checktype(L, 2, LUA_TTABLE);
  if (a->dtype != YLM_DOUBLE || a->axes != 3) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t rows = a->shape[0], degrees = a->shape[1], n = a->shape[2];
  double factor[YLM_LMAX + 1], lo = 1e308, hi = -1e308, sum[256];
  if (degrees > YLM_LMAX + 1) return ylmL_result(L, 0, YLM_ERANGE, NULL);
  for (size_t l = 0; l < degrees; l++) {
    lua_rawgeti(L, 2, (int)l + 1);
    factor[l] = (double)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  for (size_t r = 0; r < rows; r++) {
    const double *part = (const double *)a->data + r * degrees * n;
    for (size_t i = 0; i < n; i += 256) {
      size_t m = n - i < 256 ? n - i : 256;
      for (size_t k = 0; k < m; k++) sum[k] = 0;
      for (size_t l = 0; l < degrees; l++)
        for (size_t k = 0; k < m; k++) sum[k] += factor[l] * part[l * n + i + k];
      for (size_t k = 0; k < m; k++) {
        if (sum[k] < lo) lo = sum[k];
        if (sum[k] > hi) hi = sum[k];
      }
    }
  }
  lua_pushnumber(L, lo);
  lua_pushnumber(L, hi);
  return 2;
}

/* Part u of the way from low to high, even where their distance is no finite number. */
static double between(double low, double high, double u) {
  double way = high - low;
  return isfinite(way) ? low + way * u : low * (1 - u) + high * u;
}

/* sh_random(array, seed, low, high): uniform in low .. high */
static int sh_random(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1);
  double low = (double)luaL_checknumber(L, 3), high = (double)luaL_checknumber(L, 4);
  ylm_rng r;
  ylm_rng_seed(&r, (uint64_t)luaL_checknumber(L, 2), 1);
  for (size_t i = 0; i < a->count; i++) {
    double x = between(low, high, ylm_rng_double(&r));
    if (a->dtype == YLM_DOUBLE)
      ((double *)a->data)[i] = x;
    else
      ((float *)a->data)[i] = (float)x;
  }
  return 0;
}

/* sh_relative_error(a [rows][width], b, out [rows], norms [rows]): norm of a-b over norm of b, and
 * the latter; double */
static int sh_relative_error(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1), *b = ylmL_array_check(L, 2),
             *out = ylmL_array_check(L, 3);
  ylmL_array *norms = ylmL_array_check(L, 4);
  if (norms->dtype != YLM_DOUBLE || norms->count != out->count)
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (a->dtype != YLM_DOUBLE || b->dtype != YLM_DOUBLE || out->dtype != YLM_DOUBLE)
    return ylmL_result(L, 0, YLM_ETYPE, NULL);
  size_t rows = out->count, width = rows ? b->count / rows : 0;
  if (a->count != b->count || b->count != rows * width) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  for (size_t r = 0; r < rows; r++) {
    double d = 0, n = 0;
    for (size_t i = r * width; i < (r + 1) * width; i++) {
      double x = ((const double *)a->data)[i], y = ((const double *)b->data)[i];
      d += (x - y) * (x - y);
      n += y * y;
    }
    ((double *)out->data)[r] = d == 0 ? 0 : sqrt(d / n);
    ((double *)norms->data)[r] = sqrt(n);
  }
  lua_pushboolean(L, 1);
  return 1;
}

static const luaL_Reg functions[] = {{"sh_rule", sh_rule},
                                     {"sh_samples", sh_samples},
                                     {"sh_project", sh_project},
                                     {"sh_halve", sh_halve},
                                     {"sh_degree_scale", sh_degree_scale},
                                     {"sh_windowed_range", windowed_range},
                                     {"sh_random", sh_random},
                                     {"sh_relative_error", sh_relative_error},
                                     {NULL, NULL}};

void ylmL_open_sh_project(lua_State *L) { luaL_setfuncs(L, functions, 0); }
