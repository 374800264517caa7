/* occlusion.c - ylm.occluder of meshes by rays. */
#include "../binding.h"

#include "ylm_geom.h"
#include "ylm_trace_occlusion.h"

static const ylm_field *field_of(const void *of) { return ylm_trace_occlusion_field(of); }

static void body_of(const void *of, double at[3], double *radius, double *area) {
  ylm_trace_occlusion_body(of, at, radius, area);
}

static ylm_status places_of(const void *of, double near, double far, size_t n, float *places,
                            ylm_error *e) {
  return ylm_trace_occlusion_places(of, near, far, 1, n, places, e);
}

static void free_occlusion(void *of) { ylm_trace_occlusion_free(of); }

static const ylmL_occluder_kind by_rays = {field_of, body_of, places_of, free_occlusion};

/* occlusion_create(mesh, rays) -> occluder */
static int occlusion_create(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  const ylm_mesh *m = ylmL_mesh_check(L, 1);
  int rays = (int)luaL_checknumber(L, 2);
  const float *position = ylmL_mesh_floats(L, m);
  ylmL_occluder *o = ylmL_occluder_push(L, &by_rays);
  ylm_trace_occlusion *of;
  ylm_status s =
      ylm_trace_occlusion_create(m->vertices, position, m->triangles, m->index, rays, &of, &e);
  o->of = of;
  if (s == YLM_OK) ylmL_charge(L, m->triangles * 150 + 10000);
  return ylmL_result(L, 1, s, &e);
}

/* occlusion_noise(occluder by rays, lmax, points: float [n][3], threads) -> the error of its values, as a part of the
   function 1 */
static int occlusion_noise(lua_State *L) {
  ylm_error e = {YLM_OK, ""};
  const ylmL_occluder *o = ylmL_check(L, 1, YLML_OCCLUDER);
  const ylmL_array *a = ylmL_array_check(L, 3);
  int lmax = (int)luaL_checknumber(L, 2), threads = (int)luaL_optnumber(L, 4, 0);
  double noise;
  if (!o->of) return ylmL_result(L, 0, YLM_ECLOSED, NULL);
  if (o->kind != &by_rays || a->dtype != YLM_FLOAT || a->count % 3)
    return luaL_argerror(L, 1, "a body by rays and float points [n][3] expected");
  ylm_status s = ylm_trace_occlusion_noise(o->of, lmax, a->count / 3, a->data, threads, &noise, &e);
  if (s == YLM_OK) lua_pushnumber(L, noise);
  return ylmL_result(L, 1, s, &e);
}

static const luaL_Reg functions[] = {
    {"occlusion_create", occlusion_create}, {"occlusion_noise", occlusion_noise}, {NULL, NULL}};

void ylmL_open_occlusion(lua_State *L) { luaL_setfuncs(L, functions, 0); }
