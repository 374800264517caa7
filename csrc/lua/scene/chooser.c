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
  for (int a = 0; a < 3; a++) x[a] = (float)numbers[a], n[a] = surface ? (float)numbers[3 + a] : 0;
  ylm_scene_chooser *c = ylm_scene_chooser_create(ylmL_scene(L, 1));
  *lit = c && ylm_scene_choose(c, x, surface ? n : NULL);
  return c;
}

/* chooser_sample(scene, point, normal | nil, u double [n][3]) -> double [n][8]: direction, density
   (0: no ray), radiance, lamp from 1 */
static int chooser_sample(lua_State *L) {
  const ylmL_array *u = ylmL_array_check(L, 4);
  if (u->dtype != YLM_DOUBLE || u->count % 3) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  size_t n = u->count / 3;
  ylmL_array *out = ylmL_array_new(L, YLM_DOUBLE, 2, (size_t[]){n, 8});
  bool lit;
  ylm_scene_chooser *c = out ? turned(L, &lit) : NULL;
  if (!c) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  double *to = out->data;
  for (size_t i = 0; i < n && lit; i++, to += 8) {
    ylm_trace_ray ray = {{0, 0, 0}, 0, {0, 0, 0}, 0, 0, {0}};
    float radiance[3] = {0, 0, 0};
    uint32_t lamp = 0;
    to[3] = ylm_scene_sample(c, (const double *)u->data + 3 * i, &ray, radiance, &lamp);
    for (int a = 0; a < 3; a++) to[a] = (double)ray.dir[a], to[4 + a] = (double)radiance[a];
    to[7] = lamp + 1.0;
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

static const luaL_Reg functions[] = {
    {"chooser_sample", chooser_sample}, {"chooser_sky", chooser_sky}, {NULL, NULL}};

void ylmL_open_chooser(lua_State *L) { luaL_setfuncs(L, functions, 0); }
