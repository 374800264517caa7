/* adjoint.c - receivers, light lamp by lamp and links backwards as Lua objects. */
#include <string.h>

#include "transfer.h"
#include "ylm_transfer_adjoint.h"

#define YLML_RECEIVERS "ylm.receivers"
#define YLML_LAMPLIGHT "ylm.lamplight"
#define YLML_TRANSPOSE "ylm.transpose"

static ylm_receivers *check_receivers(lua_State *L, int i) {
  return ylmL_held_check(L, i, YLML_RECEIVERS)->object;
}

static void destroy_receivers(void *r) { ylm_receivers_free(r); }
static void destroy_lamplight(void *l) { ylm_lamplight_free(l); }
static void destroy_transpose(void *x) { ylm_transpose_free(x); }

/* A double array [n][3] at i; raises where it has another shape. */
static const double (*rows_at(lua_State *L, int i, size_t n))[3] {
  const ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_DOUBLE || a->count != 3 * n)
    luaL_argerror(L, i, lua_pushfstring(L, "double [%d][3] expected", (int)n));
  return (const double(*)[3])a->data;
}

static ylmL_array *new_rows(lua_State *L, ylm_dtype type, size_t n) {
  ylmL_array *a = ylmL_array_new(L, type, 2, (size_t[]){n, 3});
  if (!a) ylmL_no_memory(L, NULL);
  return a;
}

/* receivers_create(links, points [n][3], normals float [n][3], links of each, seed, threads, progress) -> receivers */
static int receivers_create(lua_State *L) {
  ylmL_held *of = ylmL_held_check(L, 1, YLML_TRANSFER);
  const ylm_transfer *t = of->object;
  ylm_error e = {0};
  ylmL_progress p;
  size_t n, normals;
  lua_settop(L, 7);
  const float(*point)[3] = ylmL_scene_places(L, 2, ylm_scene_origin(ylm_transfer_scene(t)), &n);
  const float(*normal)[3] = ylmL_scene_places(L, 3, NULL, &normals);
  if (n != normals) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  int links = (int)luaL_checknumber(L, 4), threads = (int)luaL_optnumber(L, 6, 0);
  uint64_t seed = (uint64_t)luaL_checknumber(L, 5);
  const ylm_progress *progress = ylmL_progress_begin(L, 7, &p);
  ylmL_held *h = ylmL_hold(L, YLML_RECEIVERS, destroy_receivers, of);
  ylm_receivers *r;
  ylm_status s = ylm_receivers_create(t, n, point, normal, links, seed, threads, progress, &r, &e);
  h->object = r;
  if (s == YLM_OK) ylmL_charge(L, n * (28 + 4 * (size_t)links));
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* receivers_share(receivers) -> float [n] */
static int receivers_share(lua_State *L) {
  const ylm_receivers *r = check_receivers(L, 1);
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 1, (size_t[]){ylm_receivers_count(r)});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_copy(a->data, ylm_receivers_share(r), a->count * sizeof(float));
  return 1;
}

/* receivers_indirect(receivers, radiosity, threads) -> float [n][3] */
static int receivers_indirect(lua_State *L) {
  const ylm_receivers *r = check_receivers(L, 1);
  ylm_error e = {0};
  int threads = (int)luaL_optnumber(L, 3, 0);
  ylmL_array *a = new_rows(L, YLM_FLOAT, ylm_receivers_count(r));
  return ylmL_result(L, 1, ylm_receivers_indirect(r, ylmL_radiosity(L, 2), threads, a->data, &e),
                     &e);
}

/* receivers_rays(receivers, scene, light_samples, seed, threads, progress) -> float [n][3] */
static int receivers_rays(lua_State *L) {
  const ylm_receivers *r = check_receivers(L, 1);
  const ylm_scene *scene = ylmL_scene(L, 2);
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 6);
  const ylm_progress *progress = ylmL_progress_begin(L, 6, &p);
  ylmL_array *a = new_rows(L, YLM_FLOAT, ylm_receivers_count(r));
  ylm_status s =
      ylm_receivers_rays(r, scene, (int)luaL_checknumber(L, 3), (uint64_t)luaL_checknumber(L, 4),
                         (int)luaL_optnumber(L, 5, 0), progress, a->data, &e);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* receivers_scatter(receivers, weights double [n][3]) -> double [elements][3] */
static int receivers_scatter(lua_State *L) {
  const ylm_receivers *r = check_receivers(L, 1);
  const double(*weight)[3] = rows_at(L, 2, ylm_receivers_count(r));
  ylmL_array *a = new_rows(L, YLM_DOUBLE, ylm_transfer_count(ylm_receivers_transfer(r)));
  ylm_receivers_scatter(r, weight, a->data);
  return 1;
}

/* Numbers of a lamp: shape, place, axis, C0, half sizes, scale, the name of its table or 0, power, cone, how many corners. */
enum { LAMP_NUMBERS = 20 };

static ylm_lamp lamp_of(const double *x, const double *origin, const ylm_lamp_corner *corner) {
  ylm_lamp l = {.shape = (ylm_lamp_shape)x[0],
                .half = {x[10], x[11]},
                .power = x[16],
                .cone = {x[17], x[18]},
                .corners = (size_t)x[19],
                .corner = corner};
  for (int a = 0; a < 3; a++) {
    l.at[a] = x[1 + a] - (origin ? origin[a] : 0);
    l.axis[a] = x[4 + a], l.across[a] = x[7 + a], l.scale[a] = x[12 + a];
  }
  l.table = x[15] > 0 ? ylm_light_photometry_named(x[15]) : NULL;
  return l;
}

/* Corners of all polygons out of a double array [n][2], on the stack. */
static ylm_lamp_corner *read_corners(lua_State *L, const ylmL_array *a, size_t *n) {
  *n = a->count / 2;
  ylm_lamp_corner *c = lua_newuserdata(L, (*n + 1) * sizeof *c);
  for (size_t i = 0; i < *n; i++)
    c[i] = (ylm_lamp_corner){
        .place = {((const double *)a->data)[2 * i], ((const double *)a->data)[2 * i + 1]}};
  return c;
}

typedef struct lamplight_form {
  ylm_lamplight_form f;
  int progress; /* on the stack */
} lamplight_form;

static const ylmL_entry lamplight_entries[] = {
    YLML(lamplight_form, f.light_samples, "light_samples", INT),
    YLML(lamplight_form, f.rim, "rim", INT),
    YLML(lamplight_form, f.seed, "seed", UINT64),
    YLML(lamplight_form, f.bytes, "bytes", COUNT, .optional = true),
    YLML(lamplight_form, f.threads, "threads", INT, .optional = true),
    YLML(lamplight_form, progress, "progress", VALUE),
    {.name = NULL}};

/* lamplight_create(links, receivers or nil, lamps double [n][20], corners double [m][2],
   {light_samples, rim, seed, bytes, threads, progress}) -> lamplight */
static int lamplight_create(lua_State *L) {
  ylmL_held *of = ylmL_held_check(L, lua_isnoneornil(L, 2) ? 1 : 2,
                                  lua_isnoneornil(L, 2) ? YLML_TRANSFER : YLML_RECEIVERS);
  const ylm_transfer *t = ylmL_held_check(L, 1, YLML_TRANSFER)->object;
  const ylm_receivers *r = lua_isnoneornil(L, 2) ? NULL : check_receivers(L, 2);
  const ylmL_array *rows = ylmL_array_check(L, 3), *corners = ylmL_array_check(L, 4);
  lamplight_form form = {.progress = 0};
  ylm_error e = {0};
  ylmL_progress p;
  ylmL_read(L, 5, lamplight_entries, &form);
  if (rows->dtype != YLM_DOUBLE || rows->count % LAMP_NUMBERS || corners->dtype != YLM_DOUBLE ||
      (r && ylm_receivers_transfer(r) != t))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = rows->count / LAMP_NUMBERS, all, used = 0;
  const ylm_lamp_corner *corner = read_corners(L, corners, &all);
  ylm_lamp *lamp = lua_newuserdata(L, (n + 1) * sizeof *lamp);
  form.f.progress = ylmL_progress_begin(L, form.progress, &p);
  ylmL_held *h = ylmL_hold(L, YLML_LAMPLIGHT, destroy_lamplight, of);
  const double *origin = ylm_scene_origin(ylm_transfer_scene(t));
  const double *row = rows->data;
  bool known = true;
  for (size_t k = 0; k < n; k++) {
    const double shape = row[LAMP_NUMBERS * k], has = row[LAMP_NUMBERS * (k + 1) - 1];
    known = known && shape >= 0 && shape <= YLM_LAMP_sun && has >= 0 && has <= (double)all;
  }
  if (!known) return ylmL_result_progress(L, 1, YLM_ESHAPE, NULL, &p);
  for (size_t k = 0; k < n; k++) {
    lamp[k] = lamp_of(row + LAMP_NUMBERS * k, origin, corner + (used < all ? used : all));
    used += lamp[k].corners;
  }
  ylm_lamplight *l = NULL;
  ylm_status s = used == all ? ylm_lamplight_create(t, r, n, lamp, &form.f, &l, &e) : YLM_ESHAPE;
  for (size_t k = 0; k < n; k++)
    ylm_light_photometry_free((ylm_light_photometry *)(uintptr_t)lamp[k].table);
  h->object = l;
  if (s == YLM_OK) {
    ylm_lamplight_stats stats;
    ylm_lamplight_look(l, &stats);
    ylmL_charge(L, stats.bytes);
  }
  return ylmL_result_progress(L, 1, s, &e, &p);
}

static ylm_lamplight *check_lamplight(lua_State *L, int i) {
  return ylmL_held_check(L, i, YLML_LAMPLIGHT)->object;
}

/* lamplight_direct(lamplight) -> float [places][3] */
static int lamplight_direct(lua_State *L) {
  const ylm_lamplight *l = check_lamplight(L, 1);
  ylmL_array *a = new_rows(L, YLM_FLOAT, ylm_lamplight_places(l));
  ylm_lamplight_direct(l, a->data);
  return 1;
}

/* lamplight_stats(lamplight) -> table */
static int lamplight_stats(lua_State *L) {
  ylm_lamplight_stats s;
  ylm_lamplight_look(check_lamplight(L, 1), &s);
  lua_newtable(L);
  ylmL_set_count(L, "rays", s.rays);
  ylmL_set_count(L, "rim_rays", s.rim_rays);
  ylmL_set_count(L, "pairs", s.pairs);
  ylmL_set_count(L, "partly", s.partly);
  ylmL_set_count(L, "bytes", s.bytes);
  ylmL_set_boolean(L, "again", s.again);
  ylmL_set_number(L, "seconds", s.seconds);
  return 1;
}

/* lamplight_weigh(lamplight, weights double [places][3], threads) -> double [lamps][18] */
static int lamplight_weigh(lua_State *L) {
  ylm_lamplight *l = check_lamplight(L, 1);
  const double(*weight)[3] = rows_at(L, 2, ylm_lamplight_places(l));
  ylmL_array *a =
      ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){ylm_lamplight_lamps(l), YLM_LAMPLIGHT_NUMBERS});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 1, ylm_lamplight_weigh(l, weight, (int)luaL_optnumber(L, 3, 0), a->data),
                     NULL);
}

/* transpose_create(links) -> transpose */
static int transpose_create(lua_State *L) {
  ylmL_held *of = ylmL_held_check(L, 1, YLML_TRANSFER);
  ylmL_held *h = ylmL_hold(L, YLML_TRANSPOSE, destroy_transpose, of);
  ylm_transpose *x;
  ylm_status s = ylm_transpose_create(of->object, &x);
  h->object = x;
  if (s == YLM_OK) {
    ylm_transfer_stats stats;
    ylm_transfer_look(of->object, &stats);
    ylmL_charge(L, 4 * stats.rays + 8 * stats.elements);
  }
  return ylmL_result(L, 1, s, NULL);
}

/* transpose_importance(transpose, radiosity, leaving double [n][3], falling double [n][3] or nil, threads) -> double [n][3] */
static int transpose_importance(lua_State *L) {
  const ylm_transpose *x = ylmL_held_check(L, 1, YLML_TRANSPOSE)->object;
  const ylm_radiosity *lit = ylmL_radiosity(L, 2);
  size_t n = ylm_transfer_count(ylm_radiosity_transfer(lit));
  const double(*leaving)[3] = rows_at(L, 3, n);
  const double(*falling)[3] = lua_isnoneornil(L, 4) ? NULL : rows_at(L, 4, n);
  ylm_error e = {0};
  int threads = (int)luaL_optnumber(L, 5, 0);
  ylmL_array *a = new_rows(L, YLM_DOUBLE, n);
  return ylmL_result(L, 1, ylm_transpose_importance(x, lit, leaving, falling, threads, a->data, &e),
                     &e);
}

/* transpose_albedo(transpose, radiosity, leaving, importance double [n][3], threads) -> double [n][3] */
static int transpose_albedo(lua_State *L) {
  const ylm_transpose *x = ylmL_held_check(L, 1, YLML_TRANSPOSE)->object;
  const ylm_radiosity *lit = ylmL_radiosity(L, 2);
  size_t n = ylm_transfer_count(ylm_radiosity_transfer(lit));
  const double(*leaving)[3] = rows_at(L, 3, n), (*importance)[3] = rows_at(L, 4, n);
  ylm_error e = {0};
  int threads = (int)luaL_optnumber(L, 5, 0);
  ylmL_array *a = new_rows(L, YLM_DOUBLE, n);
  return ylmL_result(L, 1, ylm_transpose_albedo(x, lit, leaving, importance, threads, a->data, &e),
                     &e);
}

static const luaL_Reg functions[] = {
    {"receivers_create", receivers_create},     {"receivers_share", receivers_share},
    {"receivers_indirect", receivers_indirect}, {"receivers_rays", receivers_rays},
    {"receivers_scatter", receivers_scatter},   {"receivers_close", ylmL_let_go},
    {"lamplight_create", lamplight_create},     {"lamplight_direct", lamplight_direct},
    {"lamplight_stats", lamplight_stats},       {"lamplight_weigh", lamplight_weigh},
    {"transpose_create", transpose_create},     {"transpose_importance", transpose_importance},
    {"transpose_albedo", transpose_albedo},     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};

void ylmL_open_adjoint(lua_State *L) {
  static const char *const types[] = {YLML_RECEIVERS, YLML_LAMPLIGHT, YLML_TRANSPOSE};
  for (int i = 0; i < 3; i++) {
    ylmL_type(L, types[i], methods);
    lua_pop(L, 1);
  }
  luaL_setfuncs(L, functions, 0);
}
