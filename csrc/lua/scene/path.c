/* path.c - the path tracer: pictures and probes; lua/ylm/path drives it. */
#include "traced.h"
#include "transfer.h"
#include "ylm_path.h"
#include "ylm_sh.h"

/* Entries that all estimates take, of a struct with `o` and `progress`, an index on the stack. */
#define COMMON(form)                                                                               \
  YLML(form, o.samples, "samples", INT), YLML(form, o.first, "first", INT),                        \
      YLML(form, o.last, "last", INT),                                                             \
      YLML(form, o.strategy, "strategy", CHOICE, .choices = ylmL_path_strategy_choices),           \
      YLML(form, o.error, "error", DOUBLE, .optional = true),                                      \
      YLML(form, o.seconds, "seconds", DOUBLE, .optional = true),                                  \
      YLML(form, o.guides, "guides", BOOL, .optional = true), YLML(form, o.seed, "seed", UINT64),  \
      YLML(form, o.threads, "threads", INT, .optional = true),                                     \
      YLML(form, progress, "progress", VALUE)

static void push_stats(lua_State *L, const ylm_path_sum *sum, const ylm_path_stats *s) {
  static const char *const ends[] = {"samples", "error", "seconds"};
  lua_newtable(L);
  ylmL_set_count(L, "samples", sum->samples);
  ylmL_set_count(L, "paths", s->paths);
  ylmL_set_count(L, "nearest", s->nearest_rays);
  ylmL_set_count(L, "lamps", s->lamp_rays);
  ylmL_set_count(L, "shadow", s->shadow_rays);
  ylmL_set_count(L, "guides", s->guide_rays);
  ylmL_set_count(L, "clusters", s->clusters);
  ylmL_set_count(L, "absorbed", s->absorbed);
  ylmL_set_count(L, "lost", s->lost);
  if (s->noise >= 0) ylmL_set_number(L, "noise", s->noise);
  ylmL_set_number(L, "seconds", s->seconds);
  lua_pushstring(L, ends[s->end]);
  lua_setfield(L, -2, "ended");
}

/* The float array at `i`, of n elements. */
static float *floats(lua_State *L, int i, size_t n) {
  ylmL_array *a = ylmL_array_check(L, i);
  if (a->dtype != YLM_FLOAT || a->count != n) luaL_argerror(L, 2, "an array of another size");
  return a->data;
}

typedef struct image_form {
  ylm_path_options o;
  ylm_camera camera;
  int width, height, mean, rest, variance, counts, progress; /* from mean on: on the stack */
  double background[3];
  uint64_t done;
} image_form;

static const ylmL_entry image_entries[] = {
    YLML(image_form, camera, "camera", READ, .read = ylmL_read_camera),
    YLML(image_form, width, "width", INT),
    YLML(image_form, height, "height", INT),
    YLML(image_form, background, "background", NUMBERS),
    YLML(image_form, mean, "mean", VALUE),
    YLML(image_form, rest, "rest", VALUE),
    YLML(image_form, variance, "variance", VALUE),
    YLML(image_form, counts, "counts", VALUE),
    YLML(image_form, done, "done", UINT64),
    COMMON(image_form),
    {.name = NULL}};

/* path_image(scene, {camera: from, at, up, fov, 10 numbers; width, height, background {r, g, b}, mean,
   rest, variance: float [h][w][3], counts: out [h][w][1] samples, of what is cancelled too, done: samples that they hold;
   COMMON}) -> stats */
static int path_image(lua_State *L) {
  image_form f = {.progress = 0};
  const ylm_scene *scene = ylmL_scene(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylmL_read(L, 2, image_entries, &f);
  float b[3] = {(float)f.background[0], (float)f.background[1], (float)f.background[2]};
  size_t n = 3 * (size_t)f.width * (size_t)f.height;
  ylm_path_sum sum = {f.done, floats(L, f.mean, n), floats(L, f.rest, n), floats(L, f.variance, n)};
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_path_stats stats;
  float *count = floats(L, f.counts, n / 3);
  ylm_status s = ylm_path_image(scene, &f.camera, f.width, f.height, b, &f.o, &sum, &stats, &e);
  for (size_t i = 0; i < n / 3; i++) count[i] = (float)sum.samples;
  if (s == YLM_OK) push_stats(L, &sum, &stats);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* The sums of n numbers as two arrays of doubles, [n][3][count] or [n][3], at the stack's top. */
static bool push_sum(lua_State *L, const ylm_path_sum *sum, size_t n, size_t count) {
  ylmL_array *a[2];
  for (int i = 0; i < 2; i++) {
    a[i] = ylmL_array_new(L, YLM_DOUBLE, count ? 3 : 2, (size_t[]){n, 3, count});
    if (!a[i]) return false;
  }
  for (size_t k = 0; k < a[0]->count; k++) {
    ((double *)a[0]->data)[k] = (double)sum->mean[k] + (double)sum->rest[k];
    ((double *)a[1]->data)[k] = (double)sum->variance[k];
  }
  return true;
}

#define YLML_GUIDES "ylm.path_guides"

static void destroy_guides(void *g) { ylm_path_guides_free(g); }

/* path_guides() -> what probes of one scene may keep: nothing yet */
static int path_guides(lua_State *L) {
  ylmL_held *h = ylmL_hold(L, YLML_GUIDES, destroy_guides, NULL);
  h->object = ylm_path_guides_create();
  return ylmL_result(L, 1, h->object ? YLM_OK : YLM_ENOMEM, NULL);
}

void ylmL_guides_read(lua_State *L, int i, void *to) {
  *(ylm_path_guides **)to = ylmL_held_check(L, i, YLML_GUIDES)->object;
}

typedef struct probe_form {
  ylm_path_options o;
  int points, normals, lmax, progress; /* all but lmax: on the stack */
} probe_form;

static const ylmL_entry probe_entries[] = {
    YLML(probe_form, points, "points", VALUE),
    YLML(probe_form, normals, "normals", VALUE),
    YLML(probe_form, lmax, "lmax", INT),
    YLML(probe_form, o.kept, "kept", READ, .read = ylmL_guides_read, .optional = true),
    COMMON(probe_form),
    {.name = NULL}};

/* path_probe(scene, {points [n][3], normals float [n][3] or nil, lmax, kept: guides of this scene, which is as it was, or nil, COMMON}) ->
   without normals: c, variance [n][3][count]; with: irradiance, variance [n][3]; stats */
static int path_probe(lua_State *L) {
  probe_form f = {.progress = 0};
  const ylm_scene *scene = ylmL_scene(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylmL_read(L, 2, probe_entries, &f);
  size_t n;
  const float(*x)[3] = ylmL_scene_places(L, f.points, ylm_scene_origin(scene), &n);
  const float *normals = lua_isnil(L, f.normals) ? NULL : floats(L, f.normals, 3 * n);
  size_t count = normals ? 0 : (size_t)(f.lmax + 1) * (size_t)(f.lmax + 1),
         all = 3 * n * (count ? count : 1);
  f.o.progress = ylmL_progress_begin(L, f.progress, &p);
  ylmL_array *room = ylmL_array_new(L, YLM_FLOAT, 1, (size_t[]){3 * all});
  if (!room) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  float *data = room->data;
  ylm_path_sum sum = {0, data, data + all, data + 2 * all};
  ylm_path_stats stats;
  const float(*d)[3] = (const float(*)[3])normals;
  ylm_status s = d ? ylm_path_irradiance(scene, n, x, d, &f.o, &sum, &stats, &e)
                   : ylm_path_probe(scene, n, x, f.lmax, &f.o, &sum, &stats, &e);
  if (s == YLM_OK && !push_sum(L, &sum, n, count)) s = YLM_ENOMEM;
  if (s == YLM_OK) push_stats(L, &sum, &stats);
  return ylmL_result_progress(L, 3, s, &e, &p);
}

/* path_copy(from, to): float arrays of one size */
static int path_copy(lua_State *L) {
  ylmL_array *from = ylmL_array_check(L, 1), *to = ylmL_array_check(L, 2);
  if (from->dtype != YLM_FLOAT || to->dtype != YLM_FLOAT) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (from->count != to->count) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylm_copy(to->data, from->data, from->count * sizeof(float));
  lua_pushvalue(L, 2);
  return 1;
}

/* path_add(values, mean, rest, variance: float arrays of one size, done) -> done: adds a batch */
static int path_add(lua_State *L) {
  ylmL_array *values = ylmL_array_check(L, 1);
  size_t n = values->count;
  ylm_path_sum sum = {(uint64_t)luaL_checknumber(L, 5), floats(L, 2, n), floats(L, 3, n),
                      floats(L, 4, n)};
  ylm_path_add(&sum, n, floats(L, 1, n));
  ylmL_push_count(L, sum.samples);
  return 1;
}

static const luaL_Reg functions[] = {{"path_add", path_add},       {"path_copy", path_copy},
                                     {"path_guides", path_guides}, {"path_image", path_image},
                                     {"path_probe", path_probe},   {NULL, NULL}};

void ylmL_open_path(lua_State *L) {
  static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};
  ylmL_type(L, YLML_GUIDES, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
