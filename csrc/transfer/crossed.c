/*
** crossed.c - elements that a wall crosses: their light is that of their middle's side.
**
** Rays that hit the other side take a neighbour that is seen from there, so that no light passes under a wall, also where the wall
** ends closely above the surface: places that it covers are a side of their own.
*/
#include <math.h>

#include "calibration.h"
#include "transfer.h"

/* Whether nothing stands between two points. */
static bool sees(const ylm_transfer *t, const float a[3], const float b[3]) {
  ylm_trace_ray ray = {.far = 1};
  for (int k = 0; k < 3; k++) ray.org[k] = a[k], ray.dir[k] = b[k] - a[k];
  ylm_trace_occluded(ylm_scene_trace(t->scene), 1, &ray);
  return !(ray.far < 0);
}

/* A part of the width of an element. */
float ylm__transfer_lift(const ylm_transfer *t, size_t e) {
  return CROSSED_LIFT * fminf((float)t->form.spacing, sqrtf(2 * t->area[e]));
}

/* A place, and a point above it. */
typedef struct lifted {
  float at[3], above[3];
  bool covered; /* something is in between */
} lifted;

static lifted lift(const ylm_transfer *t, const ylm_scene_surface *at, float height) {
  lifted x;
  for (int a = 0; a < 3; a++) {
    x.at[a] = at->origin[a];
    x.above[a] = at->origin[a] + height * at->flat[a];
  }
  x.covered = !sees(t, x.at, x.above);
  return x;
}

/* Whether two places of a surface are on one side of all walls: of those that end closely above the surface, too. */
static bool is_beside(const ylm_transfer *t, const lifted *a, const lifted *b) {
  if (a->covered != b->covered || !sees(t, a->at, b->at)) return false;
  return a->covered || sees(t, a->above, b->above);
}

/* The middle of an element. */
static ylm_scene_place middle_of(const ylm_transfer *t, size_t e, float corner[3][2]) {
  ylm_scene_place place;
  ylm__transfer_corners(t, e, &place, corner);
  place.u = (corner[0][0] + corner[1][0] + corner[2][0]) / 3;
  place.v = (corner[0][1] + corner[1][1] + corner[2][1]) / 3;
  return place;
}

/* A wall that parts a triangle leaves a corner on the other side of its middle. */
static bool is_crossed(const ylm_transfer *t, size_t e) {
  float corner[3][2];
  ylm_scene_place place[4] = {middle_of(t, e, corner)};
  ylm_scene_surface at[4];
  for (int k = 0; k < 3; k++) {
    place[k + 1] = place[0];
    place[k + 1].u += CROSSED_WITHIN * (corner[k][0] - place[0].u);
    place[k + 1].v += CROSSED_WITHIN * (corner[k][1] - place[0].v);
  }
  ylm_scene_surfaces(t->scene, 4, place, at);
  float height = ylm__transfer_lift(t, e);
  lifted middle = lift(t, &at[0], height);
  for (int k = 1; k < 4; k++) {
    lifted other = lift(t, &at[k], height);
    if (!is_beside(t, &middle, &other)) return true;
  }
  return false;
}

static ylm_status look(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  ylm_transfer *t = context;
  for (size_t e = begin; e < end; e++) t->crossed[e] = is_crossed(t, e);
  return YLM_OK;
}

ylm_status ylm__transfer_cross(ylm_transfer *t, const ylm_progress *progress) {
  t->crossed = ylm_alloc_zero(t->elements, 1);
  if (!t->crossed) return YLM_ENOMEM;
  return ylm_parallel(t->elements, TRANSFER_GRAIN, t->form.threads, look, t, progress, "elements");
}

void ylm__transfer_hold(const ylm_transfer *t, size_t e, ylm_scene_place *place) {
  float corner[3][2];
  ylm_scene_surface at;
  if (!t->crossed[e]) return;
  float height = ylm__transfer_lift(t, e);
  ylm_scene_place middle = middle_of(t, e, corner);
  ylm_scene_surfaces(t->scene, 1, &middle, &at);
  lifted own = lift(t, &at, height);
  for (int tries = 0; tries < CROSSED_HALVES; tries++) {
    ylm_scene_surfaces(t->scene, 1, place, &at);
    lifted here = lift(t, &at, height);
    if (is_beside(t, &own, &here)) return;
    place->u = (place->u + middle.u) / 2;
    place->v = (place->v + middle.v) / 2;
  }
  *place = middle;
}

/* The element below a point that is lifted off a surface, where it faces as that does; or their number. */
static uint32_t below(const ylm_transfer *t, const float x[3], const float normal[3], float lift) {
  ylm_trace_ray ray = {.far = 2 * lift};
  ylm_trace_hit hit;
  for (int a = 0; a < 3; a++) ray.org[a] = x[a] + lift * normal[a], ray.dir[a] = -normal[a];
  ylm_trace_nearest(ylm_scene_trace(t->scene), 1, &ray, false, &hit);
  if (hit.mesh < 0) return (uint32_t)t->elements;
  bool back = ylm_dot3(hit.normal, ray.dir) > 0;
  float facing = ylm_dot3(hit.normal, normal) / sqrtf(ylm_dot3(hit.normal, hit.normal));
  if (!(fabsf(facing) > CROSSED_FACING)) return (uint32_t)t->elements;
  return ylm_transfer_element(t, &(ylm_scene_place){.mesh = (uint32_t)hit.mesh,
                                                    .element = hit.element,
                                                    .u = hit.u,
                                                    .v = hit.v,
                                                    .back = back});
}

static bool middle_sees(const ylm_transfer *t, uint32_t e, const lifted *x, float height) {
  float corner[3][2];
  ylm_scene_place place = middle_of(t, e, corner);
  ylm_scene_surface at;
  ylm_scene_surfaces(t->scene, 1, &place, &at);
  lifted middle = lift(t, &at, height);
  return is_beside(t, x, &middle);
}

uint32_t ylm__transfer_own(const ylm_transfer *t, uint32_t e, const ylm_scene_place *place) {
  static const float turn[5][2] = {
      {1, 0}, {0.70710678f, 0.70710678f}, {0.70710678f, -0.70710678f}, {0, 1}, {0, -1}};
  float corner[3][2], away[3], across[3];
  ylm_scene_surface at[2];
  ylm_scene_surfaces(t->scene, 2, (ylm_scene_place[]){*place, middle_of(t, e, corner)}, at);
  const float *x = at[0].origin, *n = at[0].flat;
  float height = ylm__transfer_lift(t, e);
  lifted here = lift(t, &at[0], height), own = lift(t, &at[1], height);
  if (is_beside(t, &here, &own)) return e;
  for (int a = 0; a < 3; a++) away[a] = x[a] - at[1].origin[a];
  float length = sqrtf(ylm_dot3(away, away)), spacing = (float)t->form.spacing;
  for (int a = 0; a < 3; a++) away[a] /= length;
  for (int a = 0; a < 3; a++)
    across[a] = n[(a + 1) % 3] * away[(a + 2) % 3] - n[(a + 2) % 3] * away[(a + 1) % 3];
  for (int step = 1; step <= CROSSED_STEPS; step++)
    for (int k = 0; k < 5; k++) {
      float y[3], far = spacing * (float)step / CROSSED_STEPS;
      for (int a = 0; a < 3; a++)
        y[a] = x[a] + far * (turn[k][0] * away[a] + turn[k][1] * across[a]);
      uint32_t other = below(t, y, n, height);
      if (other < t->elements && other != e && middle_sees(t, other, &here, height)) return other;
    }
  return (uint32_t)t->elements;
}
