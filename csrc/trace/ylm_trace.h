/*
** ylm_trace.h - what a ray hits: meshes that occlude and lamps that are only seen.
**
** Ownership   ylm_trace_create copies what it is given.
** Threads     a ylm_trace is read-only after creation; any number of threads may ask at once.
** Numerics    rays are traced with denormal numbers taken as zero; the caller's floating-point
**             mode is restored before each function returns.
*/
#ifndef YLM_TRACE_H
#define YLM_TRACE_H

#include "ylm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ylm_trace ylm_trace;

/* Triangles to be traced. */
typedef struct ylm_trace_mesh {
  const float *positions; /* [vertices][3]       scene units  */
  size_t vertices;
  const uint32_t *triangles; /* [count][3]          < vertices   */
  size_t count;
  bool occludes; /* false: seen by primary rays, ignored by occlusion rays */
} ylm_trace_mesh;

/* Lamps that primary rays see, from both sides. Hits count them as elements: spheres, then
   triangles, then disks. */
typedef struct ylm_trace_lamps {
  size_t spheres, triangles, disks;
  const float *sphere;   /* [spheres][4]    centre, radius >= 0         */
  const float *triangle; /* [triangles][9]  three corners               */
  const float *disk;     /* [disks][7]      centre, radius >= 0, normal */
} ylm_trace_lamps;

/* A ray from org + near*dir to org + far*dir. `reserved` need not be set. 16-byte aligned. Numbers are finite, but that far may be
   infinite; org is within YLM_TRACE_EXTENT: this is not checked ray by ray (ylm_trace_check does). */
typedef struct ylm_trace_ray {
  float org[3], near;
  float dir[3], reserved;
  float far;
  uint32_t internal[3];
} __attribute__((aligned(16), may_alias)) ylm_trace_ray;

/* The first hit of a ray. */
typedef struct ylm_trace_hit {
  int32_t mesh;     /* index of the mesh, YLM_TRACE_NOTHING or YLM_TRACE_LAMP */
  uint32_t element; /* the triangle in its mesh, or the lamp */
  float t;          /* distance in lengths of dir */
  float u, v;       /* weights of the triangle's second and third corner */
  float normal[3];  /* of the triangle by its winding, not normalised */
} ylm_trace_hit;

enum { YLM_TRACE_NOTHING = -1, YLM_TRACE_LAMP = -2 };

/*
** ylm_trace_create - build the structures that rays are traced through.
**
**   meshes   in   [mesh_count]     finite positions
**   lamps    in   what primary rays see and occlusion rays do not
**   out      out  to be freed with ylm_trace_free
**
** Returns  YLM_OK; YLM_EINVAL (an index >= vertices), YLM_EDOMAIN (not finite, radius < 0),
**          YLM_EOVERFLOW (2^32 triangles), YLM_ENOMEM, YLM_EDEVICE (Embree refuses)
** Cost     about 1 s per million triangles, on one thread, so that the tree, and with it which of
**          two equally near triangles is hit, does not depend on the machine
*/
YLM_API ylm_status ylm_trace_create(size_t mesh_count, const ylm_trace_mesh *meshes,
                                    const ylm_trace_lamps *lamps, ylm_trace **out, ylm_error *e);
YLM_API void ylm_trace_free(ylm_trace *t);

/*
** ylm_trace_relight - the same meshes with other lamps.
**
** The two share the meshes' trees, which live until both are freed.
**
** Returns  as ylm_trace_create
** Cost     less than 1 us a lamp; nothing grows with the meshes
*/
YLM_API ylm_status ylm_trace_relight(const ylm_trace *t, const ylm_trace_lamps *lamps,
                                     ylm_trace **out, ylm_error *e);

/* The farthest that a ray may start from 0, along an axis: Embree's numbers end at 1.8e18. */
#define YLM_TRACE_EXTENT 1e15
/* Refuses places [n][3] of type t that rays cannot start from: YLM_EDOMAIN (not finite), YLM_ERANGE (beyond
   YLM_TRACE_EXTENT): `e` names the row, counted from 1, as a `what`. */
YLM_API ylm_status ylm_trace_check(ylm_dtype t, size_t n, const void *x, const char *what,
                                   ylm_error *e);

/* Box around the meshes, lamps left out; all zero where there are none. */
YLM_API void ylm_trace_bounds(const ylm_trace *t, float lo[3], float hi[3]);

/*
** ylm_trace_lift - how far off a triangle a ray starts that does not meet it again.
**
**   2^-22 (longest edge + radius of the circle through the corners, at most 32 edges)
**
** The test of a ray subtracts the ray's origin from the corners: its rounding grows with the triangle,
** not with its distance from 0. Rays upwards from random places of random triangles need half of this
** at most (slivers lower than a 256th of their longest edge apart, which may shadow themselves).
**
**   p  in  [3] the corners, in scene units
*/
YLM_API double ylm_trace_lift(const float *const p[3]);

/* How far off the surfaces near x rays start and end where no triangle is known: the rounding of x and
   the lift of the largest triangle that occludes, twice. */
YLM_API float ylm_trace_offset(const ylm_trace *t, const float x[3]);

/* The triangle of an occluding mesh that x lies on, as far as its rounding tells, and the place on it
   that is nearest: of several the one that faces the normal best. False: there is none. */
YLM_API bool ylm_trace_touch(const ylm_trace *t, const float x[3], const float normal[3],
                             ylm_trace_hit *hit);

/* The first hit of each of n rays among all meshes and lamps. `coherent`: they run alike. */
YLM_API void ylm_trace_intersect(const ylm_trace *t, size_t n, const ylm_trace_ray *rays,
                                 bool coherent, ylm_trace_hit *hits);

/* The first hit of each of n rays among meshes that occlude: lamps, and meshes that do not occlude,
   are not there. Where nothing is hit t is the ray's far. */
YLM_API void ylm_trace_nearest(const ylm_trace *t, size_t n, const ylm_trace_ray *rays,
                               bool coherent, ylm_trace_hit *hits);

/* A lamp that a ray meets, and where: in lengths of dir. */
typedef struct ylm_trace_meeting {
  float distance;
  uint32_t lamp; /* counted as hits count lamps */
} ylm_trace_meeting;

/*
** ylm_trace_next_lamps - the next lamps that a ray meets: no lamp hides another.
**
** A ray meets a lamp at most once: a sphere where it enters it, or where it leaves it if it starts
** inside or on it; a triangle or a disk where it crosses it, from either side. Lamps count whose
** distance is from `near` to `far`. They come in the order of their distances, at equal ones in the
** order of their numbers; a lamp that is given twice is met twice, under two numbers.
**
**   ray    in   one ray; not changed
**   after  in   the last meeting of the call before; NULL: from the ray's start
**   n      in   how many are wanted, 16 at best: that is fast along rays that meet hundreds
**   met    out  [n]  those after `after`; may hold `after`
**
** Returns  how many there are; fewer than n: no more are left
** Cost     a walk through the tree of lamps a call; no allocation
*/
YLM_API size_t ylm_trace_next_lamps(const ylm_trace *t, const ylm_trace_ray *ray,
                                    const ylm_trace_meeting *after, size_t n,
                                    ylm_trace_meeting *met);

/* Sets far < 0 in each of n rays that may meet a lamp: the others meet none. */
YLM_API void ylm_trace_meets_lamps(const ylm_trace *t, size_t n, ylm_trace_ray *rays);

/* Sets far < 0 in each of n rays that meets an occluding mesh; lamps never do. */
YLM_API void ylm_trace_occluded(const ylm_trace *t, size_t n, ylm_trace_ray *rays);

#ifdef __cplusplus
}
#endif
#endif
