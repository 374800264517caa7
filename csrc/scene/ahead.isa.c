/* ahead.isa.c - few lamps weighed at many places, in double, once per instruction set. sphere.c and patch.c have the plain form, step
   by step the same: products and sums are not contracted (Makefile), so that all kernels have its bits. */
#include "ylm_simd.h"

#include "halves.h"
#include "scene.h"

YLM_INLINE ylm_vd dot(const ylm_vd a[3], const ylm_vd b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

YLM_INLINE ylm_vd most(ylm_vd a, ylm_vd b) { return ylm_vd_select(a > b, a, b); }

/* As ylm__scene_weight. */
YLM_INLINE ylm_vd sphere(const ylm_scene *s, size_t i, const ylm_vd x[3], const ylm_vd n[3]) {
  const ylm_vd zero = {0}, one = zero + 1;
  ylm_vd v[3], r = ylm_vd_set((double)s->lamp[3][i]), r2 = r * r;
  for (int a = 0; a < 3; a++) v[a] = ylm_vd_set((double)s->lamp[a][i]) - x[a];
  ylm_vd d2 = dot(v, v), cosine = dot(v, n) / ylm_vd_sqrt(d2), part = r2 / d2;
  ylm_vd root = ylm_vd_sqrt(part);
  ylm_vd cut = cosine * ylm_vd_sqrt(one - part) + ylm_vd_sqrt((one - cosine * cosine) * part);
  ylm_vd w = ylm_vd_select(cosine >= root, part * cosine, part * most(cut, zero));
  w = ylm_vd_select((cosine <= -root) & ~(cosine >= root), zero, w);
  return ylm_vd_select(d2 <= r2, ylm_vd_select(r > zero, one, zero), w);
}

/* As far_weight. */
YLM_INLINE ylm_vd far_triangle(const scene_far *f, const ylm_vd v[3], ylm_vd d2,
                               const ylm_vd n[3]) {
  const ylm_vd zero = {0};
  ylm_vd across[3], by = 1 / ylm_vd_sqrt(d2), least = ylm_vd_set(0.1 * f->area);
  for (int a = 0; a < 3; a++) across[a] = ylm_vd_set(f->across[a]);
  ylm_vd facing = dot(v, across);
  facing = (ylm_vd)((ylm_vl)facing & INT64_MAX) * by;
  ylm_vd part = most(facing, least) * by * by * (1 / YLM_PI), up = dot(v, n) * by;
  return ylm_vd_select(up > -2.0 / 3 / PATCH_FAR, part * most(up, zero + 0.2), zero);
}

/* As triangle_weight, but for the arc. */
YLM_INLINE void near_triangle(const float *corner, const ylm_vd x[3], const ylm_vd n[3],
                              ylm_vd arc[2], ylm_vd *weight) {
  const ylm_vd zero = {0}, one = zero + 1;
  ylm_vd v[3][3], a[3], b[3], across[3], r[3], d[3], highest = zero;
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) v[i][k] = ylm_vd_set((double)corner[3 * i + k]) - x[k];
  for (int k = 0; k < 3; k++) a[k] = v[1][k] - v[0][k], b[k] = v[2][k] - v[0][k];
  for (int k = 0; k < 3; k++)
    across[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
  for (int i = 0; i < 3; i++) r[i] = ylm_vd_sqrt(dot(v[i], v[i]));
  for (int i = 0; i < 3; i++) d[i] = dot(v[i], v[(i + 1) % 3]);
  arc[0] = dot(across, v[0]);
  arc[1] = r[0] * r[1] * r[2] + d[0] * r[2] + d[1] * r[0] + d[2] * r[1];
  for (int i = 0; i < 3; i++)
    highest = most(ylm_vd_select(r[i] > zero, dot(v[i], n) / r[i], one), highest);
  *weight = ylm_vd_select(highest > zero, most(highest, zero + 0.2), zero);
}

YLM_INLINE bool any(ylm_vl m) {
  int64_t all = 0;
  for (int i = 0; i < YLM_VD; i++) all |= m[i];
  return all != 0;
}

YLM_INLINE void triangle(const ylm_scene *s, size_t i, const ylm_vd x[3], const ylm_vd n[3],
                         scene_ahead *to, size_t at) {
  const ylm_vd zero = {0};
  const scene_far *f = &s->far[i];
  ylm_vd v[3], arc[2] = {zero, zero}, weight = zero;
  for (int k = 0; k < 3; k++) v[k] = ylm_vd_set(f->centre[k]) - x[k];
  ylm_vd d2 = dot(v, v);
  ylm_vl far = (d2 >= f->reach2) & (d2 > zero) & (ylm_vd_set(f->area) > zero);
  if (any(~far)) near_triangle(s->triangle + 9 * i, x, n, arc, &weight);
  weight = ylm_vd_select(far, far_triangle(f, v, d2, n), weight);
  ylm_vd_store(to->weight[s->lamps + i] + at, weight);
  ylm_vd_store(to->arc[0][i] + at, arc[0]);
  ylm_vd_store(to->arc[1][i] + at, arc[1]);
  ylm_vd_store(to->near[i] + at, ylm_vd_select(far, zero, zero + 1));
}

ylm_scene_ahead_fn YLM_KERNEL(ylm_k_scene_ahead);

void YLM_KERNEL(ylm_k_scene_ahead)(const ylm_scene *s, size_t n, scene_ahead *a) {
  for (size_t at = 0; at < n; at += YLM_VD) {
    ylm_vd x[3], normal[3];
    for (int k = 0; k < 3; k++) x[k] = widen(a->x[k] + at), normal[k] = widen(a->normal[k] + at);
    for (size_t i = 0; i < s->lamps; i++) ylm_vd_store(a->weight[i] + at, sphere(s, i, x, normal));
    for (size_t i = 0; i < s->triangles; i++) triangle(s, i, x, normal, a, at);
  }
}
