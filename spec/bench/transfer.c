/*
** transfer.c - transfer vectors: rays and vectors a second beside what Embree alone does with rays
** of the same kind in the same scene, and the bytes of a shading point.
*/
#if YLM_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <math.h>

#include "bench.h"
#include "ylm_geom.h"
#include "ylm_material.h"
#include "ylm_shade.h"
#include "ylm_trace.h"

#define RAYS (1 << 16)

typedef struct job {
  RTCScene raw;
  const ylm_trace *trace;
  ylm_trace_ray *ray, *copy;
} job;

/* Embree by itself, one ray at a time. */
static void raw_rays(void *context) {
  job *j = context;
  for (size_t i = 0; i < RAYS; i++) {
    struct RTCRay r = {0};
    r.org_x = j->ray[i].org[0], r.org_y = j->ray[i].org[1], r.org_z = j->ray[i].org[2];
    r.dir_x = j->ray[i].dir[0], r.dir_y = j->ray[i].dir[1], r.dir_z = j->ray[i].dir[2];
    r.tnear = j->ray[i].near, r.tfar = j->ray[i].far, r.mask = ~0u;
#if YLM_EMBREE == 4
    rtcOccluded1(j->raw, &r, NULL);
#else
    struct RTCIntersectContext c;
    rtcInitIntersectContext(&c);
    rtcOccluded1(j->raw, &c, &r);
#endif
  }
}

/* All rays through csrc/trace. */
static void our_rays(void *context) {
  job *j = context;
  memcpy(j->copy, j->ray, RAYS * sizeof *j->copy);
  for (size_t i = 0; i < RAYS; i += 256) ylm_trace_occluded(j->trace, 256, j->copy + i);
}

/* Rays from random points on the knot's mesh, cosine about the normal. */
static void make_rays(job *j, const ylm_mesh *m) {
  ylm_rng r;
  ylm_rng_seed(&r, 3, 3);
  for (size_t i = 0; i < RAYS; i++) {
    /* 256 rays from one point, as a transfer vector has them */
    size_t v = i / 256 * 7919 % m->vertices;
    const float *n = m->normal + 3 * v;
    double z = 2 * ylm_rng_double(&r) - 1, phi = 6.28318531 * ylm_rng_double(&r), d2 = 0;
    double s = sqrt(1 - z * z), d[3] = {s * cos(phi), s * sin(phi), z};
    for (int a = 0; a < 3; a++) d[a] += (double)n[a], d2 += d[a] * d[a];
    for (int a = 0; a < 3; a++) {
      j->ray[i].dir[a] = (float)(d[a] / sqrt(d2));
      j->ray[i].org[a] = m->position[3 * v + (size_t)a] + 1e-4f * n[a];
    }
    j->ray[i].near = 0, j->ray[i].far = INFINITY;
  }
}

static RTCScene raw_scene(RTCDevice device, const ylm_mesh *m) {
  RTCScene scene = rtcNewScene(device);
  RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void *p =
      rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, m->vertices);
  void *t =
      rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, m->triangles);
  memcpy(p, m->position, m->vertices * 12);
  memcpy(t, m->index, m->triangles * 12);
  rtcCommitGeometry(g);
  rtcAttachGeometry(scene, g);
  rtcReleaseGeometry(g);
  rtcCommitScene(scene);
  return scene;
}

/* Transfer vectors of what a camera sees, by a number of threads. */
static void vectors(const ylm_scene *scene, int threads, double limit) {
  ylm_camera camera = {.from = {0, -9, 3}, .at = {0, 0, 0}, .up = {0, 0, 1}, .fov = 40};
  ylm_shade_options o = {.width = bench_is_quick() ? 80 : 240,
                         .height = bench_is_quick() ? 60 : 180,
                         .samples = 4,
                         .lmax = 4,
                         .visibility = YLM_SHADE_PIXEL,
                         .transfer_samples = 256,
                         .occlusion_distance = INFINITY,
                         .share = 1,
                         .threads = threads};
  ylm_shade_stats best = {.transfer_seconds = 1e30};
  for (int i = 0; i < 3; i++) {
    ylm_shade_view *v = NULL;
    if (ylm_shade_view_create(scene, &camera, &o, &v, NULL) != YLM_OK) return;
    ylm_shade_stats s;
    ylm_shade_view_stats(v, &s);
    if (s.transfer_seconds < best.transfer_seconds) best = s;
    ylm_shade_view_free(v);
  }
  double rays = (double)best.occlusion_rays / best.transfer_seconds * 1e-6;
  printf(
      "  transfer vectors, %d thread%s %7.2f M rays/s (%.0f %% of Embree's rate), %7.1f thousand "
      "vectors/s\n",
      threads, threads > 1 ? "s" : " ", rays, 100 * rays / limit / threads,
      (double)best.points / best.transfer_seconds * 1e-3);
  if (threads == 1)
    printf("  %zu shading points: %.0f bytes each\n", best.points,
           (double)best.bytes / (double)best.points);
}

int main(void) {
  ylm_mesh *m = NULL;
  job j = {.ray = ylm_alloc(RAYS, sizeof *j.ray), .copy = ylm_alloc(RAYS, sizeof *j.copy)};
  if (ylm_mesh_knot(2, 3, 2, 0.8, 0.35, 600, 100, &m, NULL) != YLM_OK || !j.ray || !j.copy)
    return 1;
  ylm_material *grey = NULL;
  if (ylm_material_create(0, 3, (float[]){0.7f, 0.7f, 0.7f}, &grey, NULL) != YLM_OK) return 1;
  ylm_scene_mesh mesh = {.positions = m->position,
                         .normals = m->normal,
                         .vertices = m->vertices,
                         .triangles = m->index,
                         .count = m->triangles,
                         .material = grey,
                         .occludes = true};
  ylm_scene_lamps none = {0};
  ylm_scene *scene = NULL;
  if (ylm_scene_create(1, &mesh, &none, &scene, NULL) != YLM_OK) return 1;
  RTCDevice device = rtcNewDevice("threads=1");
  j.raw = raw_scene(device, m);
  j.trace = ylm_scene_trace(scene);
  make_rays(&j, m);
  double raw = RAYS / bench_seconds(raw_rays, &j) * 1e-6;
  double ours = RAYS / bench_seconds(our_rays, &j) * 1e-6;
  printf("occlusion: a knot of %zu triangles, 256 rays from a point, cosine about its normal\n",
         m->triangles);
  printf("  Embree's rtcOccluded1 in a loop %7.2f M rays/s, csrc/trace %7.2f; one thread\n", raw,
         ours);
  vectors(scene, 1, raw);
  if (ylm_threads(0) > 1) vectors(scene, ylm_threads(0), raw);
  ylm_scene_free(scene);
  ylm_material_free(grey);
  rtcReleaseScene(j.raw);
  rtcReleaseDevice(device);
  ylm_mesh_free(m);
  ylm_free(j.ray), ylm_free(j.copy);
  return 0;
}
