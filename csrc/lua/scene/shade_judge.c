/* shade_judge.c - what paths say of the points of a view, and how far estimates are from it. */
#include <string.h>

#include "shade.h"

typedef struct judge_form {
  ylm_path_options o;
  int progress; /* on the stack */
} judge_form;

/* A call of the judge. */
typedef struct judging {
  judge_form f;
  ylmL_progress progress;
  ylm_path_stats stats;
  ylm_error e;
} judging;

static const ylmL_entry judge_entries[] = {
    YLML(judge_form, o.samples, "samples", INT),
    YLML(judge_form, o.first, "first", INT),
    YLML(judge_form, o.last, "last", INT),
    YLML(judge_form, o.error, "error", DOUBLE, .optional = true),
    YLML(judge_form, o.guides, "guides", BOOL, .optional = true),
    YLML(judge_form, o.single, "single", BOOL, .optional = true),
    YLML(judge_form, o.kept, "kept", READ, .read = ylmL_guides_read, .optional = true),
    YLML(judge_form, o.seed, "seed", UINT64),
    YLML(judge_form, o.threads, "threads", INT, .optional = true),
    YLML(judge_form, progress, "progress", VALUE),
    {.name = NULL}};

/* The view, and the options of the call. */
static ylm_shade_view *begin(lua_State *L, judging *j) {
  memset(j, 0, sizeof *j);
  ylmL_read(L, 2, judge_entries, &j->f);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  j->f.o.progress = ylmL_progress_begin(L, j->f.progress, &j->progress);
  return v;
}

/* Arrays mean and variance [n][3] on the stack. */
static bool new_results(lua_State *L, size_t n, float **mean, float **variance) {
  for (int i = 0; i < 2; i++) {
    ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
    if (!a) return false;
    *(i == 0 ? mean : variance) = a->data;
  }
  return true;
}

/* The results on the stack, and the rays. */
static int end(lua_State *L, int results, ylm_status s, judging *j) {
  const ylm_path_stats *t = &j->stats;
  ylmL_push_count(L, t->nearest_rays + t->lamp_rays + t->shadow_rays + t->guide_rays);
  return ylmL_result_progress(L, results + 1, s, &j->e, &j->progress);
}

/* shade_judge(view, {samples, first, last, error, guides, single, kept, seed, threads, progress})
   -> mean [n][3], variance [n][3], rays */
static int shade_judge(lua_State *L) {
  judging j;
  ylm_shade_view *v = begin(L, &j);
  float *mean, *variance;
  if (!new_results(L, ylmL_shade_points(v), &mean, &variance))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return end(L, 2, ylm_shade_judge(v, &j.f.o, mean, variance, &j.stats, &j.e), &j);
}

static size_t pixels_of(const ylm_shade_view *v) {
  const ylm_shade_options *o = ylm_shade_view_options(v);
  return (size_t)o->width * (size_t)o->height;
}

/* shade_judge_pixels(view, as above) -> radiance [pixels][3], variance [pixels][3], rays */
static int shade_judge_pixels(lua_State *L) {
  judging j;
  ylm_shade_view *v = begin(L, &j);
  float *mean, *variance;
  if (!new_results(L, pixels_of(v), &mean, &variance)) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return end(
      L, 2,
      ylm_shade_judge_pixels(v, &j.f.o, (float(*)[3])mean, (float(*)[3])variance, &j.stats, &j.e),
      &j);
}

/* The estimate in the table at `i`: { view, radiance [n][3], another one or nil }. False: they do not fit
   together. */
static bool read_estimate(lua_State *L, int i, ylm_shade_estimate *out) {
  luaL_checktype(L, i, LUA_TTABLE);
  for (int k = 1; k <= 3; k++) lua_rawgeti(L, i, k);
  int top = lua_gettop(L);
  out->view = ylmL_shade_view(L, top - 2);
  const ylmL_array *a = ylmL_array_check(L, top - 1), *again = ylmL_array_opt(L, top);
  size_t count = 3 * ylmL_shade_points(out->view);
  out->radiance = a->data;
  out->again = again ? again->data : NULL;
  return a->dtype == YLM_FLOAT && a->count == count &&
         (!again || (again->dtype == YLM_FLOAT && again->count == count));
}

/* shade_compare(a, b: estimates as above, variance [n][3] of b or nil, weight: double [pixels] or nil)
   -> { pixels, mean, square, uncertainty } */
static int shade_compare(lua_State *L) {
  ylm_shade_estimate a, b;
  ylm_shade_error out;
  lua_settop(L, 4);
  const ylmL_array *variance = ylmL_array_opt(L, 3), *weight = ylmL_array_opt(L, 4);
  if (!read_estimate(L, 1, &a) || !read_estimate(L, 2, &b) ||
      (variance &&
       (variance->dtype != YLM_FLOAT || variance->count != 3 * ylmL_shade_points(b.view))) ||
      (weight && (weight->dtype != YLM_DOUBLE || weight->count != pixels_of(b.view))))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_status s = ylm_shade_compare(&a, &b, variance ? variance->data : NULL,
                                   weight ? weight->data : NULL, &out);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  lua_newtable(L);
  ylmL_set_count(L, "pixels", out.pixels);
  ylmL_set_number(L, "mean", out.mean);
  ylmL_set_number(L, "square", out.square);
  ylmL_set_number(L, "uncertainty", out.uncertainty);
  return 1;
}

/* shade_draw(light [h][w][3], again [h][w][3] or nil, count, seed) -> { numbers from 0 }, { weights } */
static int shade_draw(lua_State *L) {
  const ylmL_array *light = ylmL_array_check(L, 1), *again = ylmL_array_opt(L, 2);
  double count = (double)luaL_checknumber(L, 3);
  ylm_shade_drawing d = {.seed = (uint64_t)luaL_checknumber(L, 4)};
  if (light->dtype != YLM_FLOAT || light->axes != 3 || light->shape[2] != 3 ||
      !(count >= 1 && count <= YLM_SHADE_PIXELS) ||
      (again && (again->dtype != YLM_FLOAT || again->count != light->count)))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  d.height = (int)light->shape[0], d.width = (int)light->shape[1], d.count = (size_t)count;
  d.light = light->data, d.again = again ? again->data : NULL;
  size_t drawn = 0;
  uint32_t *pixel = lua_newuserdata(L, d.count * sizeof *pixel);
  double *weight = lua_newuserdata(L, d.count * sizeof *weight);
  ylm_status s = ylm_shade_draw(&d, pixel, weight, &drawn);
  lua_createtable(L, (int)drawn, 0);
  lua_createtable(L, (int)drawn, 0);
  for (size_t k = 0; s == YLM_OK && k < drawn; k++) {
    lua_pushnumber(L, (lua_Number)pixel[k]);
    lua_rawseti(L, -3, (int)k + 1);
    lua_pushnumber(L, (lua_Number)weight[k]);
    lua_rawseti(L, -2, (int)k + 1);
  }
  return ylmL_result(L, 2, s, NULL);
}

static const luaL_Reg functions[] = {{"shade_judge", shade_judge},
                                     {"shade_judge_pixels", shade_judge_pixels},
                                     {"shade_compare", shade_compare},
                                     {"shade_draw", shade_draw},
                                     {NULL, NULL}};

void ylmL_open_shade_judge(lua_State *L) { luaL_setfuncs(L, functions, 0); }
