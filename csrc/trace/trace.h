/* trace.h - what the files of csrc/trace share. Private. */
#ifndef YLM_TRACE_PRIVATE_H
#define YLM_TRACE_PRIVATE_H

#include <stddef.h>

#if YLM_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "calibration.h"
#include "ylm_trace.h"
#include "ylm_vector.h"

_Static_assert(sizeof(ylm_trace_ray) == sizeof(struct RTCRay), "ylm_trace_ray is Embree's ray");
_Static_assert(offsetof(ylm_trace_ray, dir) == offsetof(struct RTCRay, dir_x), "dir");
_Static_assert(offsetof(ylm_trace_ray, far) == offsetof(struct RTCRay, tfar), "far");

/* Trees: meshes that occlude; meshes that are only drawn; lamps. Structures that differ in lamps alone
   share device and meshes by Embree's counts of references. */
struct ylm_trace {
  RTCDevice device;
  RTCScene occluders, drawn, lamps;
  bool draws;      /* some mesh is only drawn */
  uint32_t meshes; /* geometry ids below are meshes; this one and the next two are lamps */
  uint32_t spheres, triangles;
  float lo[3], hi[3];
  float rounding;        /* twice the largest ylm_trace_lift of a triangle that occludes */
  const float *sphere;   /* [spheres][4], in Embree's memory */
  double reach, largest; /* of spheres: the farthest point from 0, the largest radius */
  /* Balls around lamps: centres, squared radii; 0: there are none, or too many. The last repeats to a multiple of 4. */
  uint32_t balls;
  float ball[4][TRACE_BALLS];
};

/* Sets what Embree wants of a ray beyond ylm_trace_ray. */
static inline void ylm__trace_prepare(struct RTCRay *r) {
  r->time = 0;
  r->mask = UINT32_MAX;
  r->id = r->flags = 0;
}

/* Whether the rays of a stream run alike, as those of neighbours to one lamp do: in most packets the first, the middle and the
   last have about one direction. */
static inline bool ylm__trace_is_coherent(size_t n, const ylm_trace_ray *rays) {
  size_t alike = 0, packets = n / TRACE_PACKET;
  for (size_t k = 0; k < packets; k++, rays += TRACE_PACKET) {
    const float *a = rays[0].dir, *b = rays[TRACE_PACKET / 2].dir, *c = rays[TRACE_PACKET - 1].dir;
    float least = TRACE_ALIKE * ylm_dot3(a, a), ab = ylm_dot3(a, b), ac = ylm_dot3(a, c);
    alike +=
        ab > 0 && ac > 0 && ab * ab > least * ylm_dot3(b, b) && ac * ac > least * ylm_dot3(c, c);
  }
  return 2 * alike > packets;
}

/* The lamp that primitive `primitive` of geometry `geometry` is. */
static inline uint32_t ylm__trace_lamp(const ylm_trace *t, uint32_t geometry, uint32_t primitive) {
  uint32_t kind = geometry - t->meshes; /* 0 sphere, 1 triangle, 2 disk */
  return primitive + (kind == 0 ? 0 : kind == 1 ? t->spheres : t->spheres + t->triangles);
}

/* Says in `h` which mesh or lamp was hit. */
static inline void ylm__trace_name(const ylm_trace *t, uint32_t geometry, uint32_t primitive,
                                   ylm_trace_hit *h) {
  bool nothing = geometry == RTC_INVALID_GEOMETRY_ID, lamp = !nothing && geometry >= t->meshes;
  h->mesh = nothing ? YLM_TRACE_NOTHING : lamp ? YLM_TRACE_LAMP : (int32_t)geometry;
  h->element = lamp ? ylm__trace_lamp(t, geometry, primitive) : primitive;
}

/* As ylm_trace_next_lamps. lamps.c */
size_t ylm__trace_gather(const ylm_trace *t, const ylm_trace_ray *ray,
                         const ylm_trace_meeting *after, size_t n, ylm_trace_meeting *met);

/* Encloses few lamps in balls. */
void ylm__trace_enclose(ylm_trace *t, const ylm_trace_lamps *lamps);
/* Sets far < 0 in rays that meet lamps, of those that come near a ball. */
void ylm__trace_look(const ylm_trace *t, size_t n, ylm_trace_ray *rays);

/* -- what differs between Embree 3 and 4: embree3.c, embree4.c --------------------- */

/* A flag of scenes whose rays may be filtered (ylm__trace_filtered). */
extern const enum RTCSceneFlags ylm__trace_filters;

/* First hits among `count` scenes. */
void ylm__trace_first(const ylm_trace *t, size_t count, const RTCScene *scene, size_t n,
                      const ylm_trace_ray *rays, bool coherent, ylm_trace_hit *hits);

/* Sets far < 0 in rays that meet a primitive of the scene. */
void ylm__trace_any(const ylm_trace *t, RTCScene scene, size_t n, ylm_trace_ray *rays);

/* A candidate: a primitive that the ray meets at ray->tfar, for `state`. False: the ray goes on as
   if it were not there; true: the ray goes on to the tfar that was set, no more than before. */
typedef bool ylm_trace_filter(void *state, struct RTCRay *ray, const struct RTCHit *hit);

/* Shows `filter` the primitives of the scene that one ray meets, some of them more than once. */
void ylm__trace_filtered(RTCScene scene, struct RTCRay ray, ylm_trace_filter *filter, void *state);

#endif
