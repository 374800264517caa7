/* chooser.c - binds choosers of rays to lamps, for specs and benchmarks. */
#include "traced.h"

/* A chooser of the scene at 1, turned to the point {x, y, z} at 2 with the normal at 3, or nil: in
   space. *lit: a lamp can bring light there. NULL without memory. */
static ylm_scene_chooser *turned(lua_State *L, bool *lit) {
  double numbers[6];
  float x[3], n[3];
  bool surface = !lua_isnil(L, 3);
  ylmL_scene_numbers(L, 2, 3, numbers);
  if (surface) ylmL_scene_numbers(L, 3, 3, numbers + 3);
  ylm_scene_enter(ylmL_scene(L, 1), numbers, x);
  for (int a = 0; a < 3; a++) n[a] = surface ? (float)numbers[3 + a] : 0;
  ylm_scene_chooser *c = ylm_scene_chooser_create(ylmL_scene(L, 1));
  *lit = c && ylm_scene_choose(c, x, surface ? n : NULL);
  return c;
}

/* chooser_sample(scene, point, normal | nil, u double [n][3]) -> double [n][9]: direction, density
   (0: no ray), radiance, lamp from 1 (2^32: none), density by ylm_scene_density */
static int chooser_sample(lua_State *L) {
  const ylmL_array *u = ylmL_array_check(L, 4);
  if (u->dtype != YLM_DOUBLE || u->count % 3) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = u->count / 3;
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 9});
  bool lit;
  ylm_scene_chooser *c = out ? turned(L, &lit) : NULL;
  if (!c) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *to = out->data;
  for (size_t i = 0; i < n && lit; i++, to += 9) {
    ylm_trace_ray ray = {{0, 0, 0}, 0, {0, 0, 0}, 0, 0, {0}};
    float radiance[3] = {0, 0, 0};
    uint32_t lamp = UINT32_MAX; /* chosen was none */
    to[3] = ylm_scene_sample(c, (const double *)u->data + 3 * i, &ray, radiance, &lamp);
    for (int a = 0; a < 3; a++) to[a] = (double)ray.dir[a], to[4 + a] = (double)radiance[a];
    to[7] = lamp + 1.0;
    to[8] = to[3] > 0 ? ylm_scene_density(c, lamp, ray.dir) : 0;
  }
  ylm_scene_chooser_free(c);
  return 1;
}

/* chooser_sky(scene, point, normal | nil, directions float [n][3]) -> double [n][4]: of the distant
   lights that shine from there the density, and the radiance */
static int chooser_sky(lua_State *L) {
  const ylmL_array *d = ylmL_array_check(L, 4);
  if (d->dtype != YLM_FLOAT || d->count % 3) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  const ylm_scene *s = ylmL_scene(L, 1);
  size_t n = d->count / 3, near = ylm_scene_near(s), all = ylm_scene_distant(s);
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 4});
  bool lit;
  ylm_scene_chooser *c = out ? turned(L, &lit) : NULL;
  if (!c) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *to = out->data;
  for (size_t i = 0; i < n; i++, to += 4) {
    const float *direction = (const float *)d->data + 3 * i;
    float radiance[3];
    for (int k = 0; k < 4; k++) to[k] = 0;
    for (size_t l = ylm_scene_distant_next(s, 0, direction, radiance); l < all;
         l = ylm_scene_distant_next(s, l + 1, direction, radiance)) {
      to[0] += lit ? ylm_scene_density(c, (uint32_t)(near + l), direction) : 0;
      for (int a = 0; a < 3; a++) to[1 + a] += (double)radiance[a];
    }
  }
  ylm_scene_chooser_free(c);
  return 1;
}

/* chooser_shares(scene, point, normal | nil) -> double [lamps]: how often each is chosen */
static int chooser_shares(lua_State *L) {
  const ylm_scene *s = ylmL_scene(L, 1);
  lua_settop(L, 3);
  size_t n = ylm_scene_near(s) + ylm_scene_distant(s);
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 1, &n);
  bool lit;
  ylm_scene_chooser *c = out ? turned(L, &lit) : NULL;
  if (!c) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++)
    ((double *)out->data)[i] = lit ? ylm_scene_share(c, (uint32_t)i) : 0;
  ylm_scene_chooser_free(c);
  return 1;
}

/* The mean of the green that rays bring, and the variance of that mean, of `repeats` times aimed. */
static void aim_often(ylm_scene_chooser *c, const float *at, int light_samples, int repeats,
                      ylm_rng *rng, ylm_trace_ray *ray, float (*value)[3], double out[2]) {
  double sum = 0, squares = 0;
  for (int k = 0; k < repeats; k++) {
    double e = 0;
    size_t rays = ylm_scene_aim(c, at, at + 3, NULL, light_samples, rng, ray, value);
    for (size_t i = 0; i < rays; i++) e += (double)value[i][1];
    sum += e;
    squares += e * e;
  }
  out[0] = sum / repeats;
  out[1] = repeats > 1 ? (squares / repeats - out[0] * out[0]) / (repeats - 1) : 0;
}

/* chooser_aim(scene, points with normals float [n][6], relative to the scene's origin, light_samples, repeats, seed) -> double [n][2]:
   the mean of what ylm_scene_aim brings, in green, and its variance */
static int chooser_aim(lua_State *L) {
  const ylmL_array *in = ylmL_array_check(L, 2);
  int light_samples = (int)luaL_checkinteger(L, 3), repeats = (int)luaL_checkinteger(L, 4);
  lua_Integer seed = luaL_checkinteger(L, 5);
  luaL_argcheck(L, light_samples >= 1 && light_samples <= YLM_SCENE_SAMPLES, 3,
                "1 .. YLM_SCENE_SAMPLES");
  luaL_argcheck(L, repeats >= 1, 4, "1 or more");
  if (in->dtype != YLM_FLOAT || in->count % 6) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = in->count / 6, rays = (size_t)light_samples;
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 2});
  ylm_scene_chooser *c = out ? ylm_scene_chooser_create(ylmL_scene(L, 1)) : NULL;
  ylm_trace_ray *ray = c ? ylm_alloc(rays, sizeof *ray) : NULL;
  float(*value)[3] = ray ? ylm_alloc(rays, sizeof *value) : NULL;
  for (size_t i = 0; value && i < n; i++) {
    ylm_rng rng;
    ylm_rng_seed(&rng, (uint64_t)seed, i);
    aim_often(c, (const float *)in->data + 6 * i, light_samples, repeats, &rng, ray, value,
              (double *)out->data + 2 * i);
  }
  bool done = value != NULL;
  ylm_scene_chooser_free(c);
  ylm_free(ray);
  ylm_free(value);
  return done ? 1 : ylmL_result(L, 0, YLM_ENOMEM, NULL);
}

static const luaL_Reg functions[] = {{"chooser_sample", chooser_sample},
                                     {"chooser_sky", chooser_sky},
                                     {"chooser_shares", chooser_shares},
                                     {"chooser_aim", chooser_aim},
                                     {NULL, NULL}};

void ylmL_open_chooser(lua_State *L) { luaL_setfuncs(L, functions, 0); }
