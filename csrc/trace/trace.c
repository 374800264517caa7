/* trace.c - Embree (Wald et al. 2014) behind ylm_trace.h: its trees, and rays through them. */
#include <math.h>
#include <string.h>

#include "trace.h"
#include "ylm_vector.h"

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

/* Denormals off; returns the mode to restore. */
static unsigned enter_fast_mode(void) {
#if defined(__SSE__)
  unsigned mode = _mm_getcsr();
  _mm_setcsr(mode | 0x8040u);
  return mode;
#else
  return 0;
#endif
}

static void leave_fast_mode(unsigned mode) {
#if defined(__SSE__)
  _mm_setcsr(mode);
#else
  (void)mode;
#endif
}

static ylm_status device_status(RTCDevice d, ylm_error *e) {
  switch (rtcGetDeviceError(d)) {
  case RTC_ERROR_NONE: return YLM_OK;
  case RTC_ERROR_OUT_OF_MEMORY: return YLM_ENOMEM;
  case RTC_ERROR_UNSUPPORTED_CPU:
    return ylm_fail(e, YLM_EDEVICE, "Embree does not support this processor");
  default: return ylm_fail(e, YLM_EDEVICE, "Embree could not build the scene");
  }
}

ylm_status ylm_trace_check(ylm_dtype t, size_t n, const void *x, const char *what, ylm_error *e) {
  size_t where;
  if (!ylm_all_finite(t, x, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "%s %zu is not finite", what, where / 3 + 1);
  for (size_t i = 0; i < 3 * n; i++)
    if (fabs(ylm_get(t, x, i)) > YLM_TRACE_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "%s %zu is beyond %g", what, i / 3 + 1, YLM_TRACE_EXTENT);
  return YLM_OK;
}

static ylm_status check_mesh(size_t i, const ylm_trace_mesh *m, ylm_error *e) {
  size_t where;
  if (m->vertices > UINT32_MAX || m->count > UINT32_MAX)
    return ylm_fail(e, YLM_EOVERFLOW, "mesh %zu has more than 2^32 elements", i + 1);
  if (!ylm_all_finite(YLM_FLOAT, m->positions, 3 * m->vertices, &where))
    return ylm_fail(e, YLM_EDOMAIN, "mesh %zu: vertex %zu is not finite", i + 1, where / 3 + 1);
  for (size_t k = 0; k < 3 * m->count; k++)
    if (m->triangles[k] >= m->vertices)
      return ylm_fail(e, YLM_EINVAL, "mesh %zu: triangle %zu names vertex %zu of %zu", i + 1,
                      k / 3 + 1, (size_t)m->triangles[k] + 1, m->vertices);
  return YLM_OK;
}

double ylm_trace_lift(const float *const p[3]) {
  double e[3][3], n[3], square[3], longest = 0;
  for (int i = 0; i < 3; i++)
    for (int a = 0; a < 3; a++) e[i][a] = (double)p[(i + 1) % 3][a] - (double)p[i][a];
  for (int i = 0; i < 3; i++) longest = fmax(longest, square[i] = ylm_dot3d(e[i], e[i]));
  ylm_cross3d(e[0], e[1], n);
  double edge = sqrt(longest),
         round = sqrt(square[0] * square[1] * square[2] / ylm_dot3d(n, n)) / 2;
  return 0x1p-22 * (edge + fmin(round, 32 * edge));
}

/* Twice the largest lift of the mesh's triangles, or `rounding`. */
static float largest_lift(const ylm_trace_mesh *m, float rounding) {
  for (size_t i = 0; m->occludes && i < m->count; i++) {
    const uint32_t *k = m->triangles + 3 * i;
    const float *p[3];
    for (int c = 0; c < 3; c++) p[c] = m->positions + 3 * (size_t)k[c];
    rounding = fmaxf(rounding, (float)(2 * ylm_trace_lift(p)));
  }
  return rounding;
}

static void grow_bounds(ylm_trace *t, bool *any, const ylm_trace_mesh *m) {
  for (size_t k = 0; k < m->vertices; k++, *any = true)
    for (int a = 0; a < 3; a++) {
      float x = m->positions[3 * k + a];
      t->lo[a] = *any && t->lo[a] < x ? t->lo[a] : x;
      t->hi[a] = *any && t->hi[a] > x ? t->hi[a] : x;
    }
}

/* Attaches `g` under `id` to a scene; gives up this file's reference. */
static void attach(RTCScene s, RTCGeometry g, uint32_t id) {
  rtcCommitGeometry(g);
  rtcAttachGeometryByID(s, g, id);
  rtcReleaseGeometry(g);
}

static ylm_status add_mesh(ylm_trace *t, uint32_t id, const ylm_trace_mesh *m, ylm_error *e) {
  if (m->count == 0) return YLM_OK;
  RTCGeometry g = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float *p =
      g ? rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, m->vertices)
        : NULL;
  uint32_t *k =
      p ? rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, m->count)
        : NULL;
  if (!k) {
    if (g) rtcReleaseGeometry(g);
    ylm_status s = device_status(t->device, e);
    return s == YLM_OK ? YLM_ENOMEM : s;
  }
  memcpy(p, m->positions, m->vertices * 12);
  memcpy(k, m->triangles, m->count * 12);
  if (!m->occludes) t->draws = true;
  attach(m->occludes ? t->occluders : t->drawn, g, id);
  return YLM_OK;
}

/* A buffer of `n` elements of `width` floats, copied to slot 0 of its kind; false: no memory. */
static bool fill(RTCGeometry g, enum RTCBufferType type, enum RTCFormat format, size_t n,
                 size_t width, const float *from, size_t step) {
  float *p = rtcSetNewGeometryBuffer(g, type, 0, format, 4 * width, n);
  for (size_t i = 0; p && i < n; i++) memcpy(p + i * width, from + i * step, 4 * width);
  return p != NULL;
}

/* Takes the geometry over, or says why it could not be made. */
static ylm_status finish_lamps(ylm_trace *t, RTCGeometry g, bool filled, uint32_t id,
                               ylm_error *e) {
  if (g && filled) {
    attach(t->lamps, g, id);
    return YLM_OK;
  }
  if (g) rtcReleaseGeometry(g);
  ylm_status s = device_status(t->device, e);
  return s == YLM_OK ? YLM_ENOMEM : s;
}

static ylm_status add_spheres(ylm_trace *t, const ylm_trace_lamps *l, ylm_error *e) {
  if (!l->spheres) return YLM_OK;
  RTCGeometry g = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
  bool ok = g && fill(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, l->spheres, 4, l->sphere, 4);
  if (ok) t->sphere = rtcGetGeometryBufferData(g, RTC_BUFFER_TYPE_VERTEX, 0);
  for (size_t i = 0; i < l->spheres; i++) {
    const double x = l->sphere[4 * i], y = l->sphere[4 * i + 1], z = l->sphere[4 * i + 2];
    t->largest = fmax(t->largest, (double)l->sphere[4 * i + 3]);
    t->reach = fmax(t->reach, sqrt(x * x + y * y + z * z) + (double)l->sphere[4 * i + 3]);
  }
  return finish_lamps(t, g, ok, t->meshes, e);
}

static ylm_status add_triangles(ylm_trace *t, const ylm_trace_lamps *l, ylm_error *e) {
  size_t n = l->triangles;
  if (!n) return YLM_OK;
  RTCGeometry g = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  bool ok = g && fill(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * n, 3, l->triangle, 3);
  uint32_t *k =
      ok ? rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, n) : NULL;
  for (size_t i = 0; k && i < 3 * n; i++) k[i] = (uint32_t)i;
  return finish_lamps(t, g, k != NULL, t->meshes + 1, e);
}

static ylm_status add_disks(ylm_trace *t, const ylm_trace_lamps *l, ylm_error *e) {
  size_t n = l->disks;
  if (!n) return YLM_OK;
  RTCGeometry g = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
  bool ok = g && fill(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, n, 4, l->disk, 7) &&
            fill(g, RTC_BUFFER_TYPE_NORMAL, RTC_FORMAT_FLOAT3, n, 3, l->disk + 4, 7);
  return finish_lamps(t, g, ok, t->meshes + 2, e);
}

static ylm_status add_lamps(ylm_trace *t, const ylm_trace_lamps *l, ylm_error *e) {
  size_t where;
  if (l->spheres > UINT32_MAX / 4 || l->triangles > UINT32_MAX / 4 || l->disks > UINT32_MAX / 4)
    return ylm_fail(e, YLM_EOVERFLOW, "more than 2^30 lamps");
  for (size_t i = 0; i < 4 * l->spheres; i++)
    if (!isfinite(l->sphere[i]) || (i % 4 == 3 && l->sphere[i] < 0))
      return ylm_fail(e, YLM_EDOMAIN, "lamp %zu has no finite place or radius", i / 4 + 1);
  if (!ylm_all_finite(YLM_FLOAT, l->triangle, 9 * l->triangles, &where) ||
      !ylm_all_finite(YLM_FLOAT, l->disk, 7 * l->disks, &where))
    return ylm_fail(e, YLM_EDOMAIN, "a flat lamp is not finite");
  t->spheres = (uint32_t)l->spheres;
  t->triangles = (uint32_t)l->triangles;
  ylm_status s = add_spheres(t, l, e);
  if (s == YLM_OK) s = add_triangles(t, l, e);
  return s == YLM_OK ? add_disks(t, l, e) : s;
}

static RTCScene new_scene(RTCDevice d, enum RTCSceneFlags flags) {
  RTCScene s = rtcNewScene(d);
  if (s) rtcSetSceneFlags(s, RTC_SCENE_FLAG_ROBUST | flags);
  return s;
}

/* The tree of lamps. */
static ylm_status build_lamps(ylm_trace *t, const ylm_trace_lamps *lamps, ylm_error *e) {
  t->lamps = new_scene(t->device, ylm__trace_filters);
  if (!t->lamps) return device_status(t->device, e);
  ylm_status s = add_lamps(t, lamps, e);
  if (s != YLM_OK) return s;
  ylm__trace_enclose(t, lamps);
  rtcCommitScene(t->lamps);
  return device_status(t->device, e);
}

/* The trees of meshes. */
static ylm_status build_meshes(ylm_trace *t, size_t mesh_count, const ylm_trace_mesh *meshes,
                               ylm_error *e) {
  bool any = false;
  if (mesh_count > INT32_MAX - 3) return ylm_fail(e, YLM_EOVERFLOW, "more than 2^31 meshes");
  t->meshes = (uint32_t)mesh_count;
  t->device = rtcNewDevice("threads=1,set_affinity=0");
  if (!t->device) return device_status(NULL, e);
  t->occluders = new_scene(t->device, RTC_SCENE_FLAG_NONE);
  t->drawn = new_scene(t->device, RTC_SCENE_FLAG_NONE);
  if (!t->occluders || !t->drawn) return device_status(t->device, e);
  for (size_t i = 0; i < mesh_count; i++) {
    ylm_status s = check_mesh(i, &meshes[i], e);
    if (s == YLM_OK) s = add_mesh(t, (uint32_t)i, &meshes[i], e);
    if (s != YLM_OK) return s;
    grow_bounds(t, &any, &meshes[i]);
    t->rounding = largest_lift(&meshes[i], t->rounding);
  }
  rtcCommitScene(t->occluders);
  rtcCommitScene(t->drawn);
  return device_status(t->device, e);
}

ylm_status ylm_trace_create(size_t mesh_count, const ylm_trace_mesh *meshes,
                            const ylm_trace_lamps *lamps, ylm_trace **out, ylm_error *e) {
  *out = NULL;
  ylm_trace *t = ylm_alloc_zero(1, sizeof *t);
  if (!t) return YLM_ENOMEM;
  unsigned mode = enter_fast_mode();
  ylm_status s = build_meshes(t, mesh_count, meshes, e);
  if (s == YLM_OK) s = build_lamps(t, lamps, e);
  leave_fast_mode(mode);
  if (s == YLM_OK)
    *out = t;
  else
    ylm_trace_free(t);
  return s;
}

/* Shares everything but lamps. */
static void share_meshes(ylm_trace *t, const ylm_trace *from) {
  t->device = from->device;
  t->occluders = from->occluders;
  t->drawn = from->drawn;
  t->draws = from->draws;
  t->meshes = from->meshes;
  t->rounding = from->rounding;
  memcpy(t->lo, from->lo, sizeof t->lo);
  memcpy(t->hi, from->hi, sizeof t->hi);
  rtcRetainDevice(t->device);
  rtcRetainScene(t->occluders);
  rtcRetainScene(t->drawn);
}

ylm_status ylm_trace_relight(const ylm_trace *from, const ylm_trace_lamps *lamps, ylm_trace **out,
                             ylm_error *e) {
  *out = NULL;
  ylm_trace *t = ylm_alloc_zero(1, sizeof *t);
  if (!t) return YLM_ENOMEM;
  share_meshes(t, from);
  unsigned mode = enter_fast_mode();
  ylm_status s = build_lamps(t, lamps, e);
  leave_fast_mode(mode);
  if (s == YLM_OK)
    *out = t;
  else
    ylm_trace_free(t);
  return s;
}

void ylm_trace_free(ylm_trace *t) {
  if (!t) return;
  if (t->occluders) rtcReleaseScene(t->occluders);
  if (t->drawn) rtcReleaseScene(t->drawn);
  if (t->lamps) rtcReleaseScene(t->lamps);
  if (t->device) rtcReleaseDevice(t->device);
  ylm_free(t);
}

void ylm_trace_bounds(const ylm_trace *t, float lo[3], float hi[3]) {
  memcpy(lo, t->lo, sizeof t->lo);
  memcpy(hi, t->hi, sizeof t->hi);
}

float ylm_trace_offset(const ylm_trace *t, const float x[3]) {
  return t->rounding + 0x1p-21f * (fabsf(x[0]) + fabsf(x[1]) + fabsf(x[2]));
}

void ylm_trace_intersect(const ylm_trace *t, size_t n, const ylm_trace_ray *rays, bool coherent,
                         ylm_trace_hit *hits) {
  const RTCScene all[3] = {t->occluders, t->lamps, t->drawn};
  unsigned mode = enter_fast_mode();
  ylm__trace_first(t, t->draws ? 3 : 2, all, n, rays, coherent, hits);
  leave_fast_mode(mode);
}

void ylm_trace_nearest(const ylm_trace *t, size_t n, const ylm_trace_ray *rays, bool coherent,
                       ylm_trace_hit *hits) {
  unsigned mode = enter_fast_mode();
  ylm__trace_first(t, 1, &t->occluders, n, rays, coherent, hits);
  leave_fast_mode(mode);
}

void ylm_trace_occluded(const ylm_trace *t, size_t n, ylm_trace_ray *rays) {
  unsigned mode = enter_fast_mode();
  ylm__trace_any(t, t->occluders, n, rays);
  leave_fast_mode(mode);
}

void ylm_trace_meets_lamps(const ylm_trace *t, size_t n, ylm_trace_ray *rays) {
  unsigned mode = enter_fast_mode();
  if (t->balls > 0)
    ylm__trace_look(t, n, rays);
  else
    ylm__trace_any(t, t->lamps, n, rays);
  leave_fast_mode(mode);
}

size_t ylm_trace_next_lamps(const ylm_trace *t, const ylm_trace_ray *ray,
                            const ylm_trace_meeting *after, size_t n, ylm_trace_meeting *met) {
  unsigned mode = enter_fast_mode();
  size_t count = ylm__trace_gather(t, ray, after, n, met);
  leave_fast_mode(mode);
  return count;
}
