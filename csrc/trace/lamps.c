/* lamps.c - all lamps that a ray meets, some at a time. */
#include <math.h>
#include <string.h>

#include "trace.h"

/* The nearest n lamps beyond `after` so far, nearest first. */
typedef struct gathered {
  const ylm_trace *trace;
  const ylm_trace_ray *ray;
  ylm_trace_meeting after;
  ylm_trace_meeting *met;
  size_t n, count;
  double margin; /* Embree's distances of spheres differ from sphere_distance by less */
  float limit;   /* how far the ray still goes */
} gathered;

static bool before(ylm_trace_meeting a, ylm_trace_meeting b) {
  return a.distance < b.distance || (a.distance == b.distance && a.lamp < b.lamp);
}

/* Where a ray that meets a sphere enters it, or leaves it if it starts inside: as choosers aim at
   spheres (csrc/scene/lamps.c), whichever of the two crossings Embree came upon. */
static float sphere_distance(const float s[4], const ylm_trace_ray *ray) {
  double v[3], d2 = 0, length2 = 0, along = 0, aside = 0, r = (double)s[3];
  for (int a = 0; a < 3; a++) {
    double d = (double)ray->dir[a];
    v[a] = (double)s[a] - (double)ray->org[a];
    d2 += v[a] * v[a];
    length2 += d * d;
    along += v[a] * d;
  }
  along /= length2;
  for (int a = 0; a < 3; a++) {
    double p = v[a] - along * (double)ray->dir[a];
    aside += p * p;
  }
  double half = sqrt(fmax(0, r * r - aside) / length2);
  return (float)fmax(0, d2 <= r * r ? along + half : along - half);
}

/* Puts a lamp into its place among the nearest; Embree may show one several times. */
static bool gather(void *state, struct RTCRay *ray, const struct RTCHit *hit) {
  gathered *g = state;
  ylm_trace_meeting m = {ray->tfar, ylm__trace_lamp(g->trace, hit->geomID, hit->primID)};
  if (m.lamp < g->trace->spheres)
    m.distance = sphere_distance(g->trace->sphere + 4 * (size_t)m.lamp, g->ray);
  if (!(m.distance >= g->ray->near && m.distance <= g->ray->far) || !before(g->after, m))
    return false;
  size_t i = g->count;
  while (i > 0 && before(m, g->met[i - 1])) i--;
  if (i == g->n || (i > 0 && !before(g->met[i - 1], m))) return false;
  if (g->count < g->n) g->count++;
  memmove(g->met + i + 1, g->met + i, (g->count - 1 - i) * sizeof *g->met);
  g->met[i] = m;
  if (g->count < g->n) return false;
  g->limit = fminf(g->limit, (float)((double)g->met[g->n - 1].distance + g->margin));
  ray->tfar = g->limit;
  return true;
}

/* Embree's distance of a crossing is rounded as numbers of the size of the way to the centre are;
   of a grazed sphere it is the root of that. */
static double margin_of(const ylm_trace *t, const ylm_trace_ray *ray) {
  const float *o = ray->org, *d = ray->dir;
  double length = sqrt((double)d[0] * d[0] + (double)d[1] * d[1] + (double)d[2] * d[2]);
  double way = t->reach + sqrt((double)o[0] * o[0] + (double)o[1] * o[1] + (double)o[2] * o[2]);
  return (2e-6 * way + sqrt(2e-6 * way * t->largest)) / length;
}

size_t ylm__trace_gather(const ylm_trace *t, const ylm_trace_ray *ray,
                         const ylm_trace_meeting *after, size_t n, ylm_trace_meeting *met) {
  gathered g = {.trace = t, .ray = ray, .after = {-1, 0}, .met = met, .n = n};
  if (after) g.after = *after;
  g.margin = margin_of(t, ray);
  g.limit = (float)((double)ray->far + g.margin);
  struct RTCRay r;
  memcpy(&r, ray, sizeof r);
  ylm__trace_prepare(&r);
  r.tnear = fmaxf(ray->near, (float)((double)g.after.distance - g.margin));
  r.tfar = g.limit;
  if (n > 0) ylm__trace_filtered(t->lamps, r, gather, &g);
  return g.count;
}
