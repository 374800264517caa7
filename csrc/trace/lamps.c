/* lamps.c - all lamps that a ray meets, some at a time; and whether it meets any of a few. */
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

/* -- few lamps --------------------------------------------------------------------------- */

/* Balls are larger than lamps, and closer to rays, by these parts of radii and positions and of the squared distance: far more
   than rounding here and in Embree. */
#define BALL_ROUNDING 1e-5

typedef float four __attribute__((vector_size(16)));
typedef int32_t four_bits __attribute__((vector_size(16)));
typedef int64_t two_bits __attribute__((vector_size(16)));

/* The ball over a triangle's longest edge reaches all three corners, or is widened. */
static double around_triangle(const float *corner, double centre[3]) {
  double longest = -1, reach2 = 0;
  for (int i = 0; i < 3; i++) {
    const float *p = corner + 3 * i, *q = corner + 3 * ((i + 1) % 3);
    double square = 0, mid[3];
    for (int a = 0; a < 3; a++) {
      mid[a] = ((double)p[a] + (double)q[a]) / 2;
      square += ((double)p[a] - (double)q[a]) * ((double)p[a] - (double)q[a]);
    }
    if (square > longest) longest = square, memcpy(centre, mid, sizeof mid);
  }
  for (int i = 0; i < 3; i++) {
    double square = 0;
    for (int a = 0; a < 3; a++) {
      double d = (double)corner[3 * i + a] - centre[a];
      square += d * d;
    }
    reach2 = fmax(reach2, square);
  }
  return sqrt(reach2);
}

static void put_ball(ylm_trace *t, const double centre[3], double radius) {
  uint32_t i = t->balls++;
  double reach = radius * (1 + BALL_ROUNDING);
  for (int a = 0; a < 3; a++) {
    t->ball[a][i] = (float)centre[a];
    reach += BALL_ROUNDING * fabs(centre[a]);
  }
  t->ball[3][i] = (float)(reach * reach * (1 + BALL_ROUNDING));
}

void ylm__trace_enclose(ylm_trace *t, const ylm_trace_lamps *l) {
  double centre[3] = {0};
  t->balls = 0;
  if (l->spheres > TRACE_BALLS || l->triangles > TRACE_BALLS || l->disks > TRACE_BALLS ||
      l->spheres + l->triangles + l->disks > TRACE_BALLS)
    return;
  for (size_t i = 0; i < l->spheres + l->disks; i++) {
    const float *round = i < l->spheres ? l->sphere + 4 * i : l->disk + 7 * (i - l->spheres);
    for (int a = 0; a < 3; a++) centre[a] = (double)round[a];
    put_ball(t, centre, (double)round[3]);
  }
  for (size_t i = 0; i < l->triangles; i++) {
    double radius = around_triangle(l->triangle + 9 * i, centre);
    put_ball(t, centre, radius);
  }
  for (; t->balls % 4 > 0; t->balls++)
    for (int k = 0; k < 4; k++) t->ball[k][t->balls] = t->ball[k][t->balls - 1];
}

static inline four load(const float *p) {
  four v;
  memcpy(&v, p, sizeof v);
  return v;
}

/* Whether a ray comes near a ball. Each way to pass one by is a comparison that no number which is none fulfils. */
static inline bool comes_near(const ylm_trace *t, const ylm_trace_ray *ray) {
  const float *d = ray->dir;
  const four zero = {0};
  float length2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], far = ray->far;
  for (uint32_t i = 0; i < t->balls; i += 4) {
    four x = load(t->ball[0] + i) - ray->org[0], y = load(t->ball[1] + i) - ray->org[1];
    four z = load(t->ball[2] + i) - ray->org[2], apart2 = x * x + y * y + z * z;
    four along = x * d[0] + y * d[1] + z * d[2];
    four most = load(t->ball[3] + i) + (float)BALL_ROUNDING * apart2;
    four at_end2 = apart2 - 2 * far * along + far * far * length2;
    four_bits aside = apart2 * length2 - along * along > most * length2;
    four_bits behind = (along < zero) & (apart2 > most);
    four_bits beyond = (along > far * length2 + zero) & (at_end2 > most);
    two_bits away = (two_bits)(aside | behind | beyond);
    if ((away[0] & away[1]) != -1) return true;
  }
  return false;
}

void ylm__trace_look(const ylm_trace *t, size_t n, ylm_trace_ray *rays) {
  ylm_trace_ray near[TRACE_STREAM];
  size_t of[TRACE_STREAM];
  for (size_t i = 0; i < n;) {
    size_t count = 0;
    for (; i < n && count < TRACE_STREAM; i++)
      if (comes_near(t, &rays[i])) near[count] = rays[i], of[count++] = i;
    ylm__trace_any(t, t->lamps, count, near);
    for (size_t k = 0; k < count; k++) rays[of[k]].far = near[k].far;
  }
}
