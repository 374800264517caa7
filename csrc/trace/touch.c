/* touch.c - the triangle that a point lies on, as far as rounding tells. */
#include <math.h>

#include "trace.h"
#include "ylm_vector.h"

/* The best triangle so far. */
typedef struct touched {
  RTCScene scene;
  double x[3], normal[3], radius, score;
  ylm_trace_hit *hit;
} touched;

static double clamp(double x, double most) { return x > 0 ? fmin(x, most) : 0; }

/* Where x lies on a triangle with edges e from a corner that is `to` away from x, or beside it; returns
   how far that is from x. */
static double place_on(const double to[3], double e[2][3], double *u, double *v) {
  double g[2] = {0, 0}, h[3] = {0, 0, 0}, d = 0;
  for (int a = 0; a < 3; a++) {
    for (int i = 0; i < 2; i++) g[i] += to[a] * e[i][a];
    h[0] += e[0][a] * e[0][a], h[1] += e[0][a] * e[1][a], h[2] += e[1][a] * e[1][a];
  }
  double det = h[0] * h[2] - h[1] * h[1];
  if (!(det > 0)) return INFINITY;
  *u = clamp((g[0] * h[2] - g[1] * h[1]) / det, 1);
  *v = clamp((g[1] * h[0] - g[0] * h[1]) / det, 1 - *u);
  for (int a = 0; a < 3; a++) {
    double way = to[a] - *u * e[0][a] - *v * e[1][a];
    d += way * way;
  }
  return sqrt(d);
}

/* Embree shows triangles near x: the one that faces the normal best is kept, of equal ones the nearest. */
static bool look_at(struct RTCPointQueryFunctionArguments *a) {
  touched *t = a->userPtr;
  RTCGeometry g = rtcGetGeometry(t->scene, a->geomID);
  const uint32_t *k = rtcGetGeometryBufferData(g, RTC_BUFFER_TYPE_INDEX, 0);
  const float *vertex = rtcGetGeometryBufferData(g, RTC_BUFFER_TYPE_VERTEX, 0), *p[3];
  double to[3], e[2][3], n[3], u = 0, v = 0;
  for (int i = 0; i < 3; i++) p[i] = vertex + 3 * (size_t)k[3 * (size_t)a->primID + (size_t)i];
  for (int c = 0; c < 3; c++) {
    to[c] = t->x[c] - (double)p[0][c];
    for (int i = 0; i < 2; i++) e[i][c] = (double)p[i + 1][c] - (double)p[0][c];
  }
  double distance = place_on(to, e, &u, &v);
  ylm_cross3d(e[0], e[1], n);
  double score = fabs(ylm_dot3d(n, t->normal)) / sqrt(ylm_dot3d(n, n)) - distance / t->radius / 1e3;
  if (!(distance <= 2 * t->radius && score > t->score)) return false;
  t->score = score;
  *t->hit = (ylm_trace_hit){.mesh = (int32_t)a->geomID,
                            .element = a->primID,
                            .t = (float)distance,
                            .u = (float)u,
                            .v = (float)v,
                            .normal = {(float)n[0], (float)n[1], (float)n[2]}};
  return false;
}

bool ylm_trace_touch(const ylm_trace *t, const float x[3], const float normal[3],
                     ylm_trace_hit *hit) {
  touched best = {.scene = t->occluders, .radius = (double)ylm_trace_offset(t, x), .hit = hit};
  struct RTCPointQuery q = {.x = x[0], .y = x[1], .z = x[2], .radius = (float)best.radius};
  struct RTCPointQueryContext context;
  for (int a = 0; a < 3; a++) best.x[a] = (double)x[a], best.normal[a] = (double)normal[a];
  rtcInitPointQueryContext(&context);
  rtcPointQuery(t->occluders, &q, &context, look_at, &best);
  return best.score > 0;
}
