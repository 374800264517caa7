/*
** bias.c - looking a grid up beside surfaces, where its light jumps at them.
**
** A voxel of edges h is h_x |n_x| + h_y |n_y| + h_z |n_z| thick along n. A voxel that far from a plane with normal n lies
** on one side of it. The value is carried back to the surface by the interpolant's gradient.
*/
#include "../grid.h"
#include "calibration.h"

#include <math.h>
#include <string.h>

/* The thickness along n of the octree's leaf at p. */
static double thickness(const ylm_grid *g, const double p[3], const float n[3]) {
  bool uniform = g->contents.form.kind == YLM_GRID_UNIFORM;
  uint32_t edge = uniform ? 1 : ylm__grid_edge(g, &g->cell[ylm_grid_locate(g, p, false, NULL)]);
  double sum = 0;
  for (int a = 0; a < 3; a++) sum += (double)edge / g->scale[a] * fabs((double)n[a]);
  return sum;
}

/* The position of x, which is relative to an origin. */
static void outward(const float x[3], const double origin[3], double p[3]) {
  for (int a = 0; a < 3; a++) p[a] = (double)x[a] + origin[a];
}

/* How far off point p on a surface with normal n a grid is looked up, without a limit. */
static double bias_at(const ylm_grid *g, double factor, const double p[3], const float n[3]) {
  double q[3], b = factor * thickness(g, p, n);
  for (int look = 0; look < BIAS_LOOKS; look++) {
    for (int a = 0; a < 3; a++) q[a] = p[a] + b * (double)n[a];
    double further = factor * thickness(g, q, n);
    if (!(further > b)) break;
    b = further;
  }
  return b;
}

/* p relative to the origin of a scene's surfaces. */
static void enter(const ylm_grid_reach *r, const double p[3], float x[3]) {
  for (int a = 0; a < 3; a++) x[a] = (float)(p[a] - (r->origin ? r->origin[a] : 0));
}

/* Two directions at right angles to n, along axes where n is. */
static void tangents(const float n[3], float t[2][3]) {
  int least = 0;
  for (int a = 1; a < 3; a++)
    if (fabsf(n[a]) < fabsf(n[least])) least = a;
  float sum = 0;
  for (int a = 0; a < 3; a++) t[0][a] = (float)(a == least) - n[a] * n[least];
  for (int a = 0; a < 3; a++) sum += t[0][a] * t[0][a];
  for (int a = 0; a < 3; a++) t[0][a] /= sqrtf(sum);
  for (int a = 0; a < 3; a++)
    t[1][a] = n[(a + 1) % 3] * t[0][(a + 2) % 3] - n[(a + 2) % 3] * t[0][(a + 1) % 3];
}

/* Moves a place away from surfaces that are nearer along +-t than a voxel is thick. */
static void move_away(const ylm_grid *g, double factor, const double origin[3],
                      const ylm_grid_reach *r, const float t[3], float place[3]) {
  double p[3], by;
  float back[3] = {-t[0], -t[1], -t[2]}, from[3];
  outward(place, origin, p);
  enter(r, p, from);
  double far = factor * thickness(g, p, t);
  double there = r->distance(r->self, from, t, far), here = r->distance(r->self, from, back, far);
  if (there < far && here < far)
    by = 0.5 * (there - here);
  else
    by = (far - here) - (far - there);
  for (int a = 0; a < 3; a++) place[a] += (float)by * t[a];
}

/* Half of the distance from x on a surface to the next along its normal n, as far as 2 b. */
static double halfway(const ylm_grid_reach *r, const double p[3], const float n[3], double b) {
  float off[3];
  enter(r, p, off);
  for (int a = 0; a < 3; a++) off[a] += (float)(1e-3 * b) * n[a];
  return 0.5 * r->distance(r->self, off, n, 2 * b);
}

void ylm__grid_beside(const ylm_grid *g, double factor, const double origin[3], const float x[3],
                      const float n[3], double limit, const ylm_grid_reach *reach, float place[3]) {
  float t[2][3];
  double p[3];
  outward(x, origin, p);
  double b = fmin(bias_at(g, factor, p, n), limit);
  if (reach && b > 0 && isinf(limit)) b = fmin(b, halfway(reach, p, n, b));
  for (int a = 0; a < 3; a++) place[a] = x[a] + (float)b * n[a];
  if (!reach || !(b > 0)) return;
  tangents(n, t);
  for (int k = 0; k < 2; k++) move_away(g, factor, origin, reach, t[k], place);
}

typedef struct bias_job {
  const ylm_grid *g;
  double factor;
  const double *origin;
  const float (*points)[3], (*normals)[3];
  const float *limit;
  const ylm_grid_reach *reach;
  float (*places)[3];
} bias_job;

static ylm_status find_places(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const bias_job *j = context;
  for (size_t i = begin; i < end; i++)
    ylm__grid_beside(j->g, j->factor, j->origin, j->points[i], j->normals[i],
                     j->limit ? (double)j->limit[i] : INFINITY, j->reach, j->places[i]);
  return YLM_OK;
}

void ylm_grid_bias(const ylm_grid *g, double factor, const double *origin, size_t n,
                   const float (*points)[3], const float (*normals)[3], const float *limit,
                   const ylm_grid_reach *reach, float (*places)[3], int threads) {
  const double zero[3] = {0};
  bias_job j = {g, factor, origin ? origin : zero, points, normals, limit, reach, places};
  if (factor > 0)
    ylm_parallel(n, BIAS_GRAIN, threads, find_places, &j, NULL, NULL);
  else
    ylm_copy(places, points, n * sizeof *places);
}

/* Shortens the way d so that the mean light of no channel changes by more than BIAS_CARRY of itself on it: a gradient
   across the edge of a shadow would carry light below zero. */
static void shorten(const ylm_grid *g, const float *value, const float *gradient, float d[3]) {
  size_t count = g->width / (size_t)g->contents.form.channels;
  float t = 1;
  for (size_t k = 0; k < g->width; k += count) {
    float change = fabsf(carried(value[k], d, gradient + 3 * k) - value[k]);
    float most = BIAS_CARRY * fabsf(value[k]);
    if (most < t * change) t = most / change;
  }
  for (int a = 0; t < 1 && a < 3; a++) d[a] *= t;
}

ylm_status ylm_grid_sample_biased(const ylm_grid *g, const ylm_grid_query *q, size_t n,
                                  const float (*points)[3], const float (*places)[3], float *value,
                                  ylm_grid_report *report, ylm_error *e) {
  size_t w = g->width;
  ylm_grid_query own = *q;
  float *gradient = ylm_alloc(n, 3 * w * sizeof *gradient);
  ylm_status s = gradient ? YLM_OK : YLM_ENOMEM;
  own.point_dtype = own.dtype = YLM_FLOAT;
  if (s == YLM_OK) s = ylm_grid_sample(g, &own, n, places, value, gradient, report, e);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    float d[3];
    for (int a = 0; a < 3; a++) d[a] = points[i][a] - places[i][a];
    bool moved = d[0] != 0 || d[1] != 0 || d[2] != 0;
    if (moved) shorten(g, value + i * w, gradient + 3 * i * w, d);
    for (size_t k = 0; moved && k < w; k++)
      value[i * w + k] = carried(value[i * w + k], d, gradient + 3 * (i * w + k));
  }
  ylm_free(gradient);
  return s == YLM_ENOMEM ? ylm_fail(e, s, "no memory to sample %zu points", n) : s;
}
