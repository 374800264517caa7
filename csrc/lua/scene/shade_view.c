/* shade_view.c - prepared views: made, and what they know of their shading points. */
#include <math.h>
#include <string.h>

#include "shade.h"

/* The numbers of the list at `i` in memory of the state, and how many; NULL: there is none. */
static const uint32_t *read_pixels(lua_State *L, int i, size_t *n) {
  if (lua_isnil(L, i)) return NULL;
  luaL_checktype(L, i, LUA_TTABLE);
  *n = lua_rawlen(L, i);
  uint32_t *pixel = lua_newuserdata(L, (*n + 1) * sizeof *pixel);
  for (size_t k = 0; k < *n; k++) {
    lua_rawgeti(L, i, (int)k + 1);
    pixel[k] = (uint32_t)luaL_checknumber(L, -1);
    lua_pop(L, 1);
  }
  return pixel;
}

typedef struct view_form {
  ylm_camera camera;
  ylm_shade_options o;
  double window[YLM_SHADE_DEGREES];
  int pixels, progress; /* on the stack */
} view_form;

static const ylmL_entry view_entries[] = {
    YLML(view_form, camera, "camera", READ, .read = ylmL_read_camera),
    YLML(view_form, o.width, "width", INT),
    YLML(view_form, o.height, "height", INT),
    YLML(view_form, o.samples, "samples", INT),
    YLML(view_form, o.lmax, "lmax", INT),
    YLML(view_form, o.per_vertex, "shading", EITHER, .choices = ylmL_shading_choices),
    YLML(view_form, o.visibility, "visibility", CHOICE, .choices = ylmL_visibility_choices),
    YLML(view_form, o.transfer_samples, "transfer_samples", INT),
    YLML(view_form, o.occlusion_distance, "occlusion_distance", DOUBLE),
    YLML(view_form, o.share, "share", DOUBLE),
    YLML(view_form, o.seed, "seed", UINT64),
    YLML(view_form, o.threads, "threads", INT, .optional = true),
    YLML(view_form, progress, "progress", VALUE),
    YLML(view_form, o.light, "light", FIELD, .optional = true),
    YLML(view_form, o.noise, "noise", DOUBLE, .optional = true),
    YLML(view_form, o.most_samples, "most_samples", INT, .optional = true),
    YLML(view_form, pixels, "pixels", VALUE),
    YLML(view_form, o.gloss, "gloss", CHOICE, .choices = ylmL_gloss_choices, .optional = true),
    YLML(view_form, o.gloss_error, "gloss_error", NUMBERS, .optional = true),
    YLML(view_form, o.fine, "fine", BOOL),
    YLML(view_form, o.below_dark, "below_dark", BOOL),
    YLML(view_form, window, "window", NUMBERS, .optional = true),
    YLML(view_form, o.keep, "keep", BOOL),
    YLML(view_form, o.all_vertices, "all_vertices", BOOL),
    YLML(view_form, o.self, "self", BOOL),
    {.name = NULL}};

/* shade_view(scene, {camera: from, at, up, fov, 10 numbers; width, height, samples, lmax, shading,
   visibility, transfer_samples, occlusion_distance, share, seed, threads, progress, light | nil,
   noise | nil, most_samples | nil, pixels: a list of numbers from 0, these alone, | nil,
   gloss: "matte", "sh", "auto", "rays" | nil, gloss_error: two numbers | nil, fine, below_dark,
   window: YLM_SHADE_DEGREES factors | nil, keep | nil, all_vertices | nil, self | nil}) -> view */
static int shade_view(lua_State *L) {
  view_form f = {.pixels = 0};
  const ylm_scene *scene = ylmL_scene(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylmL_read(L, 2, view_entries, &f);
  for (int l = 0; l < YLM_SHADE_DEGREES; l++) f.o.window[l] = (float)f.window[l];
  f.o.pixel = read_pixels(L, f.pixels, &f.o.pixels);
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_shade_view **v = lua_newuserdata(L, sizeof *v);
  *v = NULL;
  luaL_getmetatable(L, YLML_SHADE_VIEW);
  lua_setmetatable(L, -2);
  ylm_status s = ylm_shade_view_create(scene, &f.camera, &f.o, v, &e);
  ylm_shade_stats stats = {0};
  if (s == YLM_OK) ylm_shade_view_stats(*v, &stats);
  ylmL_charge(L, stats.bytes);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* shade_stats(view) -> table */
static int shade_stats(lua_State *L) {
  ylm_shade_stats s;
  ylmL_charge(L, ylm_shade_view_grown(ylmL_shade_view(L, 1)));
  ylm_shade_view_stats(ylmL_shade_view(L, 1), &s);
  lua_newtable(L);
  ylmL_set_count(L, "points", s.points);
  ylmL_set_count(L, "hits", s.hits);
  ylmL_set_count(L, "pixels", s.pixels);
  ylmL_set_count(L, "primary_rays", s.primary_rays);
  ylmL_set_count(L, "occlusion_rays", s.occlusion_rays);
  ylmL_set_number(L, "primary_seconds", s.primary_seconds);
  ylmL_set_number(L, "transfer_seconds", s.transfer_seconds);
  ylmL_set_count(L, "transfer_samples",
                 (uint64_t)ylm_shade_view_options(ylmL_shade_view(L, 1))->transfer_samples);
  if (s.noise >= 0) ylmL_set_number(L, "noise", s.noise);
  ylmL_set_count(L, "bytes", s.bytes);
  if (ylm_shade_view_options(ylmL_shade_view(L, 1))->gloss) {
    ylmL_set_count(L, "glossy", s.glossy);
    ylmL_set_count(L, "gloss_bytes", s.gloss_bytes);
    ylmL_set_number(L, "gloss_seconds", s.gloss_seconds);
  }
  return 1;
}

/* shade_occlusion(view, points, light_samples, threads) -> table: ylm_shade_occlusion */
static int shade_occlusion(lua_State *L) {
  ylm_shade_occlusion o;
  ylm_status s =
      ylm_shade_measure_occlusion(ylmL_shade_view(L, 1), (size_t)luaL_checknumber(L, 2),
                                  (int)luaL_checknumber(L, 3), (int)luaL_checknumber(L, 4), &o);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  lua_newtable(L);
  ylmL_set_number(L, "passing", o.passing);
  ylmL_set_number(L, "passing_error", o.passing_error);
  ylmL_set_number(L, "missing", o.missing);
  ylmL_set_number(L, "missing_error", o.missing_error);
  ylmL_set_count(L, "points", o.points);
  ylmL_set_count(L, "rays", o.rays);
  ylmL_set_number(L, "seconds", o.seconds);
  return 1;
}

static bool push_positions(lua_State *L, const ylm_shade_view *v) {
  return ylmL_scene_push_places(L, ylm_shade_view_origin(v), ylmL_shade_points(v),
                                ylm_shade_view_positions(v));
}

/* shade_points(view) -> position [n][3], normal [n][3], albedo [n][3], object [n] from 1 */
static int shade_points(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_stats stats;
  ylm_shade_view_stats(v, &stats);
  ylmL_array *a[4];
  if (!push_positions(L, v)) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (int i = 1; i < 4; i++) {
    a[i] = ylmL_array_new(L, YLM_FLOAT, i < 3 ? 2 : 1, (size_t[]){stats.points, 3});
    if (!a[i]) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  }
  if (stats.points) {
    memcpy(a[1]->data, ylm_shade_view_normals(v), stats.points * 12);
    ylm_shade_view_surface(v, a[2]->data, a[3]->data);
  }
  for (size_t i = 0; i < stats.points; i++) ((float *)a[3]->data)[i] += 1;
  return 4;
}

/* shade_materials(view) -> [n][YLM_MATERIAL_ROW], for a device */
static int shade_materials(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_error e = {0};
  ylmL_array *a =
      ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylmL_shade_points(v), YLM_MATERIAL_ROW});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_shade_view_materials(v, a->data, &e);
  return ylmL_result(L, 1, s, &e);
}

/* shade_normals(view, of triangles) -> [n][3] on the side that is seen */
static int shade_normals(lua_State *L) {
  const ylm_shade_view *v = ylmL_shade_view(L, 1);
  size_t n = ylmL_shade_points(v);
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  if (lua_toboolean(L, 2))
    ylm_shade_view_flats(v, 0, n, a->data);
  else
    ylm_copy(a->data, ylm_shade_view_normals(v), n * 3 * sizeof(float));
  return 1;
}

static void push_vector(lua_State *L, const float v[3], const double *origin, const char *name) {
  lua_createtable(L, 3, 0);
  for (int a = 0; a < 3; a++) {
    lua_pushnumber(L, (lua_Number)v[a] + (origin ? origin[a] : 0));
    lua_rawseti(L, -2, a + 1);
  }
  lua_setfield(L, -2, name);
}

/* shade_hit(view, x, y from 0) -> { position, normal, depth, object from 1 } or nil */
static int shade_hit(lua_State *L) {
  ylm_shade_hit hit;
  const ylm_shade_view *v = ylmL_shade_view(L, 1);
  if (!ylm_shade_view_hit(v, (int)luaL_checknumber(L, 2), (int)luaL_checknumber(L, 3), &hit))
    return 0;
  lua_newtable(L);
  push_vector(L, hit.position, ylm_shade_view_origin(v), "position");
  push_vector(L, hit.normal, NULL, "normal");
  ylmL_set_number(L, "depth", (double)hit.depth);
  ylmL_set_count(L, "object", (uint64_t)hit.object + 1);
  return 1;
}

/* shade_positions(view) -> [n][3]; double where the scene is far from 0 */
static int shade_positions(lua_State *L) {
  return push_positions(L, ylmL_shade_view(L, 1)) ? 1 : ylmL_result(L, 0, YLM_ENOMEM, NULL);
}

/* shade_transfer(view) -> [n][count] */
static int shade_transfer(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylm_shade_stats stats;
  if (ylm_shade_view_options(v)->visibility == YLM_SHADE_RAYS)
    return ylmL_result(L, 0, YLM_EINVAL, NULL);
  ylm_shade_view_stats(v, &stats);
  size_t l = (size_t)ylm_shade_view_options(v)->lmax + 1;
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){stats.points, l * l});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  memcpy(a->data, ylm_shade_view_transfer(v), a->count * sizeof(float));
  return 1;
}

static const luaL_Reg functions[] = {
    {"shade_view", shade_view},           {"shade_stats", shade_stats},
    {"shade_points", shade_points},       {"shade_hit", shade_hit},
    {"shade_materials", shade_materials}, {"shade_positions", shade_positions},
    {"shade_normals", shade_normals},     {"shade_transfer", shade_transfer},
    {"shade_occlusion", shade_occlusion}, {NULL, NULL}};

void ylmL_open_shade_view(lua_State *L) { luaL_setfuncs(L, functions, 0); }
