/* surface.isa.c - surfaces at places, several at a time, once per instruction set. scene.c has the plain form, step by step the
   same: products and sums are not contracted (Makefile), so that all kernels have its bits. */
#include "ylm_simd.h"

#include "halves.h"
#include "scene.h"

_Static_assert(SCENE_LANES % YLM_VF == 0, "vectors fill a block");

enum { HALF = YLM_VD }; /* floats of half a vector */

YLM_INLINE void store_half(ylm_vd x, float *p) {
  half h = __builtin_convertvector(x, half);
  memcpy(p, &h, sizeof h);
}

YLM_INLINE ylm_vf dot(const ylm_vf a[3], const ylm_vf b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

YLM_INLINE void normalise(ylm_vf v[3]) {
  const ylm_vf zero = {0};
  ylm_vf d = ylm_vf_sqrt(dot(v, v));
  ylm_vi some = d > zero;
  ylm_vf by = ylm_vf_select(some, d, zero + 1);
  for (int a = 0; a < 3; a++) v[a] = ylm_vf_select(some, v[a] / by, a == 2 ? zero + 1 : zero);
}

YLM_INLINE void flat_of(const scene_lanes *s, size_t i, ylm_vf edge[2][3], ylm_vf flat[3]) {
  for (int k = 0; k < 2; k++)
    for (int a = 0; a < 3; a++)
      edge[k][a] = ylm_vf_load(s->p[k + 1][a] + i) - ylm_vf_load(s->p[0][a] + i);
  const ylm_vf *a = edge[0], *b = edge[1], side = ylm_vf_load(s->side + i);
  flat[0] = side * (a[1] * b[2] - a[2] * b[1]);
  flat[1] = side * (a[2] * b[0] - a[0] * b[2]);
  flat[2] = side * (a[0] * b[1] - a[1] * b[0]);
  normalise(flat);
}

/* The interpolated normal, and the way to the surface that the corners' normals describe. */
YLM_INLINE void smooth(const scene_lanes *s, size_t i, const ylm_vf edge[2][3],
                       const ylm_vf flat[3], ylm_vf normal[3], ylm_vf way[3]) {
  const ylm_vf zero = {0}, one = zero + 1;
  ylm_vf u = ylm_vf_load(s->u + i), v = ylm_vf_load(s->v + i), w[3] = {one - u - v, u, v};
  ylm_vf n[3][3], mean[3];
  for (int k = 0; k < 3; k++)
    for (int a = 0; a < 3; a++) n[k][a] = ylm_vf_load(s->n[k][a] + i);
  for (int a = 0; a < 3; a++) mean[a] = w[0] * n[0][a] + w[1] * n[1][a] + w[2] * n[2][a];
  ylm_vf turn = ylm_vf_select(dot(mean, flat) < zero, -one, one);
  ylm_vi some = dot(mean, mean) > zero;
  for (int a = 0; a < 3; a++) normal[a] = mean[a] * turn, way[a] = zero;
  normalise(normal);
  for (int a = 0; a < 3; a++) normal[a] = ylm_vf_select(some, normal[a], flat[a]);
  for (int k = 0; k < 3; k++) {
    ylm_vf below = zero, x = u - (k == 1 ? one : zero), y = v - (k == 2 ? one : zero);
    for (int a = 0; a < 3; a++) below += (x * edge[0][a] + y * edge[1][a]) * n[k][a] * turn;
    ylm_vi lies = some & (below < zero);
    for (int a = 0; a < 3; a++)
      way[a] = ylm_vf_select(lies, way[a] - w[k] * below * n[k][a] * turn, way[a]);
  }
}

/* As ylm_scene_basis. */
YLM_INLINE void any_tangent(const ylm_vf n[3], ylm_vf out[3]) {
  const ylm_vf zero = {0}, one = zero + 1;
  ylm_vf s = ylm_vf_select((ylm_vi)n[2] < 0, -one, one), p = -one / (s + n[2]), q = n[0] * n[1] * p;
  out[0] = one + s * n[0] * n[0] * p;
  out[1] = s * q;
  out[2] = -s * n[0];
}

/* As find_tangent: without texture coordinates these are 0, and any tangent is found. */
YLM_INLINE void tangent_of(const scene_lanes *s, size_t i, const ylm_vf edge[2][3],
                           const ylm_vf n[3], ylm_vf out[3]) {
  const ylm_vf zero = {0}, one = zero + 1;
  ylm_vf uv[2][2], d[3], any[3];
  for (int k = 0; k < 2; k++)
    for (int a = 0; a < 2; a++)
      uv[k][a] = ylm_vf_load(s->uv[k + 1][a] + i) - ylm_vf_load(s->uv[0][a] + i);
  ylm_vf area = uv[0][0] * uv[1][1] - uv[1][0] * uv[0][1];
  ylm_vf side = ylm_vf_select(area < zero, -one, one);
  for (int a = 0; a < 3; a++) d[a] = side * (uv[1][1] * edge[0][a] - uv[0][1] * edge[1][a]);
  ylm_vf along = dot(d, n);
  for (int a = 0; a < 3; a++) d[a] = d[a] - along * n[a];
  ylm_vf length = ylm_vf_sqrt(dot(d, d));
  ylm_vi some = length > zero;
  ylm_vf by = ylm_vf_select(some, length, one);
  any_tangent(n, any);
  for (int a = 0; a < 3; a++) out[a] = ylm_vf_select(some, d[a] / by, any[a]);
}

YLM_INLINE ylm_vd place_of(const scene_lanes *s, int a, size_t i, ylm_vd u, ylm_vd v) {
  ylm_vd p = widen(s->p[0][a] + i);
  return p + u * (widen(s->p[1][a] + i) - p) + v * (widen(s->p[2][a] + i) - p);
}

/* As ylm_away. */
YLM_INLINE ylm_vd away(ylm_vd x, ylm_vd n) {
  const ylm_vd zero = {0}, one = zero + 1;
  ylm_vd side = ylm_vd_select(n > zero, one, ylm_vd_select(n < zero, -one, zero));
  ylm_vd size = (ylm_vd)((ylm_vl)x & INT64_MAX);
  return x + size * 0x1p-24 * side;
}

/* The place and where rays start, in double: of half a vector. */
YLM_INLINE void places(scene_lanes *s, size_t i) {
  ylm_vd u = widen(s->u + i), v = widen(s->v + i);
  ylm_vd from_u = widen(s->from[0] + i), from_v = widen(s->from[1] + i);
  for (int a = 0; a < 3; a++) {
    ylm_vd at = place_of(s, a, i, u, v), from = place_of(s, a, i, from_u, from_v);
    store_half(at, s->position[a] + i);
    store_half(at + widen(s->way[a] + i), s->lit[a] + i);
    store_half(away(from + widen(s->origin[a] + i), widen(s->flat[a] + i)), s->origin[a] + i);
  }
}

ylm_scene_lanes_fn YLM_KERNEL(ylm_k_scene_lanes);

void YLM_KERNEL(ylm_k_scene_lanes)(size_t n, scene_lanes *s) {
  const ylm_vf one = ylm_vf_set(1);
  for (size_t i = 0; i < n; i += YLM_VF) {
    ylm_vf edge[2][3], flat[3], normal[3], way[3], tangent[3];
    flat_of(s, i, edge, flat);
    smooth(s, i, (const ylm_vf(*)[3])edge, flat, normal, way);
    tangent_of(s, i, (const ylm_vf(*)[3])edge, normal, tangent);
    ylm_vf u = ylm_vf_load(s->u + i), v = ylm_vf_load(s->v + i), pull = ylm_vf_load(s->pull + i);
    ylm_vf lift = ylm_vf_load(s->lift + i), third = ylm_vf_set(1.f / 3);
    ylm_vi edged = (u < pull) | (v < pull) | (one - u - v < pull);
    ylm_vf_store(s->from[0] + i, ylm_vf_select(edged, u + pull * (third - u), u));
    ylm_vf_store(s->from[1] + i, ylm_vf_select(edged, v + pull * (third - v), v));
    for (int a = 0; a < 3; a++) {
      ylm_vf_store(s->flat[a] + i, flat[a]), ylm_vf_store(s->normal[a] + i, normal[a]);
      ylm_vf_store(s->way[a] + i, way[a]), ylm_vf_store(s->tangent[a] + i, tangent[a]);
      ylm_vf_store(s->origin[a] + i, way[a] + lift * flat[a]);
    }
    for (size_t k = i; k < i + YLM_VF; k += HALF) places(s, k);
  }
}
