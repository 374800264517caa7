/* places.c - random places on surfaces, by area. */
#include <math.h>

#include "surface.h"

bool ylm__surface_is_lit(const ylm_transfer *t, const ylm_scene_place *p) {
  return !ylm_scene_occludes(ylm_transfer_scene(t), p->mesh) ||
         ylm_transfer_element(t, p) < ylm_transfer_count(t);
}

double *ylm__surface_areas(const surface_charts *c, const ylm_transfer *transfer) {
  const ylm_scene *scene = c->scene;
  size_t meshes = ylm_scene_meshes(scene), n = c->first[meshes],
         vertices = ylm_scene_vertices(scene, NULL);
  double *sum = ylm_alloc(n + 1, sizeof *sum);
  float *x = ylm_alloc(vertices, 3 * sizeof *x);
  if (sum && x) {
    ylm_scene_vertices(scene, x);
    const float *corner[3];
    double normal[3];
    sum[0] = 0;
    for (size_t m = 0; m < meshes; m++) {
      const float *p = x + 3 * ylm_scene_first_vertex(scene, m);
      for (size_t i = 0; i < ylm_scene_triangles(scene, m); i++) {
        const uint32_t *t = ylm_scene_triangle(scene, m, i);
        sum[c->first[m] + i + 1] =
            sum[c->first[m] + i] +
            ylm__surface_triangle(p, t, corner, normal) * ylm_transfer_ground_share(transfer, m, i);
      }
    }
  } else {
    ylm_free(sum);
    sum = NULL;
  }
  ylm_free(x);
  return sum;
}

ylm_scene_place ylm__surface_random(const surface_charts *c, const double *sum, ylm_rng *rng) {
  size_t meshes = ylm_scene_meshes(c->scene), lo = 0, hi = c->first[meshes], m = 0, top = meshes;
  double t = ylm_rng_double(rng) * sum[hi], u = ylm_rng_double(rng), v = ylm_rng_double(rng);
  bool back = ylm_rng_u32(rng) >> 31;
  while (hi - lo > 1) {
    size_t mid = (lo + hi) / 2;
    if (sum[mid] <= t)
      lo = mid;
    else
      hi = mid;
  }
  while (top - m > 1) {
    size_t mid = (m + top) / 2;
    if (c->first[mid] <= lo)
      m = mid;
    else
      top = mid;
  }
  while (c->first[m + 1] <= lo) m++;
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return (ylm_scene_place){(uint32_t)m, (uint32_t)(lo - c->first[m]), (float)u, (float)v, back};
}

/* -- places that a promise is about ----------------------------------------------------------- */

bool ylm__surface_is_covered(const surface_charts *c, double unit, const ylm_scene_surface *at) {
  ylm_trace_ray ray = {.far = 1};
  for (int a = 0; a < 3; a++) {
    ray.org[a] = at->origin[a];
    ray.dir[a] = (float)(COVERED * unit) * at->flat[a];
  }
  ylm_trace_occluded(ylm_scene_trace(c->scene), 1, &ray);
  return ray.far < 0;
}

/* Draws n places on sides that have light; how many there are. */
static size_t draw(const surface_charts *c, const ylm_transfer *t, const double *sum, size_t n,
                   ylm_rng *rng, ylm_scene_place *place) {
  size_t drawn = 0;
  double unit = sqrt(sum[c->first[ylm_scene_meshes(c->scene)]]);
  for (size_t tries = 0; c->area > 0 && drawn < n && tries < 64 * n; tries++) {
    ylm_scene_place p = ylm__surface_random(c, sum, rng);
    ylm_scene_surface at;
    if (!ylm__surface_is_lit(t, &p)) continue;
    ylm_scene_surfaces(c->scene, 1, &p, &at);
    if (!ylm__surface_is_covered(c, unit, &at)) place[drawn++] = p;
  }
  return drawn;
}

/* Leaves out places in bodies; how many stay. */
static ylm_status keep_open(const ylm_radiosity *r, size_t n, ylm_scene_place *place,
                            size_t *kept) {
  uint64_t *stream = ylm_alloc(n, sizeof *stream);
  float(*E)[3] = ylm_alloc(n, sizeof *E), *share = ylm_alloc(n, sizeof *share);
  ylm_radiosity_map m = {.links = 64, .seed = 1};
  ylm_status s = stream && E && share ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) stream[i] = i;
  if (s == YLM_OK) s = ylm_radiosity_places(r, &m, n, place, stream, E, share, NULL);
  *kept = 0;
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    if (share[i] >= 0.5f) place[(*kept)++] = place[i];
  ylm_free(stream);
  ylm_free(E);
  ylm_free(share);
  return s;
}

ylm_status ylm__surface_draw(const surface_charts *c, const ylm_radiosity *r, size_t n,
                             uint64_t seed, ylm_scene_place *place, size_t *drawn) {
  double *sum = ylm__surface_areas(c, ylm_radiosity_transfer(r));
  ylm_status s = sum ? YLM_OK : YLM_ENOMEM;
  ylm_rng rng;
  ylm_rng_seed(&rng, seed, 0x10d6e);
  *drawn = 0;
  for (int tries = 0; s == YLM_OK && tries < 8 && *drawn < n; tries++) {
    size_t kept = draw(c, ylm_radiosity_transfer(r), sum, n - *drawn, &rng, place + *drawn);
    s = keep_open(r, kept, place + *drawn, &kept);
    *drawn += kept;
  }
  ylm_free(sum);
  return s;
}

ylm_status ylm_surface_draw(const ylm_surface_grid *g, const ylm_radiosity *r, size_t n,
                            uint64_t seed, ylm_scene_place *place, size_t *drawn) {
  return ylm__surface_draw(&g->charts, r, n, seed, place, drawn);
}
