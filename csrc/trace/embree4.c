/* embree4.c - rays through Embree 4: packets as wide as the processor's vectors. */
#include <stddef.h>

#include "calibration.h"
#include "trace.h"

const enum RTCSceneFlags ylm__trace_filters = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

/* A packet of w rays: number i of field f is x[f*w + i]. */
typedef union number {
  float f;
  uint32_t u;
} number;
typedef struct packet {
  _Alignas(64) int valid[16];
  _Alignas(64) number x[sizeof(struct RTCRayHit16) / sizeof(number)];
} packet;

#define FIELD(name) (offsetof(struct RTCRayHit16, name) / sizeof(number[16]))

/* How many rays the processor's vectors hold; 1 if Embree would take packets apart. */
static unsigned width_of(RTCDevice d) {
  if (rtcGetDeviceProperty(d, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
  if (rtcGetDeviceProperty(d, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) return 8;
  return rtcGetDeviceProperty(d, RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED) ? 4 : 1;
}

/* The rays of a block, those of one octant one after the other: they run alike. */
static void sort_rays(const ylm_trace_ray *rays, unsigned n, uint8_t order[TRACE_STREAM]) {
  unsigned first[9] = {0};
  uint8_t octant[TRACE_STREAM];
  for (unsigned i = 0; i < n; i++) {
    const float *d = rays[i].dir;
    octant[i] = (uint8_t)((d[0] < 0) | (d[1] < 0) << 1 | (d[2] < 0) << 2);
    first[octant[i] + 1]++;
  }
  for (int o = 0; o < 8; o++) first[o + 1] += first[o];
  for (unsigned i = 0; i < n; i++) order[first[octant[i]]++] = (uint8_t)i;
}

/* Puts the rays of the order's places `from` and following into a packet; returns how many. */
static unsigned load(packet *p, unsigned w, const ylm_trace_ray *rays, const uint8_t *order,
                     unsigned from, unsigned n) {
  number *x = p->x;
  unsigned count = n - from < w ? n - from : w;
  for (unsigned i = 0; i < w; i++) {
    const ylm_trace_ray *r = &rays[order[i < count ? from + i : from]];
    p->valid[i] = i < count ? -1 : 0;
    for (unsigned a = 0; a < 3; a++) {
      x[(FIELD(ray.org_x) + a) * w + i].f = r->org[a];
      x[(FIELD(ray.dir_x) + a) * w + i].f = r->dir[a];
    }
    x[FIELD(ray.tnear) * w + i].f = r->near;
    x[FIELD(ray.tfar) * w + i].f = r->far;
    x[FIELD(ray.time) * w + i].f = 0;
    x[FIELD(ray.mask) * w + i].u = UINT32_MAX;
    x[FIELD(ray.id) * w + i].u = 0;
    x[FIELD(ray.flags) * w + i].u = 0;
  }
  return count;
}

static void intersect(packet *p, unsigned w, RTCScene scene, struct RTCIntersectArguments *a) {
  void *x = p->x;
  switch (w) {
  case 16: rtcIntersect16(p->valid, scene, x, a); break;
  case 8: rtcIntersect8(p->valid, scene, x, a); break;
  case 4: rtcIntersect4(p->valid, scene, x, a); break;
  default: rtcIntersect1(scene, x, a);
  }
}

static void occlude(packet *p, unsigned w, RTCScene scene, struct RTCOccludedArguments *a) {
  void *x = p->x;
  switch (w) {
  case 16: rtcOccluded16(p->valid, scene, x, a); break;
  case 8: rtcOccluded8(p->valid, scene, x, a); break;
  case 4: rtcOccluded4(p->valid, scene, x, a); break;
  default: rtcOccluded1(scene, x, a);
  }
}

static void read_hit(const ylm_trace *t, const packet *p, unsigned w, unsigned i,
                     ylm_trace_hit *h) {
  const number *x = p->x;
  ylm__trace_name(t, x[FIELD(hit.geomID) * w + i].u, x[FIELD(hit.primID) * w + i].u, h);
  h->t = x[FIELD(ray.tfar) * w + i].f;
  h->u = x[FIELD(hit.u) * w + i].f;
  h->v = x[FIELD(hit.v) * w + i].f;
  for (unsigned a = 0; a < 3; a++) h->normal[a] = x[(FIELD(hit.Ng_x) + a) * w + i].f;
}

void ylm__trace_first(const ylm_trace *t, size_t scenes, const RTCScene *scene, size_t n,
                      const ylm_trace_ray *rays, bool coherent, ylm_trace_hit *hits) {
  packet p;
  uint8_t order[TRACE_STREAM];
  unsigned w = width_of(t->device);
  struct RTCIntersectArguments a;
  rtcInitIntersectArguments(&a);
  a.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  for (size_t first = 0; first < n; first += TRACE_STREAM) {
    unsigned count = n - first < TRACE_STREAM ? (unsigned)(n - first) : TRACE_STREAM;
    sort_rays(rays + first, count, order);
    for (unsigned from = 0; from < count; from += w) {
      unsigned m = load(&p, w, rays + first, order, from, count);
      for (unsigned i = 0; i < w; i++)
        p.x[FIELD(hit.geomID) * w + i].u = p.x[FIELD(hit.primID) * w + i].u =
            p.x[FIELD(hit.instID) * w + i].u = RTC_INVALID_GEOMETRY_ID;
      for (size_t k = 0; k < scenes; k++) intersect(&p, w, scene[k], &a);
      for (unsigned i = 0; i < m; i++) read_hit(t, &p, w, i, &hits[first + order[from + i]]);
    }
  }
}

void ylm__trace_any(const ylm_trace *t, RTCScene scene, size_t n, ylm_trace_ray *rays) {
  packet p;
  uint8_t order[TRACE_STREAM];
  unsigned w = width_of(t->device);
  struct RTCOccludedArguments a;
  rtcInitOccludedArguments(&a);
  for (size_t first = 0; first < n; first += TRACE_STREAM) {
    unsigned count = n - first < TRACE_STREAM ? (unsigned)(n - first) : TRACE_STREAM;
    a.flags = ylm__trace_is_coherent(count, rays + first) ? RTC_RAY_QUERY_FLAG_COHERENT
                                                          : RTC_RAY_QUERY_FLAG_INCOHERENT;
    sort_rays(rays + first, count, order);
    for (unsigned from = 0; from < count; from += w) {
      unsigned m = load(&p, w, rays + first, order, from, count);
      occlude(&p, w, scene, &a);
      for (unsigned i = 0; i < m; i++)
        rays[first + order[from + i]].far = p.x[FIELD(ray.tfar) * w + i].f;
    }
  }
}

/* Embree's context with what its callback needs. */
typedef struct filtered {
  struct RTCRayQueryContext context;
  ylm_trace_filter *filter;
  void *state;
} filtered;

/* Rays come one by one: N is 1. */
static void call_filter(const struct RTCFilterFunctionNArguments *a) {
  filtered *f = (filtered *)a->context;
  if (!f->filter(f->state, (struct RTCRay *)a->ray, (const struct RTCHit *)a->hit)) a->valid[0] = 0;
}

void ylm__trace_filtered(RTCScene scene, struct RTCRay ray, ylm_trace_filter *filter, void *state) {
  struct RTCRayHit r = {.ray = ray};
  filtered f = {.filter = filter, .state = state};
  struct RTCIntersectArguments a;
  rtcInitIntersectArguments(&a);
  rtcInitRayQueryContext(&f.context);
  a.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  a.context = &f.context;
  a.filter = call_filter;
  r.hit.geomID = r.hit.primID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene, &r, &a);
}
