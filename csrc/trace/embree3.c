/* embree3.c - rays through Embree 3 (Wald et al. 2014): streams. */
#include <string.h>

#include "calibration.h"
#include "trace.h"

const enum RTCSceneFlags ylm__trace_filters = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

static void prepare_hit(struct RTCHit *h) {
  h->geomID = h->primID = h->instID[0] = RTC_INVALID_GEOMETRY_ID;
}

static struct RTCIntersectContext context_for(bool coherent) {
  struct RTCIntersectContext c;
  rtcInitIntersectContext(&c);
  c.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return c;
}

static void read_hit(const ylm_trace *t, const struct RTCRayHit *r, ylm_trace_hit *h) {
  ylm__trace_name(t, r->hit.geomID, r->hit.primID, h);
  h->t = r->ray.tfar;
  h->u = r->hit.u;
  h->v = r->hit.v;
  h->normal[0] = r->hit.Ng_x;
  h->normal[1] = r->hit.Ng_y;
  h->normal[2] = r->hit.Ng_z;
}

void ylm__trace_first(const ylm_trace *t, size_t scenes, const RTCScene *scene, size_t n,
                      const ylm_trace_ray *rays, bool coherent, ylm_trace_hit *hits) {
  struct RTCRayHit r[TRACE_STREAM];
  for (size_t first = 0; first < n; first += TRACE_STREAM) {
    unsigned count = n - first < TRACE_STREAM ? (unsigned)(n - first) : TRACE_STREAM;
    for (unsigned i = 0; i < count; i++) {
      memcpy(&r[i].ray, &rays[first + i], sizeof r[i].ray);
      ylm__trace_prepare(&r[i].ray);
      prepare_hit(&r[i].hit);
    }
    struct RTCIntersectContext c = context_for(coherent);
    for (size_t k = 0; k < scenes; k++) rtcIntersect1M(scene[k], &c, r, count, sizeof r[0]);
    for (unsigned i = 0; i < count; i++) read_hit(t, &r[i], &hits[first + i]);
  }
}

void ylm__trace_any(const ylm_trace *t, RTCScene scene, size_t n, ylm_trace_ray *rays) {
  (void)t;
  for (size_t first = 0; first < n; first += TRACE_STREAM) {
    unsigned count = n - first < TRACE_STREAM ? (unsigned)(n - first) : TRACE_STREAM;
    struct RTCRay *r = (struct RTCRay *)&rays[first];
    struct RTCIntersectContext c = context_for(ylm__trace_is_coherent(count, &rays[first]));
    for (unsigned i = 0; i < count; i++) ylm__trace_prepare(&r[i]);
    rtcOccluded1M(scene, &c, r, count, sizeof r[0]);
  }
}

/* Embree's context with what its callback needs. */
typedef struct filtered {
  struct RTCIntersectContext context;
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
  filtered f = {context_for(false), filter, state};
  f.context.filter = call_filter;
  prepare_hit(&r.hit);
  rtcIntersect1(scene, &f.context, &r);
}
