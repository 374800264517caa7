/*
** occlusion.h - what the files of an occlusion by rays share. Private.
**
** rim.c finds the rim of a body, seen from a point, as arcs of great circles; occlusion.c integrates over it.
*/
#ifndef YLM_TRACE_OCCLUSION_H
#define YLM_TRACE_OCCLUSION_H

#include "trace.h"
#include "ylm_trace_occlusion.h"

/* Halvings of the way between a direction that hits and one that misses. */
#define RIM_HALVINGS 8

/* A direction on the rim, and the distance of what stands there. */
typedef struct rim_point {
  double w[3], t;
} rim_point;

/* An arc of the rim; the body is to the left of the way from a to b, seen from outside of the sphere of directions. */
typedef struct rim_arc {
  rim_point a, b;
} rim_arc;

/* Directions: origin + x across + y up, -1 <= x, y <= 1; (across, up, middle) is right-handed. */
typedef struct rim_map {
  double middle[3], across[3], up[3];
  double cosine; /* directions farther from the middle are not traced; -2: all are */
  int cells;     /* along each edge */
} rim_map;

/* Memory of one thread, which points use one after the other. */
typedef struct rim_room {
  size_t nodes, found_room, arcs_room;
  double *at;     /* [cells + 1] places of nodes along an edge */
  uint8_t *hit;   /* [nodes] */
  uint32_t *edge; /* [2][nodes] found place on the edge to the right, and upwards, of each node */
  ylm_trace_ray *ray;  /* [largest of nodes of a row and found places] */
  ylm_trace_hit *meet; /* as many */
  struct rim_found *found;
  rim_arc *arc;
  size_t founds, arcs;
} rim_room;

/* The arcs of a map's part of the rim are added to room->arc. `hit` grows by about the solid angle that is hit, in sr. */
ylm_status ylm__rim_find(const ylm_trace *t, const double p[3], const rim_map *m, rim_room *room,
                         double *hit);
void ylm__rim_free(rim_room *room);

#endif
